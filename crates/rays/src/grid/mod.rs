//! Grids that are rebuilt for every frame: ray-specialised ones for bundles of rays that share an origin (Guntury and
//! Narayanan, *Ray Tracing Dynamic Scenes with Shadows on the GPU*, 2010), and a uniform one for all rays.

mod counting_sort;
mod lanes;
mod light;
mod mask;
mod perspective;
mod seen;
mod simd_level;
mod tile_order;
mod uniform;
mod work;

pub use light::{
    ImpossibleLightCells, LightCell, LightCells, LightFace, LightGrid, LightGridCounts, LightGridSeconds,
    ListedLightCounts, ListedLightGrid, ListedLightOptions, ListedLightSeconds, SeenImage,
};
pub use mask::{Mask, MaskAnswers, MaskPoints, ShadowMask, Unmasked};
pub use perspective::{
    Cells, GridCounts, ImageTooLarge, ImpossibleCells, ListedCounts, ListedGrid, ListedOptions, ListedSeconds,
    PerspectiveGrid,
};
pub use seen::SeenPixels;
pub use simd_level::SimdLevel;
pub use tile_order::TileOrder;
pub use uniform::{ImpossibleUniformOptions, Insertion, PacketSide, UniformCounts, UniformGrid, UniformOptions};
pub use work::{PixelWork, Work};
