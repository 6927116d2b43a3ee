#[cfg(feature = "gpu")]
use std::sync::Arc;

use umbrage_rays::{ListedLightOptions, ListedOptions};

#[cfg(feature = "gpu")]
use crate::gpu::MakeFinder;

/// The counterpart of a structure on a GPU: the engine's grids, or a finder of the structure's own.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "there is no engine that reads it"))]
pub struct GpuStructure {
    pub(crate) listed: Option<(ListedOptions, ListedLightOptions)>,
    #[cfg(feature = "gpu")]
    pub(crate) finder: Option<Arc<dyn MakeFinder>>,
}

impl GpuStructure {
    /// The GPU's grids for the camera and for each light.
    #[must_use]
    pub fn grids() -> Self {
        Self {
            listed: None,
            #[cfg(feature = "gpu")]
            finder: None,
        }
    }

    /// The same with the cells of these options.
    #[must_use]
    pub fn listed(camera: ListedOptions, light: ListedLightOptions) -> Self {
        Self {
            listed: Some((camera, light)),
            #[cfg(feature = "gpu")]
            finder: None,
        }
    }

    /// A finder with these options.
    #[cfg(feature = "gpu")]
    #[doc(hidden)]
    #[must_use]
    pub fn with_finder(options: impl MakeFinder + 'static) -> Self {
        Self { finder: Some(Arc::new(options)), ..Self::grids() }
    }
}
