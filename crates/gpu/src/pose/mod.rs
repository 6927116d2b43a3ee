//! Animated vertices: shapes stay on the GPU, and matrices and weights pose them there.

#[allow(clippy::module_inception, reason = "the stage has the name of what it does, as all stages have")]
mod pose;
mod tables;

pub use pose::{Pose, PosedAttributes};
pub use tables::{Deltas, Influences, PosePart, PoseShape, RigPart, RigShape, RigTables, RigTarget};
