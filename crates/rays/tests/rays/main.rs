//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod kd_packets;
mod kd_tree;
mod kd_tree_lazy;
mod support;
mod uniform_grid;
