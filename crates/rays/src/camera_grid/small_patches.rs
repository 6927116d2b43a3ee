//! Patches that are small in the image, in a tile: their triangles from vertices to samples in one go.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};

use super::bins::{Bins, Fragment};
use super::lanes::{BackFaceCull, Corners, LANES, PixelBounds, splat};
use super::samples::{BLOCKS, SAMPLES};
use super::tile::{TileHits, TriangleBatch};
use super::trace::{ListedPatches, TileTrace};
use super::two_by_two::TinyTriangles;
use crate::patches::MOST_VERTICES;
use crate::shot::Kind;
use crate::simd::each;
use crate::simd::lanes::{bits_of, load_positions};
use crate::vectorized;

const TINY: usize = 0;
const ORDINARY: usize = 1;

/// Triangles of several patches, collected until there are sixteen.
pub(super) struct PendingTriangles {
    x: [[f32; 2 * LANES]; 3],
    y: [[f32; 2 * LANES]; 3],
    inverse_depth: [[f32; 2 * LANES]; 3],
    ids: [u32; 2 * LANES],
    count: usize,
}

impl PendingTriangles {
    pub(super) const NONE: Self = Self {
        x: [[0.0; 2 * LANES]; 3],
        y: [[0.0; 2 * LANES]; 3],
        inverse_depth: [[0.0; 2 * LANES]; 3],
        ids: [0; 2 * LANES],
        count: 0,
    };

    /// Adds the triangles in `lanes`, to fewer than sixteen.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, ids: &[u32], corners: &Corners<S>, lanes: u64) {
        let mask = mask32x16::from_bitmask(simd, lanes);
        let room = self.count..self.count + LANES;
        for corner in 0..3 {
            corners.x[corner].compress(mask).store_slice(&mut self.x[corner][room.clone()]);
            corners.y[corner].compress(mask).store_slice(&mut self.y[corner][room.clone()]);
            let inverse_depth = corners.inverse_depth[corner].compress(mask);
            inverse_depth.store_slice(&mut self.inverse_depth[corner][room.clone()]);
        }
        u32x16::from_slice(simd, ids).compress(mask).store_slice(&mut self.ids[room]);
        self.count += lanes.count_ones() as usize;
    }

    /// Takes the first sixteen triangles, or fewer at the end: their ids, their corners, and their number.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S) -> ([u32; LANES], Corners<S>, usize) {
        let first = |numbers: &[f32; 2 * LANES]| f32x16::from_slice(simd, &numbers[..LANES]);
        let x = each!(numbers in &self.x => first(numbers));
        let y = each!(numbers in &self.y => first(numbers));
        let inverse_depth = each!(numbers in &self.inverse_depth => first(numbers));
        let corners = Corners { x, y, inverse_depth };
        for numbers in self.x.iter_mut().chain(&mut self.y).chain(&mut self.inverse_depth) {
            numbers.copy_within(LANES.., 0);
        }
        let ids = std::array::from_fn(|lane| self.ids[lane]);
        self.ids.copy_within(LANES.., 0);
        let count = self.count.min(LANES);
        self.count -= count;
        (ids, corners, count)
    }
}

