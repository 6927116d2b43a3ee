//! The glTF reader against hand-computed values and broken files.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod animation;
mod broken;
mod builder;
mod look;
mod mesh;
mod pose;
mod rig;
