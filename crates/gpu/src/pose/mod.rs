//! Vertices that move: what they are made from stays on the GPU, and matrices and weights move them there.

#[allow(clippy::module_inception, reason = "the stage has the name of what it does, as all stages have")]
mod pose;
mod tables;

pub use pose::{Pose, PosedAttributes};
pub use tables::{Deltas, Influences, PosePart, PoseShape, RigPart, RigShape, RigTables, RigTarget};
