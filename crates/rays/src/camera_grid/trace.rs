use std::sync::{Mutex, PoisonError};

use crate::dispatch;
use crate::parallel::Parallel;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::{IVec2, UVec2};
use rayon::prelude::*;

use super::PerspectiveGrid;
use super::bins::{Bin, Listed};
use super::cull::PixelBox;
use super::homogeneous::{HomogeneousTriangle, Square};
use super::lanes::{Corners, DepthPlane, LANES, Setup, largest, sample_range, splat};
use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use super::samples::{BLOCKS, SAMPLES, TileOfShot};
use super::tile::{HALF, MaskWeights, TileHits, TriangleBatch, block_range};
use crate::patches::Patches;
use crate::shot::{Counts, Kind, SeenPixels, Shot, TileOrder, TileWork};
use crate::simd::each;
use crate::simd::lanes::bits_of;
use crate::vectorized;

impl PerspectiveGrid {
    /// Finds the triangle that each pixel sees: bit for bit the same on any number of threads and at every SIMD level.
    /// Counts the work of pixels in `work`, which has an entry for each; a tile is one cell there.
    pub(crate) fn trace_tiles<const N: usize>(
        &mut self,
        shot: &Shot<'_>,
        patches: &Patches,
        seen: &mut SeenPixels,
        work: &mut [[u32; N]],
    ) -> Counts {
        let Self { space: Some(space), vertices, boxes, ranges, scratch, level, .. } = self else {
            seen.resize(0, 0);
            return Counts::default();
        };
        let listed = ListedPatches { patches, vertices, boxes };
        let tiles = Tiles { shot, space };
        tiles.trace(scratch, seen, work, |tile, index, triangle, inverse_depth| {
            let bins = ranges.iter().map(|range| &range.bins[index]);
            dispatch!(*level, simd => tile.run(simd, &listed, bins.clone(), triangle, inverse_depth));
        })
    }
}

/// The inputs of the search, common to all tiles of an image.
pub struct Tiles<'a> {
    pub shot: &'a Shot<'a>,
    pub space: &'a PixelSpace,
}

/// The patches of the tiles' lists, with their projections.
pub(super) struct ListedPatches<'a> {
    pub(super) patches: &'a Patches,
    vertices: &'a [Vertex],
    pub(super) boxes: &'a [PixelBox],
}

impl ListedPatches<'_> {
    /// Up to 16 triangles given by their slots: their ids and corners.
    #[inline(always)]
    fn triangles<S: Simd>(&self, simd: S, slots: &[u32]) -> ([u32; LANES], Corners<S>) {
        let mut ids = [0; LANES];
        let mut indices = [[u32::MAX; 3]; LANES];
        for ((id, corners), &slot) in ids.iter_mut().zip(&mut indices).zip(slots) {
            (*id, *corners) = self.patches.triangle(slot);
        }
        (ids, Corners::load(simd, self.vertices, &indices))
    }
}

impl Tiles<'_> {
    /// Calls `search` with each tile, its index, and its triangles and inverse depths to write, on all threads. Returns the
    /// work. `scratch` has memory for each thread.
    pub fn trace<const N: usize>(
        &self,
        scratch: &mut Vec<Mutex<Box<TileHits>>>,
        seen: &mut SeenPixels,
        work: &mut [[u32; N]],
        search: impl Fn(&mut TileTrace<'_, N>, usize, &mut [u32], &mut [f32]) + Sync,
    ) -> Counts {
        let (width, height) = self.space.size();
        seen.resize(width, height);
        scratch.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let scratch = &*scratch;
        let triangle_tiles = seen.triangle.par_chunks_mut(SAMPLES);
        let tiles = triangle_tiles.zip(seen.inverse_depth.par_chunks_mut(SAMPLES)).zip(work.par_chunks_mut(SAMPLES));
        let counted = tiles.enumerate().with_max_len(1).map(|(index, ((triangle, inverse_depth), work))| {
            self.search(scratch, index, work, |trace| search(trace, index, triangle, inverse_depth))
        });
        counted.merge(Counts::plus).unwrap_or_default()
    }

    /// Calls `search` with the tile at `index`, in this thread's part of `scratch`. Returns the work.
    pub fn search<const N: usize>(
        &self,
        scratch: &[Mutex<Box<TileHits>>],
        index: usize,
        work: &mut [[u32; N]],
        search: impl FnOnce(&mut TileTrace<'_, N>),
    ) -> Counts {
        let &Self { shot, space } = self;
        let (width, height) = space.size();
        // No thread waits here, since each has its own tile.
        let thread = rayon::current_thread_index().unwrap_or(scratch.len() - 1);
        let mut tile = scratch[thread].lock().unwrap_or_else(PoisonError::into_inner);
        let corner = UVec2::from(TileOrder::new(width, height).column_and_row(index * SAMPLES)).as_ivec2();
        let at = TileOfShot { shot, space, corner };
        tile.place_samples(&space.shifts);
        let mut trace = TileTrace { at, tile: &mut tile, work: TileWork(work), tally: Counts::default() };
        search(&mut trace);
        trace.tally
    }
}

/// The search of one tile.
pub struct TileTrace<'a, const N: usize> {
    pub at: TileOfShot<'a>,
    pub tile: &'a mut TileHits,
    pub work: TileWork<'a, N>,
    pub tally: Counts,
}

