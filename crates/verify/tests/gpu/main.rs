//! Tests of the GPU engine, as one program, so that each kernel is compiled once.

mod adversarial;
#[path = "../../../scene/tests/scene/builder.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "shared with the reader's tests, which use more of it")]
mod builder;
mod common;
mod failures;
mod frames;
mod kdtree;
mod mirrors;
mod own_frames;
mod pose;
mod shade;
mod texture;
