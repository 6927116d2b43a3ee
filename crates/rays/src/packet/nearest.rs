use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::query::{Query, RayBlock};
use super::{LANES, Planes};
use crate::grid::SeenPixels;

/// What sixteen rays hit nearest, as far as is certain.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct NearestBlock {
    /// Bounds of the hit's nearness; −∞ without a hit.
    pub(crate) low: [f32; LANES],
    pub(crate) high: [f32; LANES],
    pub(crate) triangle: [u32; LANES],
    /// The least `low` of all members.
    farthest: f32,
}

impl NearestBlock {
    pub(crate) const EMPTY: Self = Self {
        low: [f32::NEG_INFINITY; LANES],
        high: [f32::NEG_INFINITY; LANES],
        triangle: [SeenPixels::NONE; LANES],
        farthest: f32::NEG_INFINITY,
    };
}

/// A triangle that a ray may hit nearest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubt {
    /// The ray's block, and its lane in there.
    pub(crate) block: u16,
    pub(crate) lane: u16,
    pub(crate) triangle: u32,
    /// The largest nearness that the hit may have.
    pub(crate) high: f32,
}

/// The query for the nearest hit of each ray.
pub(crate) struct Nearest<'a> {
    pub(crate) rays: &'a [RayBlock],
    pub(crate) found: &'a mut [NearestBlock],
    pub(crate) doubts: &'a mut Vec<Doubt>,
    /// Rays start where the nearness is at least the first and at most the second: what is nearer isn't hit.
    pub(crate) starts: [f32; 2],
    /// Triangles that are there everywhere; of others only the predicate knows.
    pub(crate) is_opaque: &'a (dyn Fn(u32) -> bool + Sync),
    pub(crate) least: f32,
}

impl Nearest<'_> {
    /// Prepares for the members of `rays`, some of which may have hits already.
    pub(crate) fn start(&mut self) {
        for (rays, found) in self.rays.iter().zip(&mut *self.found) {
            found.farthest = farthest(rays.members, &found.low);
        }
        self.update_least();
    }

    fn update_least(&mut self) {
        self.least = self.found.iter().fold(f32::INFINITY, |least, found| least.min(found.farthest));
    }
}

fn farthest(members: u16, low: &[f32; LANES]) -> f32 {
    let lanes = (0..LANES).filter(|lane| members >> lane & 1 == 1);
    lanes.fold(f32::INFINITY, |farthest, lane| farthest.min(low[lane]))
}

impl Query for Nearest<'_> {
    #[inline(always)]
    fn least_nearness(&self) -> f32 {
        self.least
    }

    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32) {
        let is_oriented = planes.oriented >> lane & 1 == 1;
        let [start_low, start_high] = self.starts.map(
            #[inline(always)]
            |start| f32x16::splat(simd, start),
        );
        let mut is_changed = false;
        for (place, (rays, found)) in self.rays.iter().zip(&mut *self.found).enumerate() {
            let members = u64::from(rays.members);
            let values = planes.at(simd, lane, f32x16::from_slice(simd, &rays.x), f32x16::from_slice(simd, &rays.y));
            let [a, b, c] = values.edges;
            let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
            let (old_low, old_high) = (f32x16::from_slice(simd, &found.low), f32x16::from_slice(simd, &found.high));
            let below = lowest.simd_lt(-values.bound);
            let (missed, certain) = if is_oriented {
                let hidden = values.high.simd_lt(old_low) | values.low.simd_gt(start_high);
                let certain =
                    lowest.simd_gt(values.bound) & values.low.simd_gt(old_high) & values.high.simd_lt(start_low);
                (below | hidden, certain)
            } else {
                (below & highest.simd_gt(values.bound), mask32x16::splat(simd, false))
            };
            let possible = !missed.to_bitmask() & members;
            if possible == 0 {
                continue;
            }
            let certain = certain.to_bitmask() & possible;
            let certain = if certain != 0 && (self.is_opaque)(id) { certain } else { 0 };
            if possible != certain {
                let high: [f32; LANES] = values.high.into();
                let mut open = possible & !certain;
                while open != 0 {
                    let ray = open.trailing_zeros() as usize;
                    open &= open - 1;
                    let high = if is_oriented && !high[ray].is_nan() { high[ray] } else { f32::INFINITY };
                    self.doubts.push(Doubt { block: place as u16, lane: ray as u16, triangle: id, high });
                }
            }
            if certain != 0 {
                let certain = mask32x16::from_bitmask(simd, certain);
                certain.select(values.low, old_low).store_slice(&mut found.low);
                certain.select(values.high, old_high).store_slice(&mut found.high);
                let old = u32x16::from_slice(simd, &found.triangle);
                certain.select(u32x16::splat(simd, id), old).store_slice(&mut found.triangle);
                found.farthest = farthest(rays.members, &found.low);
                is_changed = true;
            }
        }
        if is_changed {
            self.update_least();
        }
    }
}
