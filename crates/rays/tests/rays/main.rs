//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod far;
mod hierarchy;
mod kd_background;
mod kd_hierarchy;
mod kd_packets;
mod kd_tree;
mod kd_tree_lazy;
mod kd_two_level;
mod pairs;
mod scales;
mod support;
