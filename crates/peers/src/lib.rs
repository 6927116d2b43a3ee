//! The same frames through other ray tracers, for comparison.
//!
//! [`Embree`] is loaded when the program runs: everything builds without it. [`Scene`] is its hierarchy over one
//! frame's triangles, and [`Image`] traces camera rays and shadow rays through it in coherent packets of 16.
//! [`TinyBvh`] and [`TinyScene`] are the same for tinybvh, which traces a packet's rays one after the other.
#![deny(unsafe_code)]

mod embree;
mod image;
mod packet;
mod posed;
mod tinybvh;

pub use embree::{BuildMethod, Embree, Error, Quality, Scene};
pub use image::{Image, PixelRays};
pub use packet::{Hits, RayHitPacket, Rays, SingleRay, Valid, WIDTH};
pub use posed::Posed;
pub use tinybvh::{Layout, TinyBvh, TinyScene};
