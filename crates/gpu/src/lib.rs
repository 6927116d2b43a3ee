//! Finds the triangles that rays hit, as `umbrage-rays` does, on a GPU through wgpu.
//!
//! Grids are rebuilt from the raw triangles for every frame, in compute shaders, without ray-tracing hardware, subgroups,
//! 64-bit integers or f64. A stage is one `.rs` and one `.wgsl` file side by side, and has one name in its timer, its
//! label and its tests. Nothing is read back between stages: counts travel by indirect dispatch.
#![forbid(unsafe_code)]

mod band;
mod buffer;
mod camera;
mod device;
mod error;
mod fit;
mod geometry;
mod grid;
mod kernel;
#[cfg(test)]
#[allow(dead_code, reason = "some of it is for other tests")]
mod layout;
mod light;
mod link;
mod mask;
mod memory;
mod omit;
mod onward;
#[cfg(feature = "operations")]
mod operations;
mod pipelines;
pub mod pose;
pub mod primitives;
pub mod rays;
mod recorder;
pub mod shade;
mod view;

pub use band::Band;
pub use buffer::Buffer;
pub use camera::{CameraGrid, CameraOptions, CameraWork, Sight};
use device::platform;
pub use device::{Adapter, DeviceLimits, Gpu};
pub use error::GpuError;
pub use fit::Fit;
pub use geometry::Geometry;
pub use kernel::{Groups, Kernel};
pub use light::{LightGrid, LightOptions, LightWork};
pub use mask::{MaskMaterial, MaskTexture, MaskVertex, Masks, TriangleFlags};
pub use omit::Omit;
pub use onward::{Onward, OnwardLayers, OnwardLight};
#[cfg(feature = "operations")]
pub use operations::KernelOperations;
pub use recorder::{Done, Fetch, Recorder, StageTime};
pub use wgpu;

/// Internals for `umbrage-papers` and tests. Not part of the public API.
#[doc(hidden)]
pub mod internals {
    pub use crate::link::link_with;
    pub use crate::rays::{RaySpace, ShadowLight, light_words};
    pub use crate::view::{ExactView, PointView};
}
