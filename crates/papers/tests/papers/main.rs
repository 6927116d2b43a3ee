//! The papers' structures by name, and experiments on the CPU, as one program; those on the GPU are in `gpu`.

mod clusters;
mod kd_background;
mod kd_hierarchy;
mod kd_packets;
mod kd_shafts;
mod kd_tasks;
mod kd_tree;
mod kd_tree_lazy;
mod kd_trees;
mod kd_two_level;
mod light_buffer;
mod listed;
mod on_demand;
mod queues;
mod reorder;
mod structures;
#[path = "../../../rays/tests/rays/support/mod.rs"]
mod support;
mod triangle_tests;
mod uniform_grid;
mod uniform_packets;
