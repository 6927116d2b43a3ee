//! The crate's tests, as one program: linking one takes less time than linking sixteen.

mod grid_allocations;
mod kd_packets;
mod kd_tree;
mod kd_tree_lazy;
mod light_cells;
mod light_grid;
mod listed_grid;
mod perspective_grid;
mod support;
mod uniform_grid;
mod uniform_packets;
