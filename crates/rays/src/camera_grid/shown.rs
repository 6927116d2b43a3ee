use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::lanes::{Corners, LANES, PixelBounds, splat};
use super::pixel_space::PixelSpace;
use crate::Triangles;
use crate::shot::{Shot, Sides};
use crate::simd::lanes::bits_of;

/// Finds the triangles that show a side that stops rays.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    space: &'a PixelSpace,
    triangles: Triangles<'a>,
    sides: Sides<'a>,
    /// The sign of the area in pixel space of triangles that show their front; zero where all have both sides.
    facing: f32,
}

impl<'a> Shown<'a> {
    pub(super) fn new(space: &'a PixelSpace, shot: &Shot<'a>) -> Self {
        let &Shot { triangles, sides, .. } = shot;
        Self { space, triangles, sides, facing: space.facing(sides) }
    }

    /// The triangles in `lanes` that have a back or show their front. Where the area isn't certain, the predicate decides.
    #[inline(always)]
    pub(super) fn of<S: Simd>(
        &self,
        simd: S,
        ids: &[u32],
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) -> u64 {
        if self.facing == 0.0 || lanes == 0 {
            return lanes;
        }
        let with_back = bits_of(lanes).filter(|lane| self.sides.has_back(ids[lane % LANES]));
        let mut shown = with_back.fold(0, |backs, lane| backs | 1 << lane);
        let [area, bound] = corners.signed_area(simd, bounds.error);
        let area = area * splat(simd, self.facing);
        let (fronts, backs) = (area.simd_gt(bound).to_bitmask(), area.simd_lt(-bound).to_bitmask());
        shown |= fronts;
        for lane in bits_of(lanes & !(shown | backs)) {
            shown |= u64::from(self.space.sees_front(self.triangles.corners(ids[lane % LANES]))) << lane;
        }
        lanes & shown
    }
}
