//! Masks of geometries and rays, as Embree and OptiX have them.

use std::ops::Range;

use pyo3::prelude::*;
use umbrage::rays::{Masks, RayMasks};

use crate::arrays::Numbers;

/// What a geometry has by default.
const ALL: u32 = u32::MAX;

/// The argument `mask` of a question.
pub(super) struct MaskArgument<'py>(Option<Numbers<'py, u32>>);

impl<'py> MaskArgument<'py> {
    /// All bits where it is missing, one mask for all, or one for each of a shape: rays, origins or lights.
    pub(super) fn new(value: Option<&Bound<'py, PyAny>>, shape: &[usize]) -> PyResult<Self> {
        Ok(Self(value.map(|value| Numbers::one_or_each("mask", value, shape)).transpose()?))
    }

    pub(super) fn rays(&self) -> RayMasks<'_> {
        self.0.as_ref().map_or_else(RayMasks::default, |numbers| {
            numbers.one().map_or_else(|| RayMasks::Each(numbers.slice()), RayMasks::All)
        })
    }
}

/// The masks of at most `count` rays from `first` on.
pub(super) fn part(rays: RayMasks<'_>, first: usize, count: usize) -> RayMasks<'_> {
    match rays {
        RayMasks::All(mask) => RayMasks::All(mask),
        RayMasks::Each(masks) => RayMasks::Each(&masks[first..masks.len().min(first + count)]),
    }
}

/// The mask of each triangle, up to the last that hasn't all bits.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleMasks(Vec<u32>);

impl TriangleMasks {
    /// Sets the mask of triangles that were added last.
    pub(super) fn add(&mut self, triangles: Range<usize>, mask: u32) {
        if mask != ALL {
            self.0.resize(triangles.start, ALL);
            self.0.resize(triangles.end, mask);
        }
    }

    /// The mask of triangles that were added together.
    pub(super) fn of(&self, triangles: Range<usize>) -> u32 {
        self.0.get(triangles.start).copied().unwrap_or(ALL)
    }

    /// With those of rays.
    pub(super) fn with<'a>(&'a self, rays: RayMasks<'a>) -> Masks<'a> {
        Masks { triangles: &self.0, rays }
    }
}
