//! Tests of what runs on a GPU, as one program, so that each kernel is compiled once.

mod common;
mod device;
mod exact;
mod layout;
mod omit;
#[cfg(feature = "operations")]
mod operations;
mod pose_layout;
mod primitives;
mod shade;
mod shade_layout;
mod tile_order;
