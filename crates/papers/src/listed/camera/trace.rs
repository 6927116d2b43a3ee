use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::IVec2;
use umbrage_rays::camera_grid::homogeneous::{HomogeneousTriangle, Square};
use umbrage_rays::camera_grid::lanes::Corners;
use umbrage_rays::camera_grid::samples::{BLOCKS, SAMPLES};
use umbrage_rays::camera_grid::tile::{TileHits, TriangleBatch, queued};
use umbrage_rays::camera_grid::trace::{Placed, TileTrace, Tiles};
use umbrage_rays::dispatch;
use umbrage_rays::shot::{Counts, Kind, SeenPixels, Shot, TileOrder};
use umbrage_rays::simd::lanes::{LANES, bits_of, min3, splat};
use umbrage_rays::vectorized;

use super::ListedGrid;
use super::crowded::ListShare;
use crate::listed::sorted::Sorted;

impl ListedGrid {
    /// Finds the triangle that each pixel sees: bit for bit the same on any number of threads and at every SIMD level.
    /// Counts the work of pixels in `work`, which has an entry for each.
    pub(crate) fn trace_tiles<const N: usize>(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut [[u32; N]],
    ) -> Counts {
        let Some(space) = self.space else {
            seen.resize(0, 0);
            return Counts::default();
        };
        let tiles = Tiles { shot, space: &space };
        let (mut scratch, mut crowded) = (std::mem::take(&mut self.scratch), std::mem::take(&mut self.crowded));
        crowded.divide(&self.tiles, self.options.most_triangles);
        let of_parts = crowded.search(&tiles, &mut scratch, work, |tile, index, part| {
            let mut trace = ListedTrace { grid: self, cells: &self.tiles[index], part, tile };
            dispatch!(self.level, simd => trace.run(simd));
        });
        let counted = tiles.trace(&mut scratch, seen, work, |tile, index, triangle, inverse_depth| {
            let cells = &self.tiles[index];
            dispatch!(self.level, simd => {
                if !crowded.merge(tile, index) {
                    ListedTrace { grid: self, cells, part: ListShare::WHOLE, tile }.run(simd);
                }
                tile.write(simd, triangle, inverse_depth);
            });
            tile.tally.pairs = cells.items().len() as u64;
        });
        (self.scratch, self.crowded) = (scratch, crowded);
        Counts { dropped: self.dropped, ..counted.plus(of_parts) }
    }
}

/// The search of one tile of the [`TileOrder`], or of one part of its triangles.
struct ListedTrace<'a, 'b, const N: usize> {
    grid: &'a ListedGrid,
    cells: &'a Sorted<u32>,
    part: ListShare,
    tile: &'a mut TileTrace<'b, N>,
}

/// The tracing tile being searched.
struct TracingTile {
    /// First sorting column and row in the tile.
    first: [u32; 2],
    slice: u32,
}

/// Triangles that wait for setup, each with its sorting tile in the tracing tile.
struct AwaitingSetup {
    ids: [u32; LANES],
    sorting_tiles: [u32; LANES],
    count: usize,
    batch: TriangleBatch,
}

