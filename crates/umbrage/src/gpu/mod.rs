//! The GPU engine's side of a frame.

mod tables;
pub mod trial;
