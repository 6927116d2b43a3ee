//! Ray-specialised grids: structures for bundles of rays that share an origin, rebuilt for every frame.
//!
//! Guntury and Narayanan, *Ray Tracing Dynamic Scenes with Shadows on the GPU*, 2010.

mod extremes;
mod light;
mod perspective;
mod simd_level;

pub use light::{LightGrid, LightGridCounts, LightGridSeconds, SeenImage};
pub use perspective::{GridCounts, ImageTooLarge, PerspectiveGrid, SeenPixels};
pub use simd_level::SimdLevel;
