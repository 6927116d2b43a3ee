//! The structures that need no registration.

use umbrage_rays::{Bvh, DirectGrids, SimdLevel};

use super::kind::StructureKind;
use crate::{Error, GpuStructure};

/// Grids made for the rays of a camera and of each light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Direct;

impl StructureKind for Direct {
    const NAME: &'static str = "perspective";
    const ABOUT: &'static str = "grids made for the camera's and the lights' rays";
    const IS_SPECIALISED: bool = true;

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        Ok(Box::new(DirectGrids::with_level(level)))
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        Ok(Some(GpuStructure::grids()))
    }
}

/// A bounding volume hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Hierarchy;

impl StructureKind for Hierarchy {
    const NAME: &'static str = "bvh";
    const ABOUT: &'static str = "a bounding volume hierarchy for all rays";

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        Ok(Box::new(Bvh::with_level(level)))
    }
}
