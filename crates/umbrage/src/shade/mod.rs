//! The look of surfaces, a block of pixels at a time: hits of rays, their attributes and reflectance, and the light that
//! reaches them.

mod albedo;
mod brdf;
mod coat;
mod film;
pub(crate) mod glass;
pub(crate) mod gloss;
mod grooves;
mod hits;
mod irradiance;
pub(crate) mod lanes;
mod layer_paint;
mod layers;
mod paint;
mod rays;
mod sheen;
mod surface;
mod texels;
pub(crate) mod transcendental;
mod triangles;

#[cfg(feature = "gpu")]
pub(crate) use albedo::specular_albedo_table;
pub(crate) use brdf::{Reflectance, SMOOTHEST, SeenReflectance};
pub(crate) use hits::{BlockHits, SeenTriangles};
pub(crate) use irradiance::Emitter;
pub(crate) use rays::{Block, BlockRays};
#[cfg(feature = "gpu")]
pub(crate) use sheen::sheen_albedo_table;
pub(crate) use surface::{Footprint, Surface};
