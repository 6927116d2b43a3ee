use std::sync::Mutex;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, mask32x16};
use glam::{IVec2, UVec2};
use rayon::prelude::*;

use super::PerspectiveGrid;
use super::bins::Bin;
use super::build::lanes_of;
use super::depth;
use super::general::{General, Square};
use super::lanes::{Corners, DepthPlane, LANES, Setup, each, largest, sample_range, splat};
use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use super::tile::{BLOCKS, Batch, HALF, MaskWeights, SAMPLES, Tile, block_range};
use crate::predicate::{crossing, settle};
use crate::shot::{Counts, Kind, SeenPixels, Shot, TileWork};

impl PerspectiveGrid {
    /// Finds what each pixel sees: bit for bit the same on any number of threads and at every SIMD level. Counts the work of
    /// pixels in `work`, which has an entry for each; a tile is one cell there.
    pub(super) fn trace_tiles<const N: usize>(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut [[u32; N]],
    ) -> Counts {
        let Some(space) = self.space else {
            seen.resize(0, 0);
            return Counts::default();
        };
        let (width, height) = space.size();
        seen.resize(width, height);
        let order = seen.order();
        self.scratch.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let grid = &*self;
        let triangle_tiles = seen.triangle.par_chunks_mut(SAMPLES);
        let tiles = triangle_tiles.zip(seen.inverse_depth.par_chunks_mut(SAMPLES)).zip(work.par_chunks_mut(SAMPLES));
        let counted = tiles.enumerate().with_max_len(1).map(|(index, ((triangle, inverse_depth), work))| {
            // A thread waits for nobody here, since each has its own tile.
            let thread = rayon::current_thread_index().unwrap_or(grid.scratch.len() - 1);
            let mut tile = grid.scratch[thread].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let corner = UVec2::from(order.column_and_row(index * SAMPLES)).as_ivec2();
            let (space, vertices) = (&space, &grid.vertices);
            let (tile, work, tally) = (&mut *tile, TileWork(work), Counts::default());
            let mut trace = TileTrace { shot, space, vertices, corner, tile, work, tally };
            let bins = grid.ranges.iter().map(|range| &range.bins[index]);
            dispatch!(grid.level.0, simd => trace.run(simd, bins.clone(), triangle, inverse_depth));
            trace.tally
        });
        counted.reduce(Counts::default, Counts::plus)
    }
}

/// The search of one tile.
struct TileTrace<'a, const N: usize> {
    shot: &'a Shot<'a>,
    space: &'a PixelSpace,
    vertices: &'a [Vertex],
    /// The tile's first column and row in the image.
    corner: IVec2,
    tile: &'a mut Tile,
    work: TileWork<'a, N>,
    tally: Counts,
}

