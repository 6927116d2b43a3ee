//! Code shared by the camera's grid and the lights' grids: pixel space, and the listing of triangles by cell.

pub(crate) mod header;
mod list;
mod project;
mod space;

pub(crate) use list::{List, ListBuffers, ListKernels};
pub(crate) use project::Project;
pub(crate) use space::{Space, words};
