use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use crate::simd::lanes::load;
use crate::simd::vectors::{LANES, splat};

/// Bounds on a face: lowest and highest X, lowest and highest Y, and a nearness to the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceBox {
    pub(crate) x: [f32; 2],
    pub(crate) y: [f32; 2],
    /// The highest nearness of patches and triangles; the lowest of points.
    pub(crate) nearness: f32,
}

impl FaceBox {
    /// Bounds of no patch or triangle: they overlap nothing.
    pub(crate) const NOTHING: Self = Self {
        x: [f32::INFINITY, f32::NEG_INFINITY],
        y: [f32::INFINITY, f32::NEG_INFINITY],
        nearness: f32::NEG_INFINITY,
    };
}

/// The boxes of sixteen patches, or of sixteen times sixteen, or of the points of sixteen blocks.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct SixteenBoxes {
    pub(crate) x: [[f32; LANES]; 2],
    pub(crate) y: [[f32; LANES]; 2],
    /// The highest nearness of each patch; the lowest of points.
    pub(crate) nearness: [f32; LANES],
}

impl SixteenBoxes {
    /// Patch bounds that overlap nothing.
    pub(crate) const NOTHING: Self = Self {
        x: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
        y: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
        nearness: [f32::NEG_INFINITY; LANES],
    };

    /// Point bounds that nothing overlaps.
    pub(crate) const NO_POINTS: Self = Self { nearness: [f32::INFINITY; LANES], ..Self::NOTHING };

    pub(crate) fn get(&self, lane: usize) -> FaceBox {
        FaceBox {
            x: [self.x[0][lane], self.x[1][lane]],
            y: [self.y[0][lane], self.y[1][lane]],
            nearness: self.nearness[lane],
        }
    }

    pub(crate) fn set(&mut self, lane: usize, one: FaceBox) {
        for end in 0..2 {
            self.x[end][lane] = one.x[end];
            self.y[end][lane] = one.y[end];
        }
        self.nearness[lane] = one.nearness;
    }

    /// The box around all patches.
    #[inline(always)]
    pub(crate) fn around_patches<S: Simd>(&self, simd: S) -> FaceBox {
        FaceBox {
            x: [load(simd, &self.x[0]).reduce_min(), load(simd, &self.x[1]).reduce_max()],
            y: [load(simd, &self.y[0]).reduce_min(), load(simd, &self.y[1]).reduce_max()],
            nearness: load(simd, &self.nearness).reduce_max(),
        }
    }

    /// Mask of the patches, among sixteen, that may shadow some of the points in a box.
    #[inline(always)]
    pub(crate) fn may_shadow<S: Simd>(&self, simd: S, points: &SplatBox<S>) -> u16 {
        let overlap = load(simd, &self.x[0]).simd_le(points.x[1])
            & load(simd, &self.x[1]).simd_ge(points.x[0])
            & load(simd, &self.y[0]).simd_le(points.y[1])
            & load(simd, &self.y[1]).simd_ge(points.y[0])
            & load(simd, &self.nearness).simd_ge(points.nearness);
        overlap.to_bitmask() as u16
    }

    /// Mask of the point boxes, among sixteen, in which a patch or triangle with bounds `by` may shadow a point.
    #[inline(always)]
    pub(crate) fn reached<S: Simd>(&self, simd: S, by: &SplatBox<S>) -> mask32x16<S> {
        load(simd, &self.x[0]).simd_le(by.x[1])
            & load(simd, &self.x[1]).simd_ge(by.x[0])
            & load(simd, &self.y[0]).simd_le(by.y[1])
            & load(simd, &self.y[1]).simd_ge(by.y[0])
            & load(simd, &self.nearness).simd_le(by.nearness)
    }
}

/// A box in all lanes.
pub(crate) struct SplatBox<S: Simd> {
    pub(crate) x: [f32x16<S>; 2],
    pub(crate) y: [f32x16<S>; 2],
    pub(crate) nearness: f32x16<S>,
}

impl<S: Simd> SplatBox<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, one: &FaceBox) -> Self {
        Self {
            x: [splat(simd, one.x[0]), splat(simd, one.x[1])],
            y: [splat(simd, one.y[0]), splat(simd, one.y[1])],
            nearness: splat(simd, one.nearness),
        }
    }
}
