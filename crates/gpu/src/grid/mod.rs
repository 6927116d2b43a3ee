//! What the camera's grid and the lights' grids share: pixel space, and the listing of triangles by cell.

mod list;
mod space;
mod transform;

pub(crate) use list::{HEADER_WORDS, Header, List, ListBuffers};
pub(crate) use space::Space;
pub(crate) use transform::Transform;
