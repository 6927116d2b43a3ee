//! The command, run as a user would.

mod failures;
mod heatmap;
mod pages;
mod render;
mod support;