/// Up to 16 triangles relative to the middle of a tile.
pub struct Placed<S: Simd> {
    pub corners: Corners<S>,
    pub x: [f32x16<S>; 3],
    pub y: [f32x16<S>; 3],
    /// Error bounds of a corner in the image, and here.
    corner_error: f32x16<S>,
    error: f32x16<S>,
    /// First and last column, then row, of the pixels whose samples each may hit.
    columns: [f32x16<S>; 2],
    rows: [f32x16<S>; 2],
    /// A bit for each triangle that may hit a sample of the tile that is in the image.
    pub seen: u64,
}

impl<const N: usize> TileTrace<'_, N> {
    /// Searches the tile's bins of all ranges of triangles, and writes the hit of each sample.
    #[inline(always)]
    fn run<'b, S: Simd>(
        &mut self,
        simd: S,
        listed: &ListedPatches<'_>,
        bins: impl Iterator<Item = &'b Bin> + Clone,
        triangle: &mut [u32],
        inverse_depth: &mut [f32],
    ) {
        if bins.clone().all(Bin::is_empty) {
            leave_empty(triangle, inverse_depth);
            return;
        }
        self.tile.clear();
        let pairs: usize = bins.clone().flat_map(Bin::lists).map(Vec::len).sum();
        self.tally.pairs += pairs as u64;
        self.work.add(Kind::Pairs, 0..SAMPLES, pairs as u32);
        let ordinary = bins.clone().flat_map(|bin| [&*bin.ordinary, &*bin.patches]);
        self.tile.order.sort_by_depth(ordinary, bins.clone().map(|bin| &*bin.general));
        self.test_nearest_first::<S, false>(simd, listed);
        for bin in bins.clone() {
            self.tally.fragments += bin.fragments.len() as u64;
            for fragments in bin.fragments.chunks(SAMPLES) {
                for fragment in fragments {
                    let index = fragment.index as usize % SAMPLES;
                    self.work.add(Kind::Tested, index..index + 1, 1);
                    self.tile.merge(fragment);
                }
                self.settle_if_many();
            }
        }
        // Masked triangles come last: the more of them are hidden, the fewer queries of the mask there are.
        let (ordinary, general) = (bins.clone().map(|bin| &*bin.masked), bins.map(|bin| &*bin.masked_general));
        self.tile.order.sort_by_depth(ordinary, general);
        self.test_nearest_first::<S, true>(simd, listed);
        self.settle();
        if self.tally.pairs + self.tally.fragments > 0 {
            self.work.add(Kind::Cells, 0..SAMPLES, 1);
        }
        self.write(simd, triangle, inverse_depth);
    }

    /// Tests the triangles in the tile's order, all of them masked or none, except those behind all hits so far.
    #[inline(always)]
    fn test_nearest_first<S: Simd, const MASKED: bool>(&mut self, simd: S, patches: &ListedPatches<'_>) {
        if self.tile.order.listed().is_empty() {
            return;
        }
        let order = std::mem::take(&mut self.tile.order);
        let mut batch = TriangleBatch::default();
        let (mut slots, mut waiting, mut farthest) = ([0; LANES], 0, 0.0);
        let (mut general, mut waiting_general) = ([0; LANES], 0);
        for listed in order.listed() {
            if listed.nearest.is_sign_negative() {
                (general[waiting_general], _) = patches.patches.triangle(listed.slot);
                waiting_general += usize::from(-listed.nearest >= farthest);
                if waiting_general == LANES {
                    self.test_general(simd, &general, MASKED, &mut batch);
                    waiting_general = 0;
                    farthest = self.tile.farthest(simd);
                }
                continue;
            }
            if listed.slot & Listed::PATCH != 0 {
                let number = (listed.slot & !Listed::PATCH) as usize;
                if listed.nearest >= farthest && self.test_patch(simd, patches, number, listed.nearest, &mut batch) {
                    farthest = self.tile.farthest(simd);
                }
                continue;
            }
            slots[waiting] = listed.slot;
            waiting += usize::from(listed.nearest >= farthest);
            if waiting == LANES {
                self.test_listed::<S, MASKED>(simd, patches, &slots, &mut batch);
                waiting = 0;
                farthest = self.tile.farthest(simd);
            }
        }
        self.test_general(simd, &general[..waiting_general], MASKED, &mut batch);
        self.test_listed::<S, MASKED>(simd, patches, &slots[..waiting], &mut batch);
        self.test_rest(simd, &mut batch);
        self.tile.order = order;
    }

    /// Tests up to 16 triangles on the fast path, all of them masked or none.
    #[inline(never)]
    fn test_listed<S: Simd, const MASKED: bool>(
        &mut self,
        simd: S,
        patches: &ListedPatches<'_>,
        slots: &[u32],
        batch: &mut TriangleBatch,
    ) {
        vectorized!(simd => {
            let (ids, corners) = patches.triangles(simd, slots);
            self.test_ordinary::<S, MASKED>(simd, &ids, corners, (1 << slots.len()) - 1, batch);
        });
    }

    /// Tests the triangles in `lanes`, of 16 on the fast path, all of them masked or none.
    #[inline(always)]
    pub(super) fn test_ordinary<S: Simd, const MASKED: bool>(
        &mut self,
        simd: S,
        ids: &[u32; LANES],
        corners: Corners<S>,
        lanes: u64,
        batch: &mut TriangleBatch,
    ) {
        let mut placed = self.place(simd, corners);
        placed.seen &= lanes;
        if placed.seen == 0 {
            return;
        }
        const OVERHANG_PIXELS: f32 = 3.25;
        let (setup, certain) = self.set_up(simd, &placed, ids, OVERHANG_PIXELS, batch);
        let Placed { corners, x, y, error, seen, .. } = placed;
        self.settle_if_many();
        let queued = if MASKED {
            let weights = MaskWeights::new(simd, self.at.space, &corners, &setup, [x, y], error);
            self.tile.test_masked(simd, batch, &weights, self.at.shot.opacity, seen & certain)
        } else {
            self.tile.test_batch::<S, true>(simd, batch, seen & certain)
        };
        self.count_queued(queued);
        if seen & !certain != 0 {
            let queued = self.tile.test_batch::<S, false>(simd, batch, seen & !certain);
            self.count_queued(queued);
        }
    }

    /// Transforms 16 triangles to the tile's coordinates.
    #[inline(always)]
    pub fn place<S: Simd>(&self, simd: S, corners: Corners<S>) -> Placed<S> {
        let origin = self.at.corner - self.at.space.middle + IVec2::splat(HALF);
        let x = each!(x in corners.x => x - splat(simd, origin.x as f32));
        let y = each!(y in corners.y => y - splat(simd, origin.y as f32));
        // Half an ulp for the corner, one for the move to the tile's middle.
        let corner_error =
            largest(corners.x, corners.y) * splat(simd, 1.01 * HALF_ULP) + splat(simd, 1.01 * Vertex::ERROR_PIXELS);
        let error = corner_error + largest(x, y) * splat(simd, 1.01 * HALF_ULP);
        // The same again for the sums of coordinates and their errors.
        let beside = error + error + splat(simd, self.at.space.shifts.reach());
        let (columns, rows) = (sample_range(x, beside), sample_range(y, beside));
        let (width, height) = self.at.space.size();
        let last = IVec2::new(width as i32, height as i32) - 1 - self.at.corner - HALF;
        let seen = overlaps(simd, columns, last.x) & overlaps(simd, rows, last.y);
        let seen = seen.to_bitmask();
        Placed { corners, x, y, corner_error, error, columns, rows, seen }
    }

    /// Sets the triangles up for samples of pixels at most `overhang` outside of their bounds. Returns a bit for each
    /// triangle with a certain orientation.
    #[inline(always)]
    pub fn set_up<S: Simd>(
        &self,
        simd: S,
        placed: &Placed<S>,
        ids: &[u32],
        overhang: f32,
        batch: &mut TriangleBatch,
    ) -> (Setup<S>, u64) {
        let &Placed { ref corners, x, y, corner_error, error, columns, rows, .. } = placed;
        let origin = (self.at.corner - self.at.space.middle + HALF).as_vec2().to_array();
        // Bounds are those of pixels, which are as far outside as samples may be from them, and samples as far again.
        let shift = self.at.space.shifts.reach();
        let (samples, overhang) = (HALF as f32 + shift, overhang + 2.0 * shift);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, error, samples, overhang);
        let certain = setup.is_certain(simd);
        let plane = DepthPlane::new(simd, corners, corner_error, origin, samples);
        batch.fill(simd, &setup, &plane, certain);
        batch.ids[..ids.len()].copy_from_slice(ids);
        let ranges = [block_range(simd, columns[0], columns[1]), block_range(simd, rows[0], rows[1])];
        for (blocks, range) in batch.blocks.iter_mut().zip(ranges.as_flattened()) {
            range.store_slice(blocks);
        }
        (setup, certain.to_bitmask())
    }

    /// Counts the tests of the blocks that were queued last.
    #[inline(always)]
    pub fn count_queued(&mut self, [waiting, covered]: [usize; 2]) {
        if N > 0 {
            for &queued in self.tile.queue[..waiting].iter().chain(&self.tile.covered[..covered]) {
                let first = queued as usize % (BLOCKS * BLOCKS) * LANES;
                self.work.add(Kind::Tested, first..first + LANES, 1);
            }
        }
    }

    /// Tests up to 16 triangles with edge functions from f64: in f32 in the tile where that suffices, else in f64.
    #[inline(never)]
    fn test_general<S: Simd>(&mut self, simd: S, ids: &[u32], masked: bool, batch: &mut TriangleBatch) {
        vectorized!(simd => self.test_general_inlined(simd, ids, masked, batch));
    }

    #[inline(always)]
    fn test_general_inlined<S: Simd>(&mut self, simd: S, ids: &[u32], masked: bool, batch: &mut TriangleBatch) {
        let corner = self.at.corner - self.at.space.middle;
        let whole = Square { x: corner.x, y: corner.y, side: 2 * HALF };
        let middle = (corner + HALF).as_dvec2().to_array();
        let mut waiting = 0;
        for &id in ids {
            let triangle = HomogeneousTriangle::new(self.at.space, self.at.shot.triangles.corners(id));
            let reach = f64::from(HALF) + f64::from(self.at.space.shifts.reach());
            let linear = if masked { None } else { triangle.linear(middle, reach) };
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

    fn test_square<S: Simd>(&mut self, simd: S, triangle: &HomogeneousTriangle, id: u32, masked: bool, square: Square) {
        let first = IVec2::new(square.x, square.y) + self.at.space.middle;
        let (width, height) = self.at.space.size();
        if first.x >= width as i32 || first.y >= height as i32 || triangle.misses(square) {
            return;
        }
        if square.side > 4 {
            square.quarters().into_iter().for_each(|quarter| self.test_square(simd, triangle, id, masked, quarter));
        } else {
            let in_tile = (first - self.at.corner) / 4;
            let block = in_tile.y as usize * BLOCKS + in_tile.x as usize;
            self.work.add(Kind::Tested, block * LANES..(block + 1) * LANES, 1);
            let tile = &mut *self.tile;
            vectorized!(simd => tile.test_general(simd, triangle, id, masked, block, square));
        }
    }

    pub fn settle_if_many(&mut self) {
        let at = self.at;
        at.settle_if_many(&mut self.tile.samples, &mut self.work, &mut self.tally);
    }

    pub fn settle(&mut self) {
        let at = self.at;
        at.settle(&mut self.tile.samples, &mut self.work, &mut self.tally);
    }

    /// Copies the tile to the image.
    #[inline(always)]
    pub fn write<S: Simd>(&mut self, simd: S, triangle: &mut [u32], inverse_depth: &mut [f32]) {
        triangle.copy_from_slice(&self.tile.samples.triangle);
        for (block, inverse_depth) in inverse_depth.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let unsure = self.tile.write_middles(simd, block, inverse_depth);
            for lane in bits_of(unsure) {
                let index = block * LANES + lane;
                let id = self.tile.samples.triangle[index];
                inverse_depth[lane % LANES] = self.at.inverse_depth(index, id);
                self.tally.refined += u64::from(id != SeenPixels::NONE);
            }
        }
        let (width, height) = self.at.space.size();
        let is_whole = self.at.corner.x + 2 * HALF <= width as i32 && self.at.corner.y + 2 * HALF <= height as i32;
        if !is_whole {
            for index in 0..SAMPLES {
                let (x, y) = self.at.pixel(index);
                if x >= width || y >= height {
                    (triangle[index], inverse_depth[index]) = (SeenPixels::NONE, f32::NAN);
                }
            }
        }
    }
}

/// Clears a tile. In most frames it was empty before: reading it is faster than writing it.
#[inline(always)]
fn leave_empty(triangle: &mut [u32], inverse_depth: &mut [f32]) {
    if triangle.iter().fold(SeenPixels::NONE, |all, id| all & id) != SeenPixels::NONE {
        triangle.fill(SeenPixels::NONE);
    }
    if !inverse_depth.iter().fold(true, |all, inverse| all & inverse.is_nan()) {
        inverse_depth.fill(f32::NAN);
    }
}

/// Whether ranges of samples overlap the tile, in tile-local coordinates, up to `last`.
#[inline(always)]
fn overlaps<S: Simd>(simd: S, [low, high]: [f32x16<S>; 2], last: i32) -> mask32x16<S> {
    let last = splat(simd, last.min(HALF - 1) as f32);
    high.simd_ge(low) & high.simd_ge(splat(simd, -HALF as f32)) & low.simd_le(last)
}
