//! Experiments: builders, traversals and triangle tests that no product uses.
//!
//! No program for users depends on this crate. `umbrage-bench` measures its parts, and its tests hold them to the same
//! predicate as the product. A part that proves useful moves into `umbrage-rays` or `umbrage-gpu`.
#![forbid(unsafe_code)]

pub mod clusters;
pub mod gpu_kdtree;
pub mod kd_tasks;
#[cfg(test)]
#[allow(dead_code, reason = "some of it is for other tests")]
#[path = "../../gpu/src/layout.rs"]
mod layout;
pub mod light_buffer;
pub mod on_demand;
pub mod queue;
pub mod reorder;
pub mod shaft;
pub mod triangle;
pub mod uniform;