impl<const N: usize> TileTrace<'_, N> {
    /// Searches the tile's bins of all ranges of triangles, and writes what each sample sees.
    #[inline(always)]
    fn run<'b, S: Simd>(
        &mut self,
        simd: S,
        bins: impl Iterator<Item = &'b Bin> + Clone,
        triangle: &mut [u32],
        inverse_depth: &mut [f32],
    ) {
        if bins.clone().all(Bin::is_empty) {
            leave_empty(triangle, inverse_depth);
            return;
        }
        self.tile.clear();
        let listed: usize = bins.clone().flat_map(Bin::lists).map(Vec::len).sum();
        self.tally.pairs += listed as u64;
        self.work.add(Kind::Pairs, 0..SAMPLES, listed as u32);
        let (ordinary, general) = (bins.clone().map(|bin| &*bin.ordinary), bins.clone().map(|bin| &*bin.general));
        self.tile.order.sort_by_depth(ordinary, general);
        self.test_nearest_first::<S, false>(simd);
        for bin in bins.clone() {
            self.tally.fragments += bin.fragments.len() as u64;
            for fragments in bin.fragments.chunks(SAMPLES) {
                for fragment in fragments {
                    let place = fragment.place as usize % SAMPLES;
                    self.work.add(Kind::Tested, place..place + 1, 1);
                    self.tile.merge(fragment);
                }
                self.settle_if_many();
            }
        }
        // Masked triangles come last: the less of them is seen, the fewer questions there are for the mask.
        let (ordinary, general) = (bins.clone().map(|bin| &*bin.masked), bins.map(|bin| &*bin.masked_general));
        self.tile.order.sort_by_depth(ordinary, general);
        self.test_nearest_first::<S, true>(simd);
        self.settle();
        if self.tally.pairs + self.tally.fragments > 0 {
            self.work.add(Kind::Cells, 0..SAMPLES, 1);
        }
        self.write(simd, triangle, inverse_depth);
    }

    /// Tests the triangles in the tile's order, all of them masked or none, but for those that are behind all that is seen by then.
    #[inline(always)]
    fn test_nearest_first<S: Simd, const MASKED: bool>(&mut self, simd: S) {
        let order = std::mem::take(&mut self.tile.order);
        let mut batch = Batch::default();
        let (mut ids, mut waiting, mut farthest) = ([0; LANES], 0, 0.0);
        let (mut general, mut waiting_general) = ([0; LANES], 0);
        for listed in order.listed() {
            if listed.nearest.is_sign_negative() {
                general[waiting_general] = listed.triangle;
                waiting_general += usize::from(-listed.nearest >= farthest);
                if waiting_general == LANES {
                    self.test_general(simd, &general, MASKED, &mut batch);
                    waiting_general = 0;
                    farthest = self.tile.farthest(simd);
                }
                continue;
            }
            ids[waiting] = listed.triangle;
            waiting += usize::from(listed.nearest >= farthest);
            if waiting == LANES {
                self.test_ordinary::<S, MASKED>(simd, &ids, &mut batch);
                waiting = 0;
                farthest = self.tile.farthest(simd);
            }
        }
        self.test_general(simd, &general[..waiting_general], MASKED, &mut batch);
        self.test_ordinary::<S, MASKED>(simd, &ids[..waiting], &mut batch);
        self.tile.order = order;
    }

    /// Tests up to 16 triangles on the fast path, all of them masked or none.
    #[inline(never)]
    fn test_ordinary<S: Simd, const MASKED: bool>(&mut self, simd: S, ids: &[u32], batch: &mut Batch) {
        simd.vectorize(
            #[inline(always)]
            || self.test_ordinary_inlined::<S, MASKED>(simd, ids, batch),
        );
    }

    #[inline(always)]
    fn test_ordinary_inlined<S: Simd, const MASKED: bool>(&mut self, simd: S, ids: &[u32], batch: &mut Batch) {
        let indices = self.shot.triangles.indices;
        let mut corners = [[u32::MAX; 3]; LANES];
        for (corners, &id) in corners.iter_mut().zip(ids) {
            *corners = indices[id as usize];
        }
        let corners = Corners::load(simd, self.vertices, &corners);
        let origin = self.corner - self.space.middle + IVec2::splat(HALF);
        let x = each(
            corners.x,
            #[inline(always)]
            |x| x - splat(simd, origin.x as f32),
        );
        let y = each(
            corners.y,
            #[inline(always)]
            |y| y - splat(simd, origin.y as f32),
        );
        // Half an ulp for the corner, one for the move to the tile's middle.
        let corner_error =
            largest(corners.x, corners.y) * splat(simd, 1.01 * HALF_ULP) + splat(simd, 1.01 * Vertex::ERROR_PIXELS);
        let error = corner_error + largest(x, y) * splat(simd, 1.01 * HALF_ULP);
        // The same again for the sums of coordinates and their errors.
        let (columns, rows) = (sample_range(x, error + error), sample_range(y, error + error));
        let (width, height) = self.space.size();
        let last = IVec2::new(width as i32, height as i32) - 1 - self.corner - HALF;
        let seen = overlaps(simd, columns, last.x) & overlaps(simd, rows, last.y);
        let seen = seen.to_bitmask() & ((1 << ids.len()) - 1);
        if seen == 0 {
            return;
        }
        const OVERHANG_PIXELS: f32 = 3.25;
        let setup = Setup::new(simd, x, y, corners.inverse_depth, error, HALF as f32, OVERHANG_PIXELS);
        let certain = setup.is_certain(simd);
        let origin_pixels = [origin.x as f32, origin.y as f32];
        let plane = DepthPlane::new(simd, &corners, corner_error, origin_pixels, HALF as f32);
        batch.fill(simd, &setup, &plane, certain);
        batch.ids[..ids.len()].copy_from_slice(ids);
        let ranges = [block_range(simd, columns[0], columns[1]), block_range(simd, rows[0], rows[1])];
        for (blocks, range) in batch.blocks.iter_mut().zip(ranges.as_flattened()) {
            range.store_slice(blocks);
        }
        let certain = certain.to_bitmask();
        self.settle_if_many();
        let queued = if MASKED {
            let weights = MaskWeights::new(simd, self.space, &corners, &setup, [x, y], error);
            self.tile.test_masked(simd, batch, &weights, self.shot.opacity, seen & certain)
        } else {
            self.tile.test_batch::<S, true>(simd, batch, seen & certain)
        };
        self.count_queued(queued);
        if seen & !certain != 0 {
            let queued = self.tile.test_batch::<S, false>(simd, batch, seen & !certain);
            self.count_queued(queued);
        }
    }

    /// Counts the tests of the blocks that were queued last.
    #[inline(always)]
    fn count_queued(&mut self, [waiting, covered]: [usize; 2]) {
        if N > 0 {
            for &queued in self.tile.queue[..waiting].iter().chain(&self.tile.covered[..covered]) {
                let first = queued as usize % (BLOCKS * BLOCKS) * LANES;
                self.work.add(Kind::Tested, first..first + LANES, 1);
            }
        }
    }

    /// Tests up to 16 triangles with edge functions found in f64: in f32 in the tile where that will do, else in f64.
    #[inline(never)]
    fn test_general<S: Simd>(&mut self, simd: S, ids: &[u32], masked: bool, batch: &mut Batch) {
        simd.vectorize(
            #[inline(always)]
            || self.test_general_inlined(simd, ids, masked, batch),
        );
    }

    #[inline(always)]
    fn test_general_inlined<S: Simd>(&mut self, simd: S, ids: &[u32], masked: bool, batch: &mut Batch) {
        let corner = self.corner - self.space.middle;
        let whole = Square { x: corner.x, y: corner.y, side: 2 * HALF };
        let middle = (corner + HALF).as_dvec2().to_array();
        let mut waiting = 0;
        for &id in ids {
            let triangle = General::new(self.space, self.shot.triangles.corners(id));
            let linear = if masked { None } else { triangle.linear(middle, f64::from(HALF)) };
            if let Some(linear) = linear {
                batch.set(waiting, &linear, id);
                waiting += 1;
            } else {
                self.test_square(simd, &triangle, id, masked, whole);
                self.settle_if_many();
            }
        }
        self.settle_if_many();
        let queued = self.tile.test_batch::<S, true>(simd, batch, (1 << waiting) - 1);
        self.count_queued(queued);
    }

    fn test_square<S: Simd>(&mut self, simd: S, triangle: &General, id: u32, masked: bool, square: Square) {
        let place = IVec2::new(square.x, square.y) + self.space.middle;
        let (width, height) = self.space.size();
        if place.x >= width as i32 || place.y >= height as i32 || triangle.misses(square) {
            return;
        }
        if square.side > 4 {
            square.quarters().into_iter().for_each(|quarter| self.test_square(simd, triangle, id, masked, quarter));
        } else {
            let in_tile = (place - self.corner) / 4;
            let block = in_tile.y as usize * BLOCKS + in_tile.x as usize;
            self.work.add(Kind::Tested, block * LANES..(block + 1) * LANES, 1);
            let tile = &mut *self.tile;
            simd.vectorize(
                #[inline(always)]
                || tile.test_general(simd, triangle, id, masked, block, square),
            );
        }
    }

    fn settle_if_many(&mut self) {
        const MANY: usize = 1 << 14;
        if self.tile.doubts.len() >= MANY {
            self.settle();
        }
    }

    /// Settles whatever is still undecided.
    #[cold]
    #[inline(never)]
    fn settle(&mut self) {
        self.tally.undecided += self.tile.doubts.len() as u64;
        let mut doubts = std::mem::take(&mut self.tile.doubts);
        for doubt in doubts.drain(..) {
            let index = doubt.place as usize;
            self.work.add(Kind::Undecided, index..index + 1, 1);
            let (x, y) = self.pixel(index);
            let (width, height) = self.space.size();
            if doubt.high < self.tile.low[index] || x >= width || y >= height {
                continue;
            }
            let best = self.tile.triangle[index];
            let settled = settle::nearest(self.shot, (x, y), best, doubt.triangle, &mut self.tally.settled);
            if let Some(nearest) = settled {
                let inverse = (1.0 / nearest.t) as f32;
                (self.tile.low[index], self.tile.high[index]) = (inverse.next_down(), inverse.next_up());
                self.tile.triangle[index] = nearest.triangle;
            }
        }
        self.tile.doubts = doubts;
    }

    /// Copies the tile to the image.
    #[inline(always)]
    fn write<S: Simd>(&mut self, simd: S, triangle: &mut [u32], inverse_depth: &mut [f32]) {
        triangle.copy_from_slice(&self.tile.triangle);
        for (block, inverse_depth) in inverse_depth.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let unsure = self.tile.write_middles(simd, block, inverse_depth);
            for lane in lanes_of(unsure) {
                inverse_depth[lane as usize % LANES] = self.inverse_depth(block * LANES + lane as usize);
                self.tally.refined += 1;
            }
        }
        let (width, height) = self.space.size();
        let is_whole = self.corner.x + 2 * HALF <= width as i32 && self.corner.y + 2 * HALF <= height as i32;
        if !is_whole {
            for place in 0..SAMPLES {
                let (x, y) = self.pixel(place);
                if x >= width || y >= height {
                    (triangle[place], inverse_depth[place]) = (SeenPixels::NONE, f32::NAN);
                }
            }
        }
    }

    /// The inverse depth of what is seen at a place, in f64 or by the predicate.
    #[cold]
    #[inline(never)]
    fn inverse_depth(&self, place: usize) -> f32 {
        let (x, y) = self.pixel(place);
        let id = self.tile.triangle[place];
        if id == SeenPixels::NONE {
            return f32::NAN;
        }
        let (ray, corners) = (self.space.ray(x, y), self.shot.triangles.corners(id));
        let of_predicate = || crossing(&ray, corners).map(|crossing| SeenPixels::inverse_of(crossing.t));
        depth::inverse_depth(&ray, corners).or_else(of_predicate).unwrap_or(f32::NAN)
    }

    /// Column and row in the image of a place in the tile.
    fn pixel(&self, place: usize) -> (u32, u32) {
        let (block, sample) = (place / LANES, place % LANES);
        let x = self.corner.x as u32 + (block % BLOCKS * 4 + sample % 4) as u32;
        let y = self.corner.y as u32 + (block / BLOCKS * 4 + sample / 4) as u32;
        (x, y)
    }
}

/// Makes a tile show nothing. In most frames it did so before: reading that takes less time than writing it.
#[inline(always)]
fn leave_empty(triangle: &mut [u32], inverse_depth: &mut [f32]) {
    if triangle.iter().fold(SeenPixels::NONE, |all, id| all & id) != SeenPixels::NONE {
        triangle.fill(SeenPixels::NONE);
    }
    if !inverse_depth.iter().fold(true, |all, inverse| all & inverse.is_nan()) {
        inverse_depth.fill(f32::NAN);
    }
}

/// Whether ranges of samples have any that is in the tile and, in tile-local coordinates, not after `last`.
#[inline(always)]
fn overlaps<S: Simd>(simd: S, [low, high]: [f32x16<S>; 2], last: i32) -> mask32x16<S> {
    let last = splat(simd, last.min(HALF - 1) as f32);
    high.simd_ge(low) & high.simd_ge(splat(simd, -HALF as f32)) & low.simd_le(last)
}
