use umbrage_rays::{KdTreeOptions, ListedLightOptions, ListedOptions};

#[cfg(feature = "gpu")]
use crate::gpu::MakeFinder;

/// The counterpart of a structure on a GPU, among those that the engine has.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "there is no engine that reads it"))]
pub struct GpuStructure {
    pub(crate) listed: Option<(ListedOptions, ListedLightOptions)>,
    pub(crate) tree: Option<GpuTree>,
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
        Self { listed: None, tree: None }
    }

    /// The same with the cells of these options.
    #[must_use]
    pub fn listed(camera: ListedOptions, light: ListedLightOptions) -> Self {
        Self { listed: Some((camera, light)), tree: None }
    }

    /// A kd-tree that the CPU builds with these options for each frame.
    #[must_use]
    pub fn kd_tree(options: KdTreeOptions) -> Self {
        let tree = GpuTree {
            options,
            #[cfg(feature = "gpu")]
            make: crate::gpu::kd_tree_finder,
        };
        Self { listed: None, tree: Some(tree) }
    }
}
