use std::sync::{Mutex, PoisonError};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};
use glam::IVec2;
use rayon::prelude::*;

use super::ListedGrid;
use super::blocks::{Batch, Block};
use super::sort::TileCells;
use crate::camera_grid::build::lanes_of;
use crate::camera_grid::depth::depth_error;
use crate::camera_grid::general::{General, Square};
use crate::camera_grid::lanes::{Corners, LANES, Setup, each, largest, sample_range, splat};
use crate::camera_grid::pixel_space::{HALF_ULP, Vertex};
use crate::camera_grid::samples::{BLOCKS, SAMPLES, Samples, TileOfShot};
use crate::shot::{Counts, Kind, SeenPixels, Shot, TileOrder, TileWork};
use crate::simd::lanes::min3;

impl ListedGrid {
    /// Finds what each pixel sees: bit for bit the same on any number of threads and at every SIMD level. Counts the work of
    /// pixels in `work`, which has an entry for each.
    pub(super) fn trace_tiles<const N: usize>(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut [[u32; N]],
    ) -> Counts {
        let order = self.order();
        seen.resize(order.size().0, order.size().1);
        let Some(space) = &self.space else { return Counts::default() };
        self.scratch.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let grid = &*self;
        let triangle_tiles = seen.triangle.par_chunks_mut(SAMPLES);
        let tiles = triangle_tiles.zip(seen.inverse_depth.par_chunks_mut(SAMPLES)).zip(work.par_chunks_mut(SAMPLES));
        let tiles = tiles.zip(&grid.tiles).enumerate().with_max_len(1);
        let counted = tiles.map(|(index, (((triangle, inverse_depth), work), cells))| {
            // A thread waits for nobody here, since each has its own samples.
            let thread = rayon::current_thread_index().unwrap_or(grid.scratch.len() - 1);
            let mut samples = grid.scratch[thread].lock().unwrap_or_else(PoisonError::into_inner);
            let (x, y) = order.column_and_row(index * SAMPLES);
            let mut trace = TileTrace {
                grid,
                at: TileOfShot { shot, space, corner: IVec2::new(x as i32, y as i32) },
                cells,
                samples: &mut samples,
                work: TileWork(work),
                tally: Counts { pairs: cells.pairs() as u64, ..Counts::default() },
            };
            dispatch!(grid.level.0, simd => trace.run(simd, inverse_depth));
            triangle.copy_from_slice(&trace.samples.triangle);
            trace.refine(inverse_depth);
            trace.tally
        });
        let counted = counted.reduce(Counts::default, Counts::plus);
        Counts { dropped: self.dropped, ..counted }
    }
}

/// The search of one tile of the [`TileOrder`].
pub(super) struct TileTrace<'a, const N: usize> {
    grid: &'a ListedGrid,
    at: TileOfShot<'a>,
    cells: &'a TileCells,
    samples: &'a mut Samples,
    work: TileWork<'a, N>,
    tally: Counts,
}

/// The tracing tile that is searched.
struct TracingTile {
    /// First sorting column and row in the tile.
    first: IVec2,
    /// Its middle in pixel space: where coordinates have their origin.
    origin: IVec2,
    slice: u32,
}

/// Triangles that wait for their set-up, each with its sorting tile in the tracing tile.
struct Waiting {
    ids: [u32; LANES],
    sorting_tiles: [u32; LANES],
    count: usize,
    batch: Batch,
}

