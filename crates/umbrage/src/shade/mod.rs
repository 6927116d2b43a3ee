//! What a surface looks like: its attributes at a hit, its reflectance and the light that reaches it.

mod brdf;
mod irradiance;
mod specular_albedo;
mod surface;

pub(crate) use brdf::Reflectance;
pub(crate) use irradiance::arriving;
#[cfg(feature = "gpu")]
pub(crate) use specular_albedo::specular_albedo_table;
pub(crate) use surface::{Footprint, Surface};
