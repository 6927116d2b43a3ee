use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::blocks::{least_of, least_of_blocks};
use super::query::Query;
use super::{LANES, MOST_BLOCKS, PacketRays, Planes};
use umbrage_rays::shot::{MaskAnswers, Opacity};
use umbrage_rays::simd::lanes::bits_of;

/// The answers of sixteen rays to the query whether each is blocked before its end point.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct AnyHitBlock {
    /// Nearness of each ray's end point.
    pub(crate) limit: [f32; LANES],
    /// The triangle that the end point is on, which doesn't shadow it.
    pub(crate) own: [u32; LANES],
    /// Rays blocked before their end point, a bit for each.
    pub(crate) shadowed: u16,
}

impl AnyHitBlock {
    pub(crate) const EMPTY: Self = Self { limit: [0.0; LANES], own: [u32::MAX; LANES], shadowed: 0 };
}

/// The query whether each ray hits anything before its end point.
pub(crate) struct AnyHit<'a> {
    rays: &'a PacketRays,
    found: &'a mut [AnyHitBlock],
    /// Block, lane and triangle of pairs that the predicate has to settle.
    undecided: &'a mut Vec<(u16, u16, u32)>,
    /// Error bound of the limits.
    limit_error: f32,
    opacity: &'a dyn Opacity,
    /// The least limit of each block's unshadowed rays, minus its error; infinite where there are none.
    farthest: [f32; MOST_BLOCKS],
    /// The minimum of `farthest`.
    least: f32,
}

impl<'a> AnyHit<'a> {
    /// A query for the members of `rays`, whose end points have an error of up to `limit_error` in nearness.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        rays: &'a PacketRays,
        found: &'a mut [AnyHitBlock],
        undecided: &'a mut Vec<(u16, u16, u32)>,
        limit_error: f32,
        opacity: &'a dyn Opacity,
    ) -> Self {
        let farthest = [f32::INFINITY; MOST_BLOCKS];
        let mut query = Self { rays, found, undecided, limit_error, opacity, farthest, least: 0.0 };
        (0..rays.blocks().len()).for_each(|block| query.update_block(simd, block));
        query.update_least(simd);
        query
    }

    #[inline(always)]
    fn update_block<S: Simd>(&mut self, simd: S, block: usize) {
        let (rays, found) = (&self.rays.blocks()[block], &self.found[block]);
        let limit = f32x16::from_slice(simd, &found.limit);
        self.farthest[block] = least_of(simd, limit, rays.members & !found.shadowed) - self.limit_error;
    }

    #[inline(always)]
    fn update_least<S: Simd>(&mut self, simd: S) {
        self.least = least_of_blocks(simd, &self.farthest, self.rays.blocks().len());
    }

    /// Tests the rays of a block against the triangle in `lane`. Returns whether it certainly shadows some.
    #[inline(always)]
    fn test_block<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32, block: usize) -> bool {
        let (rays, found) = (&self.rays.blocks()[block], &mut self.found[block]);
        let unshadowed = rays.members & !found.shadowed;
        if unshadowed == 0 {
            return false;
        }
        let values = planes.at(simd, lane, f32x16::from_slice(simd, &rays.x), f32x16::from_slice(simd, &rays.y));
        let [a, b, c] = values.edges;
        let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
        let below = lowest.simd_lt(-values.bound);
        let limit = f32x16::from_slice(simd, &found.limit);
        let error = f32x16::splat(simd, self.limit_error);
        let is_oriented = planes.oriented >> lane & 1 == 1;
        let (missed, certain) = if is_oriented {
            let certain = lowest.simd_gt(values.bound) & values.low.simd_gt(limit + error);
            (below | values.high.simd_lt(limit - error), certain)
        } else {
            (below & highest.simd_gt(values.bound), mask32x16::splat(simd, false))
        };
        let own = u32x16::from_slice(simd, &found.own).simd_eq(u32x16::splat(simd, id)).to_bitmask() as u16;
        let mut possible = !missed.to_bitmask() as u16 & unshadowed & !own;
        if possible == 0 {
            return false;
        }
        let mut certain = certain.to_bitmask() as u16 & possible;
        if !self.opacity.is_opaque(id) {
            let answers = if is_oriented {
                self.opacity.which_stop(id, &planes.mask_points(simd, lane, values.edges, possible))
            } else {
                MaskAnswers::default()
            };
            possible &= !answers.cut;
            certain &= answers.opaque;
        }
        for ray in bits_of(possible & !certain) {
            self.undecided.push((block as u16, ray as u16, id));
        }
        found.shadowed |= certain;
        certain != 0
    }
}

impl Query for AnyHit<'_> {
    #[inline(always)]
    fn least_nearness(&self) -> f32 {
        self.least
    }

    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32) {
        let mut is_changed = false;
        for block in bits_of(self.rays.reached(simd, planes, lane, &self.farthest)) {
            if self.test_block(simd, planes, lane, id, block) {
                self.update_block(simd, block);
                is_changed = true;
            }
        }
        if is_changed {
            self.update_least(simd);
        }
    }
}
