//! What the camera's grid and the lights' grids share: pixel space, and the listing of triangles by cell.

pub(crate) mod header;
mod list;
mod space;
mod transform;

pub(crate) use list::{List, ListBuffers, ListNames};
pub(crate) use space::{Space, words};
pub(crate) use transform::Transform;
