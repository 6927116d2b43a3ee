//! The experiments of Wald et al. 2006 with the uniform grid and its packets, one a file.

mod culling;
mod density;
mod measure;
mod models;
mod nested;
mod options;
mod packets;
mod resolution;

pub(crate) use culling::CullingFlags;
pub(crate) use density::DensityFlags;
pub(crate) use models::ModelsFlags;
pub(crate) use nested::NestedFlags;
pub(crate) use options::GridOptionsFlags;
pub(crate) use packets::PacketsFlags;
pub(crate) use resolution::ResolutionFlags;
