//! The compiled half of the Python package `umbrage`: scenes of triangles, rays, scans, light and pictures, with numpy arrays in
//! and out. [docs/python.md](../../../docs/python.md) is for its users.
//!
//! Arrays are read where they are if they are contiguous and of the right type (`arrays.rs`); Python's lock is released while
//! anything is computed (`threads.rs`).
#![forbid(unsafe_code)]
#![allow(clippy::needless_pass_by_value, reason = "arguments of Python functions arrive by value")]
#![allow(
    clippy::doc_lazy_continuation,
    clippy::doc_markdown,
    reason = "public docs are Python's docstrings, which have names and examples as numpy writes them"
)]

mod animated;
mod arrays;
mod camera;
mod errors;
mod light;
mod pickled;
mod picture;
mod scene;
mod threads;

use pyo3::prelude::*;

/// Exact rays, scans, shadows and pictures of triangles that may all move between two frames.
#[pymodule]
mod _umbrage {
    #[pymodule_export]
    use crate::animated::{Frame, Instance, Scene, open};
    #[pymodule_export]
    use crate::camera::Camera;
    #[pymodule_export]
    use crate::light::Light;
    #[pymodule_export]
    use crate::scene::{InstancedScene, MovingScene, RaycastingScene};
    #[pymodule_export]
    use crate::threads::{get_threads, set_threads};

    #[pymodule_init]
    fn init(module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        use super::PyModuleMethods;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
