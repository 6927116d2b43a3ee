//! The scene crate's tests, as one program: linking one takes less time than linking three.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod default_camera;
mod instances;
mod opacity;