impl<const N: usize> TileTrace<'_, N> {
    /// Tests the triangles of a patch, unless the nearest hits so far hide it. Returns whether triangles that aren't tiny
    /// were tested.
    #[inline(never)]
    pub(super) fn test_patch<S: Simd>(
        &mut self,
        simd: S,
        listed: &ListedPatches<'_>,
        number: usize,
        nearest: f32,
        batch: &mut TriangleBatch,
    ) -> bool {
        vectorized!(simd => {
            let blocks = listed.boxes[number].blocks(self.at.corner);
            !self.tile.hides(simd, blocks, nearest) && self.test_seen_patch(simd, listed, number, batch)
        })
    }

    /// Tests the triangles of patches that still wait.
    #[inline(never)]
    pub(super) fn test_rest<S: Simd>(&mut self, simd: S, batch: &mut TriangleBatch) {
        let [tiny, ordinary] = &self.tile.waiting;
        if tiny.count + ordinary.count > 0 {
            vectorized!(simd => {
                self.merge_tiny(simd);
                self.test_waiting(simd, batch);
            });
        }
    }

    #[inline(always)]
    fn test_seen_patch<S: Simd>(
        &mut self,
        simd: S,
        listed: &ListedPatches<'_>,
        number: usize,
        batch: &mut TriangleBatch,
    ) -> bool {
        let patch = listed.patches.get(number);
        let (space, triangles) = (self.at.space, self.at.shot.triangles);
        self.tally.pairs += patch.count as u64;
        self.work.add(Kind::Pairs, 0..SAMPLES, patch.count as u32);
        let mut vertices = [[0.0; MOST_VERTICES]; 3];
        for (sixteen, positions) in listed.patches.positions(number).iter().enumerate() {
            let axes = space.project_ordinary(simd, load_positions(simd, positions));
            for (axis, to) in axes.into_iter().zip(&mut vertices) {
                axis.store_slice(&mut to[sixteen * LANES % MOST_VERTICES..][..LANES]);
            }
        }
        let first = self.at.corner - space.middle;
        let last = (Bins::TILE - 1) as f32;
        let (left, top) = (splat(simd, first.x as f32), splat(simd, first.y as f32));
        let shown = BackFaceCull::new(space, self.at.shot);
        let mut is_any_tested = false;
        let groups = patch.corners.as_chunks().0.iter().zip(patch.ids.chunks_exact(LANES));
        for (group, (corners, ids)) in groups.enumerate() {
            let lanes = (1_u64 << (patch.count - group * LANES).min(LANES)) - 1;
            let corners = Corners::of_few(simd, &vertices, corners);
            let bounds = PixelBounds::new(simd, space, &corners);
            let seen = bounds.x[0].max(left).simd_le(bounds.x[1].min(left + last))
                & bounds.y[0].max(top).simd_le(bounds.y[1].min(top + last));
            let mut seen = seen.to_bitmask() & lanes;
            if seen == 0 {
                continue;
            }
            for lane in bits_of(corners.coincide().to_bitmask() & seen) {
                if triangles.usable_corners(ids[lane % LANES]).is_err() {
                    seen &= !(1 << lane);
                }
            }
            seen = shown.keep(simd, ids, &corners, &bounds, seen);
            let is_tiny = TinyTriangles::are(simd, &bounds).to_bitmask();
            if seen & is_tiny != 0 {
                self.tile.waiting[TINY].add(simd, ids, &corners, seen & is_tiny);
                if self.tile.waiting[TINY].count >= LANES {
                    self.merge_tiny(simd);
                }
            }
            if seen & !is_tiny != 0 {
                self.tile.waiting[ORDINARY].add(simd, ids, &corners, seen & !is_tiny);
                if self.tile.waiting[ORDINARY].count >= LANES {
                    self.test_waiting(simd, batch);
                    is_any_tested = true;
                }
            }
        }
        self.settle_if_many();
        is_any_tested
    }

    /// Tests up to sixteen waiting triangles.
    #[inline(always)]
    fn test_waiting<S: Simd>(&mut self, simd: S, batch: &mut TriangleBatch) {
        let (ids, corners, count) = self.tile.waiting[ORDINARY].take(simd);
        self.test_ordinary::<S, false>(simd, &ids, corners, (1 << count) - 1, batch);
    }

    /// Tests up to sixteen waiting tiny triangles, and merges their hits.
    #[inline(always)]
    fn merge_tiny<S: Simd>(&mut self, simd: S) {
        let (ids, corners, count) = self.tile.waiting[TINY].take(simd);
        let lanes = mask32x16::from_bitmask(simd, (1 << count) - 1);
        let first = self.at.corner - self.at.space.middle;
        let (left, top) = (splat(simd, first.x as f32), splat(simd, first.y as f32));
        let bounds = PixelBounds::new(simd, self.at.space, &corners);
        let tiny = TinyTriangles::new(simd, self.at.space, &corners, &bounds);
        let ids = u32x16::simd_from(simd, ids);
        // Hits at the four samples, collected without a branch.
        let (mut index, mut triangle, mut hits) = ([0; ROOM], [0; ROOM], 0);
        let (mut low, mut high) = ([0.0; ROOM], [0.0; ROOM]);
        for sample in TinyTriangles::<S>::SAMPLES {
            let [x, y] = bounds.sample(simd, sample);
            let (x, y) = (x - left, y - top);
            let in_tile = x.min(y).simd_ge(splat(simd, 0.0)) & x.max(y).simd_le(splat(simd, (Bins::TILE - 1) as f32));
            let of_sample = tiny.hits(simd, sample, bounds.have(simd, sample) & in_tile & lanes);
            // Blocks have 16 samples and their rows 256.
            let (column, row) = ((x * splat(simd, 0.25)).floor(), (y * splat(simd, 0.25)).floor());
            let at: i32x16<S> = (x + y * 4.0 + column * 12.0 + row * 240.0).to_int();
            let at = at.bitcast::<u32x16<S>>();
            let at = of_sample.inside.select(at, at | Fragment::UNDECIDED);
            let possible = of_sample.possible;
            at.compress(possible).store_slice(&mut index[hits..hits + LANES]);
            ids.compress(possible).store_slice(&mut triangle[hits..hits + LANES]);
            of_sample.low.compress(possible).store_slice(&mut low[hits..hits + LANES]);
            of_sample.high.compress(possible).store_slice(&mut high[hits..hits + LANES]);
            hits += possible.to_bitmask().count_ones() as usize;
        }
        self.tally.fragments += hits as u64;
        for hit in 0..hits.min(ROOM) {
            let fragment = Fragment { index: index[hit], triangle: triangle[hit], low: low[hit], high: high[hit] };
            let index = index[hit] as usize % SAMPLES;
            self.work.add(Kind::Tested, index..index + 1, 1);
            self.tile.merge(&fragment);
            let block = index / LANES;
            self.tile.changed[block / BLOCKS] |= 1 << (block % BLOCKS);
        }
    }
}

/// Room for hits of sixteen triangles at four samples.
const ROOM: usize = 4 * LANES;

impl TileHits {
    /// Whether some blocks certainly hide everything with an inverse depth of at most `nearest`.
    #[inline(always)]
    fn hides<S: Simd>(&mut self, simd: S, [x0, x1, y0, y1]: [usize; 4], nearest: f32) -> bool {
        let within = ((2_u32 << x1) - (1 << x0)) as u16;
        let nearest = splat(simd, nearest);
        for row in y0..=y1 {
            for column in bits_of(self.changed[row] & within) {
                self.note_farthest_in(simd, row * BLOCKS + column);
            }
            self.changed[row] &= !within;
            let farthest = f32x16::from_slice(simd, &self.farthest[row * BLOCKS..(row + 1) * BLOCKS]);
            if farthest.simd_le(nearest).to_bitmask() & u64::from(within) != 0 {
                return false;
            }
        }
        true
    }
}
