use umbrage_rays::KdTreeOptions;

use super::LightClamp;

#[cfg(feature = "gpu")]
use crate::gpu::MakeFinder;

/// The counterpart of a structure on a GPU, among those that the engine has.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "there is no engine that reads it"))]
pub struct GpuStructure {
    pub(crate) grids: Option<GpuGrids>,
    pub(crate) tree: Option<GpuTree>,
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

/// A kd-tree on a GPU. Programs link its kernels only if they call [`GpuStructure::kd_tree`].
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "there is no engine that reads it"))]
pub(crate) struct GpuTree {
    pub(crate) options: KdTreeOptions,
    #[cfg(feature = "gpu")]
    pub(crate) make: MakeFinder,
}

impl GpuStructure {
    /// The GPU's grids for the camera and for each light.
    #[must_use]
    pub fn grids() -> Self {
        Self { grids: None, tree: None }
    }

    /// The same with these cells.
    #[must_use]
    pub fn grids_of(cells: GpuGrids) -> Self {
        Self { grids: Some(cells), tree: None }
    }

    /// A kd-tree that the CPU builds with these options for each frame.
    #[must_use]
    pub fn kd_tree(options: KdTreeOptions) -> Self {
        let tree = GpuTree {
            options,
            #[cfg(feature = "gpu")]
            make: crate::gpu::kd_tree_finder,
        };
        Self { grids: None, tree: Some(tree) }
    }
}