impl<const N: usize> ListedTrace<'_, '_, N> {
    /// Searches one tracing tile after the other.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        self.tile.tile.clear();
        self.leave_out_what_is_outside();
        self.tile.tile.note_farthest(simd);
        let cells = self.grid.options.cells;
        let mut waiting =
            AwaitingSetup { ids: [0; LANES], sorting_tiles: [0; LANES], count: 0, batch: TriangleBatch::default() };
        let sorting_tiles = 1 << cells.bits_in_tile();
        let k = cells.tracing_tiles() as usize;
        for y in (0..sorting_tiles).step_by(k) {
            for x in (0..sorting_tiles).step_by(k) {
                let tile = TracingTile { first: [x, y], slice: 0 };
                if N > 0 && self.part.is_first() {
                    self.count_pairs(&tile);
                }
                self.search(simd, tile, &mut waiting);
            }
        }
    }

    /// Gives samples outside of the image an infinitely near hit, so that they are never searched.
    fn leave_out_what_is_outside(&mut self) {
        let TileTrace { at, tile, .. } = &mut *self.tile;
        let (width, height) = at.space.size();
        let side = TileOrder::TILE;
        if at.corner.x as u32 + side > width || at.corner.y as u32 + side > height {
            for index in 0..SAMPLES {
                let (x, y) = at.pixel(index);
                if x >= width || y >= height {
                    (tile.samples.low[index], tile.samples.high[index]) = (f32::INFINITY, f32::INFINITY);
                }
            }
        }
    }

    /// Searches a tracing tile slice by slice. Each sorting tile is searched until nothing nearer can follow there.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, mut tile: TracingTile, waiting: &mut AwaitingSetup) {
        let cells = self.grid.options.cells;
        let k = cells.tracing_tiles();
        let last = self.grid.slices.count();
        let cell_of = |sorting_tile: u32, slice: u32| {
            (cells.first_in_tile(tile.first[0] + sorting_tile % k, tile.first[1] + sorting_tile / k) + slice) as usize
        };
        let mut searching = if k == 8 { u64::MAX } else { (1 << (k * k)) - 1 };
        for slice in 0..last {
            tile.slice = slice;
            let mut searched = 0_u64;
            for sorting_tile in bits_of(searching) {
                let sorting_tile = sorting_tile as u32;
                let cell = cell_of(sorting_tile, slice);
                if self.cells.of(cell..cell_of(sorting_tile, last)).is_empty() {
                    searching &= !(1 << sorting_tile);
                    continue;
                }
                let listed = self.part.of(self.cells.of(cell..cell + 1));
                if !listed.is_empty() {
                    searched |= 1 << sorting_tile;
                    self.tile.tally.cells += 1;
                    if N > 0 {
                        self.count(Kind::Cells, &tile, sorting_tile, 1);
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
            self.tile.settle();
            self.tile.tile.note_farthest(simd);
            for sorting_tile in bits_of(searched) {
                if self.is_done(&tile, sorting_tile as u32) {
                    searching &= !(1 << sorting_tile);
                }
            }
        }
    }

    /// Whether nothing in later slices can be nearer than the hits of a sorting tile's samples.
    fn is_done(&self, tile: &TracingTile, sorting_tile: u32) -> bool {
        let end = self.grid.slices.end(tile.slice);
        self.blocks(tile, sorting_tile).all(|block| self.tile.tile.farthest[block] >= end)
    }

    /// Counts a kind of work for all samples of a sorting tile.
    fn count(&mut self, kind: Kind, tile: &TracingTile, sorting_tile: u32, times: u32) {
        for block in self.blocks(tile, sorting_tile) {
            self.tile.work.add(kind, block * LANES..(block + 1) * LANES, times);
        }
    }

    /// Counts the pairs of each sorting tile, in all slices together, for all of its samples.
    fn count_pairs(&mut self, tile: &TracingTile) {
        let (cells, slices) = (self.grid.options.cells, self.grid.slices.count());
        let k = cells.tracing_tiles();
        for sorting_tile in 0..k * k {
            let first =
                cells.first_in_tile(tile.first[0] + sorting_tile % k, tile.first[1] + sorting_tile / k) as usize;
            let pairs = self.cells.of(first..first + slices as usize).len() as u32;
            self.count(Kind::Pairs, tile, sorting_tile, pairs);
        }
    }

    /// First and last column, then row, of the blocks of a sorting tile.
    #[inline(always)]
    fn bounds(&self, tile: &TracingTile, sorting_tile: u32) -> [[usize; 2]; 2] {
        let cells = self.grid.options.cells;
        let (k, side) = (cells.tracing_tiles(), cells.sorting_tile() / TileOrder::BLOCK);
        let first = [tile.first[0] + sorting_tile % k, tile.first[1] + sorting_tile / k].map(|at| (at * side) as usize);
        first.map(|first| [first, first + side as usize - 1])
    }

    /// The blocks of a sorting tile.
    #[inline(always)]
    fn blocks(&self, tile: &TracingTile, sorting_tile: u32) -> impl Iterator<Item = usize> + use<N> {
        let [[left, right], [top, bottom]] = self.bounds(tile, sorting_tile);
        (top..=bottom).flat_map(move |y| (left..=right).map(move |x| y * BLOCKS + x))
    }

    /// Sets up the waiting triangles and tests each on the samples of its sorting tile.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, tile: &TracingTile, waiting: &mut AwaitingSetup) {
        let count = std::mem::take(&mut waiting.count);
        if count == 0 {
            return;
        }
        let AwaitingSetup { ids, sorting_tiles, batch, .. } = waiting;
        let (ids, all) = (&ids[..count], (1 << count) - 1);
        let mut indices = [[u32::MAX; 3]; LANES];
        for (corners, &id) in indices.iter_mut().zip(ids) {
            *corners = self.tile.at.shot.triangles.indices[id as usize];
        }
        let corners = Corners::load(simd, &self.grid.vertices, &indices);
        let mut placed = self.tile.place(simd, corners);
        placed.seen &= all;
        let ordinary = min3(placed.corners.inverse_depth).simd_gt(splat(simd, 0.0)).to_bitmask() & all;
        // Largest distance between a triangle's bounds and the samples that test it: these are in a block, or a sorting
        // tile, that overlaps the bounds.
        let options = self.grid.options;
        let reach = if options.skips_blocks { TileOrder::BLOCK } else { options.cells.sorting_tile() };
        let (_, certain) = self.tile.set_up(simd, &placed, ids, reach as f32 + 0.25, batch);
        let questioned = self.questioned(simd, ids, &placed, certain);
        self.tile.settle_if_many();
        let tested = if options.skips_blocks { ordinary & placed.seen } else { ordinary };
        self.test_lanes::<S, true>(simd, tile, sorting_tiles, batch, tested & certain, questioned);
        if tested & !certain != 0 {
            self.test_lanes::<S, false>(simd, tile, sorting_tiles, batch, tested & !certain, questioned);
        }
        for lane in bits_of(!ordinary & all) {
            self.test_general(simd, tile, sorting_tiles[lane], ids[lane], questioned >> lane & 1 == 1);
        }
    }

    /// Tests triangles of a batch, all with an orientation that is `CERTAIN` or not, on the samples of their sorting tiles.
    /// With block skipping, only blocks that their bounds overlap and where they may be nearer than the hits are tested;
    /// otherwise all blocks except those with nearer hits than this slice. The predicate has to settle every hit of
    /// `questioned` triangles.
    #[inline(always)]
    fn test_lanes<S: Simd, const CERTAIN: bool>(
        &mut self,
        simd: S,
        tile: &TracingTile,
        sorting_tiles: &[u32; LANES],
        batch: &TriangleBatch,
        lanes: u64,
        questioned: u64,
    ) {
        let skips = self.grid.options.skips_blocks;
        let end = if tile.slice == 0 { f32::INFINITY } else { self.grid.slices.end(tile.slice - 1) };
        let mut waiting = 0;
        for lane in bits_of(lanes) {
            let lane = lane % LANES;
            let [[mut left, mut right], [mut top, mut bottom]] = self.bounds(tile, sorting_tiles[lane]);
            if skips {
                let [x0, x1, y0, y1] = batch.blocks.each_ref().map(|bounds| bounds[lane] as usize % BLOCKS);
                (left, right, top, bottom) = (left.max(x0), right.min(x1), top.max(y0), bottom.min(y1));
            }
            let TileHits { queue, farthest, .. } = &mut *self.tile.tile;
            for y in top..=bottom {
                for block in y * BLOCKS + left..y * BLOCKS + right + 1 {
                    queue[waiting] = queued(lane, block);
                    let farthest = farthest[block];
                    waiting += usize::from(if skips { batch.nearest[lane] >= farthest } else { farthest < end });
                }
            }
        }
        self.tile.tally.tests += waiting as u64;
        self.tile.tile.test_queue::<S, CERTAIN>(simd, batch, waiting, !questioned);
        self.tile.count_queued([waiting, 0]);
    }

    /// A bit for each triangle that is masked, or may show a back that doesn't stop rays.
    #[inline(always)]
    fn questioned<S: Simd>(&self, simd: S, ids: &[u32], Placed { x, y, .. }: &Placed<S>, certain: u64) -> u64 {
        let ListedGrid { any_masked, masked, facing, .. } = self.grid;
        let mut questioned = 0;
        if *any_masked {
            let bit = |id: u32| masked[id as usize / 64] >> (id % 64) & 1;
            questioned = ids.iter().enumerate().fold(0, |bits, (lane, &id)| bits | bit(id) << lane);
        }
        if *facing != 0.0 {
            let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
            let front = (area * splat(simd, *facing)).simd_gt(splat(simd, 0.0)).to_bitmask();
            let sides = self.tile.at.shot.sides;
            let backs =
                ids.iter().enumerate().fold(0, |bits, (lane, &id)| bits | u64::from(sides.has_back(id)) << lane);
            questioned |= !(front & certain | backs);
        }
        questioned
    }

    /// Tests a triangle of the general path on the samples of a sorting tile.
    #[cold]
    #[inline(never)]
    fn test_general<S: Simd>(&mut self, simd: S, tile: &TracingTile, sorting_tile: u32, id: u32, questioned: bool) {
        self.tile.settle_if_many();
        let at = self.tile.at;
        let triangle = HomogeneousTriangle::new(at.space, at.shot.triangles.corners(id));
        // The visible side isn't known there.
        let questioned = questioned || !at.shot.sides.has_back(id);
        for block in self.blocks(tile, sorting_tile) {
            let first = at.corner - at.space.middle + IVec2::new((block % BLOCKS) as i32, (block / BLOCKS) as i32) * 4;
            let square = Square { x: first.x, y: first.y, side: TileOrder::BLOCK as i32 };
            if !triangle.misses(square) {
                self.tile.tally.tests += 1;
                self.tile.work.add(Kind::Tested, block * LANES..(block + 1) * LANES, 1);
                let tile = &mut *self.tile.tile;
                vectorized!(simd => tile.test_general(simd, &triangle, id, questioned, block, square));
            }
        }
    }
}
