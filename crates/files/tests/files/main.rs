//! The readers' tests, as one program: linking one takes less time than linking ten.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod bad_input;
mod builder;
mod default_ground;
mod given;
mod gltf_reader;
mod instances;
mod marks;
mod materials;
mod memory;
mod obj;
mod origin;
mod ply;
mod point_cache;
mod pose_allocations;
mod sequence;
mod smooth_normals;
mod solids;
mod stl;
#[cfg(feature = "avif")]
mod textures_avif;
mod textures_on_demand;
