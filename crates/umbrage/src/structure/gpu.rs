#[cfg(feature = "gpu")]
use std::sync::Arc;

use super::LightClamp;

#[cfg(feature = "gpu")]
use crate::gpu::MakeFinder;

/// The counterpart of a structure on a GPU: the engine's grids, or a finder of the structure's own.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "there is no engine that reads it"))]
pub struct GpuStructure {
    pub(crate) grids: Option<GpuGrids>,
    #[cfg(feature = "gpu")]
    pub(crate) finder: Option<Arc<dyn MakeFinder>>,
}

/// Cells of a GPU's grids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpuGrids {
    /// Pixels a side of the tiles that triangles are listed in: 8 or 16.
    pub sorting_tile: u32,
    /// Depth slices of the camera's grid.
    pub slices: u32,
    /// Whether lights with a position see by two angles around them, instead of through faces.
    pub lights_are_spherical: bool,
    /// The angles that these lights divide into cells; by default the range of the points' angles.
    pub light_clamp: Option<LightClamp>,
    /// Depth slices of the lights' grids.
    pub light_slices: u32,
}

impl GpuStructure {
    /// The GPU's grids for the camera and for each light.
    #[must_use]
    pub fn grids() -> Self {
        Self {
            grids: None,
            #[cfg(feature = "gpu")]
            finder: None,
        }
    }

    /// The same with these cells.
    #[must_use]
    pub fn grids_of(cells: GpuGrids) -> Self {
        let mut structure = Self::grids();
        structure.grids = Some(cells);
        structure
    }

    /// A finder with these options.
    #[cfg(feature = "gpu")]
    #[doc(hidden)]
    #[must_use]
    pub fn with_finder(options: impl MakeFinder + 'static) -> Self {
        Self { finder: Some(Arc::new(options)), ..Self::grids() }
    }
}
