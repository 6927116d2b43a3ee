use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::blocks::{least_of, least_of_blocks};
use super::query::Query;
use super::{LANES, MOST_BLOCKS, PacketRays, Planes};
use umbrage_rays::shot::{MaskAnswers, Opacity, SeenPixels};
use umbrage_rays::simd::lanes::bits_of;

/// The nearest certain hits of sixteen rays.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct NearestBlock {
    /// Bounds of the hit's nearness; −∞ without a hit.
    pub(crate) low: [f32; LANES],
    pub(crate) high: [f32; LANES],
    pub(crate) triangle: [u32; LANES],
}

impl NearestBlock {
    pub(crate) const EMPTY: Self =
        Self { low: [f32::NEG_INFINITY; LANES], high: [f32::NEG_INFINITY; LANES], triangle: [SeenPixels::NONE; LANES] };
}

/// A triangle that may be a ray's nearest hit, for the predicate to settle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Undecided {
    /// The ray's block, and its lane in that block.
    pub(crate) block: u16,
    pub(crate) lane: u16,
    pub(crate) triangle: u32,
    /// The largest nearness that the hit may have.
    pub(crate) high: f32,
}

/// The query for the nearest hit of each ray.
pub(crate) struct Nearest<'a> {
    rays: &'a PacketRays,
    found: &'a mut [NearestBlock],
    undecided: &'a mut Vec<Undecided>,
    /// Bounds of the nearness at which rays start: a ray starts between the two, and nothing nearer is hit.
    starts: [f32; 2],
    opacity: &'a dyn Opacity,
    /// A lower bound of `low` for each block's members.
    farthest: [f32; MOST_BLOCKS],
    /// The minimum of `farthest`.
    least: f32,
}

impl<'a> Nearest<'a> {
    /// A query for the members of `rays`, some of which may have hits already.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        rays: &'a PacketRays,
        found: &'a mut [NearestBlock],
        undecided: &'a mut Vec<Undecided>,
        starts: [f32; 2],
        opacity: &'a dyn Opacity,
    ) -> Self {
        let mut farthest = [f32::INFINITY; MOST_BLOCKS];
        for ((farthest, rays), found) in farthest.iter_mut().zip(rays.blocks()).zip(&*found) {
            *farthest = least_of(simd, f32x16::from_slice(simd, &found.low), rays.members);
        }
        let mut query = Self { rays, found, undecided, starts, opacity, farthest, least: 0.0 };
        query.update_least(simd);
        query
    }

    #[inline(always)]
    fn update_least<S: Simd>(&mut self, simd: S) {
        self.least = least_of_blocks(simd, &self.farthest, self.rays.blocks().len());
    }

    /// Tests the rays of a block against the triangle in `lane`. Returns whether it certainly is the nearest hit of some.
    #[inline(always)]
    fn test_block<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32, block: usize) -> bool {
        let (rays, found) = (&self.rays.blocks()[block], &mut self.found[block]);
        let members = u64::from(rays.members);
        let values = planes.at(simd, lane, f32x16::from_slice(simd, &rays.x), f32x16::from_slice(simd, &rays.y));
        let [a, b, c] = values.edges;
        let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
        let (old_low, old_high) = (f32x16::from_slice(simd, &found.low), f32x16::from_slice(simd, &found.high));
        let below = lowest.simd_lt(-values.bound);
        let is_oriented = planes.oriented >> lane & 1 == 1;
        let (missed, certain) = if is_oriented {
            let [start_low, start_high] = self.starts;
            let hidden = values.high.simd_lt(old_low) | values.low.simd_gt(f32x16::splat(simd, start_high));
            let started = values.high.simd_lt(f32x16::splat(simd, start_low));
            let certain = lowest.simd_gt(values.bound) & values.low.simd_gt(old_high) & started;
            (below | hidden, certain)
        } else {
            (below & highest.simd_gt(values.bound), mask32x16::splat(simd, false))
        };
        let mut possible = !missed.to_bitmask() & members;
        if possible == 0 {
            return false;
        }
        let mut certain = certain.to_bitmask() & possible;
        if !self.opacity.is_opaque(id) {
            let answers = if is_oriented {
                self.opacity.which_stop(id, &planes.mask_points(simd, lane, values.edges, possible as u16))
            } else {
                MaskAnswers::default()
            };
            possible &= !u64::from(answers.cut);
            certain &= u64::from(answers.opaque);
        }
        if possible != certain {
            let high: [f32; LANES] = values.high.into();
            for ray in bits_of(possible & !certain) {
                let high = if is_oriented && !high[ray].is_nan() { high[ray] } else { f32::INFINITY };
                self.undecided.push(Undecided { block: block as u16, lane: ray as u16, triangle: id, high });
            }
        }
        if certain == 0 {
            return false;
        }
        let certain = mask32x16::from_bitmask(simd, certain);
        let low = certain.select(values.low, old_low);
        low.store_slice(&mut found.low);
        certain.select(values.high, old_high).store_slice(&mut found.high);
        let old = u32x16::from_slice(simd, &found.triangle);
        certain.select(u32x16::splat(simd, id), old).store_slice(&mut found.triangle);
        self.farthest[block] = least_of(simd, low, rays.members);
        true
    }
}

impl Query for Nearest<'_> {
    #[inline(always)]
    fn least_nearness(&self) -> f32 {
        self.least
    }

    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32) {
        let mut is_changed = false;
        for block in bits_of(self.rays.reached(simd, planes, lane, &self.farthest)) {
            is_changed |= self.test_block(simd, planes, lane, id, block);
        }
        if is_changed {
            self.update_least(simd);
        }
    }
}
