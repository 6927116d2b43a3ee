//! Grids as their paper describes them, with triangles listed by cell (Guntury and Narayanan, *Ray Tracing Dynamic Scenes
//! with Shadows on the GPU*, 2010), for comparison with the direct forms in [`camera_grid`](crate::camera_grid) and
//! [`light_grid`](crate::light_grid).

mod camera;
mod light;
mod sorted;

pub use camera::{Cells, ImpossibleCells, ListedGrid, ListedOptions};
pub use light::{ImpossibleLightCells, LightClamp, LightMapping, ListedLightGrid, ListedLightOptions, NoLightClamp};
