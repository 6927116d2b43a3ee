use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::query::{Query, RayBlock};
use super::{LANES, Planes};

/// Whether sixteen rays have reached the points that they end at.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct AnyHitBlock {
    /// Nearness of each ray's point.
    pub(crate) limit: [f32; LANES],
    /// The triangle that the point is on, which doesn't shadow it.
    pub(crate) own: [u32; LANES],
    /// Rays that hit something before their point, a bit for each.
    pub(crate) shadowed: u16,
}

impl AnyHitBlock {
    pub(crate) const EMPTY: Self = Self { limit: [0.0; LANES], own: [u32::MAX; LANES], shadowed: 0 };
}

/// The query whether each ray hits anything before the point that it ends at.
pub(crate) struct AnyHit<'a> {
    pub(crate) rays: &'a [RayBlock],
    pub(crate) found: &'a mut [AnyHitBlock],
    /// Block, lane and triangle of rays about which the predicate must be asked.
    pub(crate) doubts: &'a mut Vec<(u16, u16, u32)>,
    /// How wrong the limits may be.
    pub(crate) limit_error: f32,
    /// Triangles that let light through nowhere.
    pub(crate) is_opaque: &'a (dyn Fn(u32) -> bool + Sync),
    pub(crate) least: f32,
}

impl AnyHit<'_> {
    /// Prepares for the members of `rays`.
    pub(crate) fn start(&mut self) {
        self.update_least();
    }

    fn update_least(&mut self) {
        let mut least = f32::INFINITY;
        for (rays, found) in self.rays.iter().zip(&*self.found) {
            let mut open = rays.members & !found.shadowed;
            while open != 0 {
                least = least.min(found.limit[open.trailing_zeros() as usize % LANES]);
                open &= open - 1;
            }
        }
        self.least = least - self.limit_error;
    }
}

impl Query for AnyHit<'_> {
    #[inline(always)]
    fn least_nearness(&self) -> f32 {
        self.least
    }

    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32) {
        let is_oriented = planes.oriented >> lane & 1 == 1;
        let mut is_changed = false;
        for (place, (rays, found)) in self.rays.iter().zip(&mut *self.found).enumerate() {
            let open = rays.members & !found.shadowed;
            if open == 0 {
                continue;
            }
            let values = planes.at(simd, lane, f32x16::from_slice(simd, &rays.x), f32x16::from_slice(simd, &rays.y));
            let [a, b, c] = values.edges;
            let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
            let below = lowest.simd_lt(-values.bound);
            let limit = f32x16::from_slice(simd, &found.limit);
            let error = f32x16::splat(simd, self.limit_error);
            let (missed, certain) = if is_oriented {
                let certain = lowest.simd_gt(values.bound) & values.low.simd_gt(limit + error);
                (below | values.high.simd_lt(limit - error), certain)
            } else {
                (below & highest.simd_gt(values.bound), mask32x16::splat(simd, false))
            };
            let possible = !missed.to_bitmask() as u16 & open;
            if possible == 0 {
                continue;
            }
            let own = u32x16::from_slice(simd, &found.own).simd_eq(u32x16::splat(simd, id)).to_bitmask() as u16;
            let possible = possible & !own;
            let certain = certain.to_bitmask() as u16 & possible;
            let certain = if certain != 0 && (self.is_opaque)(id) { certain } else { 0 };
            let mut doubtful = possible & !certain;
            while doubtful != 0 {
                self.doubts.push((place as u16, doubtful.trailing_zeros() as u16, id));
                doubtful &= doubtful - 1;
            }
            found.shadowed |= certain;
            is_changed |= certain != 0;
        }
        if is_changed {
            self.update_least();
        }
    }
}
