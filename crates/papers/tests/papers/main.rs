//! The papers' structures by name, and experiments on the CPU, as one program; those on the GPU are in `gpu`.

mod clusters;
mod kd_shafts;
mod kd_tasks;
mod light_buffer;
mod on_demand;
mod queues;
mod reorder;
mod structures;
#[path = "../../../rays/tests/rays/support/mod.rs"]
mod support;
mod triangle_tests;
mod uniform_grid;
mod uniform_packets;
