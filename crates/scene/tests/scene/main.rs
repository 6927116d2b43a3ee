//! The scene crate's tests, as one program: linking one takes less time than linking ten.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod builder;
mod default_camera;
mod default_ground;
mod files;
mod files_bad_input;
mod files_given;
mod files_materials;
mod files_obj;
mod files_ply;
mod files_point_cache;
mod files_sequence;
mod files_stl;
mod gltf_reader;
mod instances;
mod marks;
mod memory;
mod opacity;
mod origin;
mod pose_allocations;
mod smooth_normals;
#[cfg(feature = "avif")]
mod textures_avif;
mod textures_on_demand;
