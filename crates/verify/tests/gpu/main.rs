//! All tests that need a GPU, as one program: they share a device, so that each kernel is compiled once.

#[path = "../../../files/tests/files/builder.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "shared with the reader's tests, which use more of it")]
mod builder;
mod common;
mod frames;
mod kdtree;
/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    mod adversarial;
    mod failures;
    mod frames;
    mod mirrors;
}
mod own_frames;
mod pose;
mod rays;
mod shade;
mod stages;
mod study;
#[path = "../../../rays/tests/rays/support/mod.rs"]
mod support;
mod texture;
