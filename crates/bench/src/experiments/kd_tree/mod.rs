//! The experiments of Horn et al. 2007 and of the thesis with kd-trees, one a file.

mod ablations;
mod bounces;
mod builders;
mod entries;
mod frames;
mod gpu;
mod measure;
mod moving;
mod scaling;
mod traversals;

pub(crate) use ablations::KdAblationsFlags;
pub(crate) use bounces::KdBouncesFlags;
pub(crate) use builders::KdBuildersFlags;
pub(crate) use entries::KdEntriesFlags;
pub(crate) use frames::KdFramesFlags;
pub(crate) use gpu::KdGpuFlags;
pub(super) use measure::frame;
pub(crate) use moving::KdMovingFlags;
pub(crate) use scaling::KdScalingFlags;
pub(crate) use traversals::KdTraversalsFlags;
