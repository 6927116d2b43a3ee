//! The command, run as a user would.

mod failures;
#[cfg(unix)]
mod faults;
mod features;
mod files;
mod heatmap;
mod pages;
#[cfg(feature = "papers")]
mod papers;
mod render;
mod resume;
mod support;
