//! What surfaces look like, a block of pixels at a time: where rays meet them, their attributes and reflectance, and the
//! light that reaches them.

mod brdf;
pub(crate) mod glass;
pub(crate) mod gloss;
mod hits;
mod irradiance;
pub(crate) mod lanes;
mod paint;
mod rays;
mod specular_albedo;
mod surface;

pub(crate) use brdf::{Gloss, Reflectance, SeenReflectance};
pub(crate) use hits::BlockHits;
pub(crate) use irradiance::arriving;
pub(crate) use rays::{Block, BlockRays};
#[cfg(feature = "gpu")]
pub(crate) use specular_albedo::specular_albedo_table;
pub(crate) use surface::{Footprint, Surface};
