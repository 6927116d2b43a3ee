//! The GPU poses vertices as the CPU does: positions bit for bit, normals and tangents but for rounding.

#[path = "../../../scene/tests/gltf_reader/builder.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "shared with the reader's tests, which use more of it")]
mod builder;
mod compare;
mod engine;
mod made;
mod posing;
mod scenes;