impl<const N: usize> TileTrace<'_, N> {
    /// Searches one tracing tile after the other, and writes inverse depths where they are good enough, else NaN.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, inverse_depth: &mut [f32]) {
        self.samples.clear();
        self.leave_out_what_is_outside();
        let cells = self.grid.options.cells;
        let mut waiting = Waiting { ids: [0; LANES], sorting_tiles: [0; LANES], count: 0, batch: Batch::default() };
        let sorting_tiles = 1_i32 << cells.bits_in_tile();
        let k = cells.tracing_tiles() as i32;
        for y in (0..sorting_tiles).step_by(k as usize) {
            for x in (0..sorting_tiles).step_by(k as usize) {
                let first = IVec2::new(x, y);
                let side = cells.sorting_tile() as i32;
                let origin = self.at.corner - self.at.space.middle + first * side + IVec2::splat(k * side / 2);
                let tile = TracingTile { first, origin, slice: 0 };
                if N > 0 {
                    self.count_pairs(&tile);
                }
                self.search(simd, tile, &mut waiting);
            }
        }
        self.samples.write_depths(simd, inverse_depth);
    }

    /// Gives samples outside of the image the nearest hit that there can be, so that nothing is searched for them.
    fn leave_out_what_is_outside(&mut self) {
        let (width, height) = self.at.space.size();
        let side = TileOrder::TILE;
        if self.at.corner.x as u32 + side > width || self.at.corner.y as u32 + side > height {
            for index in 0..SAMPLES {
                let (x, y) = self.at.pixel(index);
                if x >= width || y >= height {
                    (self.samples.low[index], self.samples.high[index]) = (f32::INFINITY, f32::INFINITY);
                }
            }
        }
    }

    /// Fills in the inverse depths that the filter left out.
    fn refine(&mut self, inverse_depth: &mut [f32]) {
        for (index, inverse_depth) in inverse_depth.iter_mut().enumerate() {
            let id = self.samples.triangle[index];
            if inverse_depth.is_nan() && id != SeenPixels::NONE {
                self.tally.refined += 1;
                *inverse_depth = self.at.inverse_depth(index, id);
            }
        }
    }

    fn settle_if_many(&mut self) {
        self.at.settle_if_many(self.samples, &mut self.work, &mut self.tally);
    }

    /// Searches a tracing tile slice by slice, each of its sorting tiles until nothing nearer can follow there.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, mut tile: TracingTile, waiting: &mut Waiting) {
        let cells = self.grid.options.cells;
        let k = cells.tracing_tiles();
        let last = self.grid.slices.count();
        let cell_of = |sorting_tile: u32, slice: u32| {
            let (x, y) = (tile.first.x as u32 + sorting_tile % k, tile.first.y as u32 + sorting_tile / k);
            (cells.first_in_tile(x, y) + slice) as usize
        };
        let mut searching = if k == 8 { u64::MAX } else { (1 << (k * k)) - 1 };
        for slice in 0..last {
            tile.slice = slice;
            let mut searched = 0;
            for sorting_tile in lanes_of(searching) {
                let cell = cell_of(sorting_tile, slice);
                if self.cells.cells(cell..cell_of(sorting_tile, last)).is_empty() {
                    searching &= !(1 << sorting_tile);
                    continue;
                }
                let listed = self.cells.cells(cell..cell + 1);
                if !listed.is_empty() {
                    searched |= 1 << sorting_tile;
                    self.tally.cells += 1;
                    if N > 0 {
                        self.count_cell(&tile, sorting_tile);
                    }
                }
                for &id in listed {
                    (waiting.ids[waiting.count], waiting.sorting_tiles[waiting.count]) = (id, sorting_tile);
                    waiting.count += 1;
                    if waiting.count == LANES {
                        self.test(simd, &tile, waiting);
                    }
                }
            }
            if searching == 0 {
                break;
            }
            self.test(simd, &tile, waiting);
            self.at.settle(self.samples, &mut self.work, &mut self.tally);
            for sorting_tile in lanes_of(searched) {
                if self.is_done(simd, &tile, sorting_tile) {
                    searching &= !(1 << sorting_tile);
                }
            }
        }
    }

    /// Whether nothing in later slices can be nearer than what the samples of a sorting tile have.
    #[inline(always)]
    fn is_done<S: Simd>(&self, simd: S, tile: &TracingTile, sorting_tile: u32) -> bool {
        let end = self.grid.slices.end(tile.slice);
        self.blocks(tile, sorting_tile).all(|block| self.samples.farthest(simd, block.index) >= end)
    }

    /// Counts a cell for all samples of its sorting tile.
    fn count_cell(&mut self, tile: &TracingTile, sorting_tile: u32) {
        for block in self.blocks(tile, sorting_tile) {
            self.work.add(Kind::Cells, block.samples(), 1);
        }
    }

    /// Counts what each sorting tile lists, in all slices together, for all of its samples.
    fn count_pairs(&mut self, tile: &TracingTile) {
        let (cells, slices) = (self.grid.options.cells, self.grid.slices.count());
        let k = cells.tracing_tiles();
        for sorting_tile in 0..k * k {
            let (x, y) = (tile.first.x as u32 + sorting_tile % k, tile.first.y as u32 + sorting_tile / k);
            let first = cells.first_in_tile(x, y) as usize;
            let pairs = self.cells.cells(first..first + slices as usize).len() as u32;
            for block in self.blocks(tile, sorting_tile) {
                self.work.add(Kind::Pairs, block.samples(), pairs);
            }
        }
    }

    /// The blocks of a sorting tile.
    #[inline(always)]
    fn blocks(&self, tile: &TracingTile, sorting_tile: u32) -> impl Iterator<Item = Block> + use<N> {
        let cells = self.grid.options.cells;
        let k = cells.tracing_tiles();
        let (column, row) = (tile.first.x as u32 + sorting_tile % k, tile.first.y as u32 + sorting_tile / k);
        let bits = cells.sorting_bits() - TileOrder::BLOCK.ilog2();
        let from_tile = (self.at.corner - self.at.space.middle - tile.origin).as_vec2();
        (0..1_usize << (2 * bits)).map(move |block| {
            let (x, y) =
                (((column as usize) << bits) + block % (1 << bits), ((row as usize) << bits) + (block >> bits));
            let at = |blocks: usize| (blocks * TileOrder::BLOCK as usize) as f32;
            Block { index: y * BLOCKS + x, x: from_tile.x + at(x), y: from_tile.y + at(y) }
        })
    }

    /// Sets up the triangles that wait and tests each on the samples of its sorting tile.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, tile: &TracingTile, waiting: &mut Waiting) {
        let count = std::mem::take(&mut waiting.count);
        if count == 0 {
            return;
        }
        let Waiting { ids, sorting_tiles, batch, .. } = waiting;
        let ordinary = self.set_up(simd, tile, &ids[..count], batch);
        let mut lane = 0;
        while lane < count {
            let sorting_tile = sorting_tiles[lane];
            let same = sorting_tiles[lane..count].iter().take_while(|&&other| other == sorting_tile).count();
            let lanes = ((1 << same) - 1) << lane & ordinary;
            if lanes != 0 {
                self.test_sorting_tile(simd, tile, sorting_tile, batch, lanes);
            }
            lane += same;
        }
        for lane in lanes_of(!ordinary & ((1 << count) - 1)) {
            let questioned = batch.questioned >> lane & 1 == 1;
            self.test_general(simd, tile, sorting_tiles[lane as usize], ids[lane as usize], questioned);
        }
    }

    /// Tests triangles on the samples of a sorting tile.
    #[inline(always)]
    fn test_sorting_tile<S: Simd>(
        &mut self,
        simd: S,
        tile: &TracingTile,
        sorting_tile: u32,
        batch: &Batch,
        lanes: u64,
    ) {
        self.settle_if_many();
        let skips = self.grid.options.skips_blocks;
        let end = if tile.slice == 0 { f32::INFINITY } else { self.grid.slices.end(tile.slice - 1) };
        for block in self.blocks(tile, sorting_tile) {
            let tests = self.samples.test_block(simd, batch, lanes, &block, skips, end);
            self.tally.tests += u64::from(tests);
            self.work.add(Kind::Tested, block.samples(), tests);
        }
    }

    /// Sets up to 16 triangles up, and returns which of them can take the fast path.
    #[inline(always)]
    fn set_up<S: Simd>(&self, simd: S, tile: &TracingTile, ids: &[u32], batch: &mut Batch) -> u64 {
        let corners = Corners::of_ids(simd, &self.grid.vertices, self.at.shot.triangles, ids);
        let from_middle = |corner: [f32x16<S>; 3], origin: i32| {
            each(
                corner,
                #[inline(always)]
                |at| at - splat(simd, origin as f32),
            )
        };
        let (x, y) = (from_middle(corners.x, tile.origin.x), from_middle(corners.y, tile.origin.y));
        // Half an ulp for the corner, one for the move to the tile's middle.
        let error = (largest(corners.x, corners.y) + largest(x, y)) * splat(simd, 1.01 * HALF_ULP)
            + splat(simd, 1.01 * Vertex::ERROR_PIXELS);
        let cells = self.grid.options.cells;
        // How far outside of a triangle's bounds the samples are that test it: in a block, or a sorting tile, that the
        // bounds reach into.
        let reach = if self.grid.options.skips_blocks { TileOrder::BLOCK } else { cells.sorting_tile() } as f32;
        let samples = (cells.sorting_tile() * cells.tracing_tiles() / 2) as f32;
        let mut setup = Setup::new(simd, x, y, corners.inverse_depth, error, samples, reach + 0.25);
        setup.depth_error = depth_error(simd, &setup, x, y, error, samples);
        // The error again for the sums of coordinates and their errors.
        let bounds = [sample_range(x, error + error), sample_range(y, error + error)];
        batch.fill(simd, &setup, corners.inverse_depth[0], bounds);
        batch.ids[..ids.len()].copy_from_slice(ids);
        batch.questioned = self.questioned(ids);
        if self.grid.facing != 0.0 {
            let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
            let front = (area * splat(simd, self.grid.facing)).simd_gt(splat(simd, 0.0)).to_bitmask();
            batch.questioned |= !(front & batch.certain);
        }
        min3(corners.inverse_depth).simd_gt(splat(simd, 0.0)).to_bitmask() & ((1 << ids.len()) - 1)
    }

    /// A bit for each of the triangles that are masked.
    #[inline(always)]
    fn questioned(&self, ids: &[u32]) -> u64 {
        if !self.grid.any_masked {
            return 0;
        }
        let bit = |id: u32| self.grid.masked[id as usize / 64] >> (id % 64) & 1;
        ids.iter().enumerate().fold(0, |bits, (lane, &id)| bits | bit(id) << lane)
    }

    /// Tests a triangle on the general path on the samples of a sorting tile.
    #[cold]
    #[inline(never)]
    fn test_general<S: Simd>(&mut self, simd: S, tile: &TracingTile, sorting_tile: u32, id: u32, questioned: bool) {
        self.settle_if_many();
        let triangle = General::new(self.at.space, self.at.shot.triangles.corners(id));
        // Which side is seen isn't kept there.
        let questioned = questioned || self.grid.facing != 0.0;
        for block in self.blocks(tile, sorting_tile) {
            let at = IVec2::new(block.x as i32, block.y as i32) + tile.origin;
            let square = Square { x: at.x, y: at.y, side: TileOrder::BLOCK as i32 };
            if !triangle.misses(square) {
                self.tally.tests += 1;
                self.work.add(Kind::Tested, block.samples(), 1);
                let samples = &mut *self.samples;
                simd.vectorize(
                    #[inline(always)]
                    || samples.test_general(simd, &triangle, id, questioned, block.index, square),
                );
            }
        }
    }
}
