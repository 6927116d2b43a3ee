mod masked;

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

use super::bins::{Bins, Fragment};
use super::depth_order::DepthOrder;
use super::homogeneous::{HomogeneousTriangle, Square};
use super::lanes::{DepthPlane, LANES, Setup, splat};
use super::pixel_space::HALF_ULP;
use super::samples::{BLOCKS, SAMPLES, Samples, Undecided};
use super::small_patches::PendingTriangles;
use crate::shot::{SeenPixels, Shifts};
use crate::simd::each;
use crate::simd::lanes::{bits_of, max3, min3};
use crate::vectorized;
pub(crate) use masked::MaskWeights;

/// Half a side: tile-local coordinates have their origin at the tile's middle.
pub(crate) const HALF: i32 = Bins::TILE as i32 / 2;

/// The nearest hits so far in one tile, and the memory for finding them. 115 KB.
#[repr(C, align(64))]
pub struct TileHits {
    pub samples: Samples,
    /// Largest distance along an axis between a sample and integer coordinates.
    shift: f32,
    /// The minimum of `low` in each block.
    pub farthest: [f32; BLOCKS * BLOCKS],
    /// A bit for each block, row by row, with nearer hits since its `farthest` was computed.
    pub(crate) changed: [u16; BLOCKS],
    /// Blocks that the triangles of a batch may cover in part: 256 × the lane, plus the block.
    pub queue: [u32; LANES * BLOCKS * BLOCKS],
    /// Blocks that the triangles cover wholly.
    pub(crate) covered: [u32; LANES * BLOCKS * BLOCKS],
    /// The possible hits of the queue's triangles.
    hits: [PossibleHits; LANES * BLOCKS * BLOCKS],
    /// Triangles of patches: tiny ones, then others.
    pub(super) waiting: [PendingTriangles; 2],
    /// The order in which triangles are tested.
    pub(crate) order: DepthOrder,
}

/// Samples of a block that a triangle may be the nearest at. 8 bytes.
#[derive(Clone, Copy, Debug, Default)]
struct PossibleHits {
    /// The triangle and the block, as in [`TileHits::queue`].
    queued: u32,
    /// A bit for each sample.
    possible: u16,
    /// Those that the triangle certainly covers.
    inside: u16,
}

/// The entry of a queue for a lane and a block.
#[inline(always)]
pub fn queued(lane: usize, block: usize) -> u32 {
    (lane * BLOCKS * BLOCKS + block) as u32
}

/// The lane and the block of an entry of a queue.
#[inline(always)]
fn lane_and_block(queued: u32) -> (usize, usize) {
    let queued = queued as usize;
    (queued / (BLOCKS * BLOCKS) % LANES, queued % (BLOCKS * BLOCKS))
}

impl Default for TileHits {
    fn default() -> Self {
        Self {
            samples: Samples::default(),
            shift: 0.0,
            farthest: [0.0; BLOCKS * BLOCKS],
            changed: [0; BLOCKS],
            queue: [0; LANES * BLOCKS * BLOCKS],
            covered: [0; LANES * BLOCKS * BLOCKS],
            hits: [PossibleHits::default(); LANES * BLOCKS * BLOCKS],
            waiting: [PendingTriangles::NONE; 2],
            order: DepthOrder::default(),
        }
    }
}

/// A batch of triangles in tile-local coordinates, one number a lane.
#[derive(Default)]
#[repr(C, align(64))]
pub struct TriangleBatch {
    pub(crate) a: [[f32; LANES]; 3],
    pub(crate) b: [[f32; LANES]; 3],
    pub(crate) c: [[f32; LANES]; 3],
    pub(crate) bound: [f32; LANES],
    /// One over the depth in the middle of the tile.
    pub(crate) inverse_depth: [f32; LANES],
    /// Its change per pixel to the right and downwards.
    pub(crate) gradient: [[f32; LANES]; 2],
    pub(crate) depth_error: [f32; LANES],
    /// Upper bound of the inverse depth.
    pub nearest: [f32; LANES],
    pub(crate) ids: [u32; LANES],
    /// First and last column, and first and last row, of the blocks that hold a triangle's bounds.
    pub blocks: [[i32; LANES]; 4],
}

impl TriangleBatch {
    /// Stores 16 triangles, without their ids and blocks. Where the orientation isn't `certain`, the only bound on the
    /// inverse depth is that of the nearest corner.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(&mut self, simd: S, setup: &Setup<S>, plane: &DepthPlane<S>, certain: mask32x16<S>) {
        let zero = splat(simd, 0.0);
        let nearest = setup.nearest * splat(simd, 1.0 + 4.0 * HALF_ULP);
        for edge in 0..3 {
            setup.a[edge].store_slice(&mut self.a[edge]);
            setup.b[edge].store_slice(&mut self.b[edge]);
            setup.c[edge].store_slice(&mut self.c[edge]);
        }
        setup.bound.store_slice(&mut self.bound);
        nearest.store_slice(&mut self.nearest);
        certain.select(plane.middle, zero).store_slice(&mut self.inverse_depth);
        certain.select(plane.gradient[0], zero).store_slice(&mut self.gradient[0]);
        certain.select(plane.gradient[1], zero).store_slice(&mut self.gradient[1]);
        certain.select(plane.error, nearest).store_slice(&mut self.depth_error);
    }

    /// The edge functions of the triangle in `lane` at 16 points.
    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, lane: usize, x: f32x16<S>, y: f32x16<S>) -> [f32x16<S>; 3] {
        let at = |factors: &[f32; LANES]| splat(simd, factors[lane]);
        each!(edge in [0, 1, 2] => at(&self.a[edge]) * x + (at(&self.b[edge]) * y + at(&self.c[edge])))
    }
}

/// Tile-local coordinates of each block's first column.
const FIRST_COLUMNS: [f32; BLOCKS] =
    [-32., -28., -24., -20., -16., -12., -8., -4., 0., 4., 8., 12., 16., 20., 24., 28.];
impl TileHits {
    /// Tile-local coordinates of a block's samples, exactly.
    #[inline(always)]
    fn coordinates<S: Simd>(&self, simd: S, block: usize) -> [f32x16<S>; 2] {
        let (column, row) = ((block % BLOCKS) as i32, (block / BLOCKS) as i32);
        [
            f32x16::from_slice(simd, &self.samples.of_block.columns) + splat(simd, (4 * column - HALF) as f32),
            f32x16::from_slice(simd, &self.samples.of_block.rows) + splat(simd, (4 * row - HALF) as f32),
        ]
    }

    /// Sets the positions of an image's samples.
    pub(crate) fn place_samples(&mut self, shifts: &Shifts) {
        (self.samples.of_block, self.shift) = (shifts.block(), shifts.reach());
    }

    pub fn clear(&mut self) {
        self.samples.clear();
        self.farthest.fill(0.0);
        self.changed.fill(0);
    }

    /// A lower bound of the inverse depth of all hits in the tile: anything farther is hidden. Zero where a sample has no
    /// hit.
    #[inline(always)]
    pub(crate) fn farthest<S: Simd>(&self, simd: S) -> f32 {
        let mut least = splat(simd, f32::INFINITY);
        for row in self.farthest.as_chunks::<LANES>().0 {
            least = least.min(f32x16::simd_from(simd, *row));
        }
        least.reduce_min()
    }

    /// Updates each block's farthest inverse depth, after samples were settled.
    #[inline(always)]
    pub fn note_farthest<S: Simd>(&mut self, simd: S) {
        for block in 0..BLOCKS * BLOCKS {
            self.note_farthest_in(simd, block);
        }
    }

    /// As [`note_farthest`](Self::note_farthest), for one block.
    #[inline(always)]
    pub(crate) fn note_farthest_in<S: Simd>(&mut self, simd: S, block: usize) {
        let low = &self.samples.low[block * LANES..(block + 1) * LANES];
        self.farthest[block] = f32x16::from_slice(simd, low).reduce_min();
    }

    /// Tests the triangles of a batch in `lanes`, all with an orientation that is `CERTAIN` or not. Returns the numbers of
    /// blocks tested in part and wholly, which both queues still hold.
    ///
    /// A separate function for each level, since inlining it at each call takes minutes to compile.
    #[inline(never)]
    pub(crate) fn test_batch<S: Simd, const CERTAIN: bool>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        lanes: u64,
    ) -> [usize; 2] {
        vectorized!(simd => self.test_batch_inlined::<S, CERTAIN>(simd, batch, lanes))
    }

    #[inline(always)]
    fn test_batch_inlined<S: Simd, const CERTAIN: bool>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        lanes: u64,
    ) -> [usize; 2] {
        let (mut waiting, mut covered) = (0, 0);
        for lane in bits_of(lanes) {
            let lane = lane % LANES;
            let (x0, x1) = (batch.blocks[0][lane] as usize % BLOCKS, batch.blocks[1][lane] as usize % BLOCKS);
            let (y0, y1) = (batch.blocks[2][lane] as usize % BLOCKS, batch.blocks[3][lane] as usize % BLOCKS);
            // Up to this many blocks are tested without a first rejection by edges. From 1 to 16, times differ by no more
            // than their noise of 3 % (cloth, hall, forest and `sibenik.obj` at 1024², Zen 4).
            const FEW: usize = 4;
            if !CERTAIN || (x1 - x0 + 1) * (y1 - y0 + 1) <= FEW {
                let nearest = batch.nearest[lane];
                for y in y0..=y1 {
                    for x in x0..=x1 {
                        let block = y * BLOCKS + x;
                        self.queue[waiting] = queued(lane, block);
                        waiting += usize::from(nearest >= self.farthest[block]);
                    }
                }
            } else {
                (waiting, covered) = self.enqueue_blocks(simd, batch, lane, [x0, x1, y0, y1], (waiting, covered));
            }
        }
        let all = mask32x16::splat(simd, true);
        for entry in 0..covered {
            let (lane, block) = lane_and_block(self.covered[entry]);
            self.take_nearer(simd, batch, lane, block, [all, all]);
        }
        self.test_queue::<S, CERTAIN>(simd, batch, waiting, u64::MAX);
        [waiting, covered]
    }

    /// Tests the first blocks of the queue, in part. For triangles that aren't in `decided`, the predicate has to settle
    /// every hit.
    #[inline(always)]
    pub fn test_queue<S: Simd, const CERTAIN: bool>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        waiting: usize,
        decided: u64,
    ) {
        // First without a branch, since the blocks that a small triangle hits are unpredictable: with two passes cloth takes
        // 7 % less time than with one, at 1024² on Zen 4.
        let mut kept = 0;
        for entry in 0..waiting {
            let hits = self.possible_hits::<S, CERTAIN>(simd, batch, self.queue[entry]);
            self.hits[kept] = hits;
            kept += usize::from(hits.possible != 0);
        }
        for entry in 0..kept {
            let PossibleHits { queued, possible, inside } = self.hits[entry];
            let (lane, block) = lane_and_block(queued);
            let inside = if decided >> lane & 1 == 1 { inside } else { 0 };
            let masks = [u64::from(possible), u64::from(inside)];
            let masks = [mask32x16::from_bitmask(simd, masks[0]), mask32x16::from_bitmask(simd, masks[1])];
            self.take_nearer(simd, batch, lane, block, masks);
        }
    }

    /// Queues the blocks that a triangle isn't certain to miss, nor to be hidden in. Returns the ends of both queues.
    #[inline(always)]
    fn enqueue_blocks<S: Simd>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        lane: usize,
        [x0, x1, y0, y1]: [usize; 4],
        (mut waiting, mut covered): (usize, usize),
    ) -> (usize, usize) {
        const MIDDLE: f32 = 1.5;
        let columns = f32x16::simd_from(simd, FIRST_COLUMNS) + splat(simd, MIDDLE);
        // Distance from a block's middle to its farthest sample. Four bounds cover the roundings here and in the test
        // itself.
        let farthest_sample = MIDDLE + self.shift;
        let (a, b) = (&batch.a, &batch.b);
        let reach = each!(edge in [0, 1, 2] => {
            splat(simd, farthest_sample * (a[edge][lane].abs() + b[edge][lane].abs()) + 4.0 * batch.bound[lane])
        });
        // Likewise for the depth, whose error counts the roundings of one sum like this.
        let gradient = [batch.gradient[0][lane], batch.gradient[1][lane]];
        let rise = farthest_sample * (gradient[0].abs() + gradient[1].abs()) + 2.0 * batch.depth_error[lane];
        let along_row = columns * splat(simd, gradient[0]) + splat(simd, batch.inverse_depth[lane] + rise);
        let nearest = splat(simd, batch.nearest[lane]);
        let within_bounds = (2 << x1) - (1 << x0);
        for y in y0..=y1 {
            let row = (4 * y as i32 - HALF) as f32 + MIDDLE;
            let edges = batch.edges(simd, lane, columns, splat(simd, row));
            let highest = min3([edges[0] + reach[0], edges[1] + reach[1], edges[2] + reach[2]]);
            let lowest = min3([edges[0] - reach[0], edges[1] - reach[1], edges[2] - reach[2]]);
            let here = nearest.min(along_row + splat(simd, row * gradient[1]));
            let farthest = f32x16::from_slice(simd, &self.farthest[y * BLOCKS..(y + 1) * BLOCKS]);
            let zero = splat(simd, 0.0);
            let reached = (highest.simd_ge(zero) & here.simd_ge(farthest)).to_bitmask() & within_bounds;
            let whole = lowest.simd_gt(zero).to_bitmask();
            let first = queued(lane, y * BLOCKS);
            for x in bits_of(reached & whole) {
                self.covered[covered] = first + x as u32;
                covered += 1;
            }
            for x in bits_of(reached & !whole) {
                self.queue[waiting] = first + x as u32;
                waiting += 1;
            }
        }
        (waiting, covered)
    }

    /// The samples of a queued block at which a triangle may be the nearest so far, and those that it certainly covers.
    #[inline(always)]
    fn possible_hits<S: Simd, const CERTAIN: bool>(&self, simd: S, batch: &TriangleBatch, queued: u32) -> PossibleHits {
        let (lane, block) = lane_and_block(queued);
        let [x, y] = self.coordinates(simd, block);
        let edges = batch.edges(simd, lane, x, y);
        let (lowest, bound) = (min3(edges), splat(simd, batch.bound[lane]));
        let mut missed = lowest.simd_lt(-bound);
        if !CERTAIN {
            // Here a miss takes two edge functions with opposite certain signs.
            missed &= max3(edges).simd_gt(bound);
        }
        let at = |values: &[f32; LANES]| splat(simd, values[lane]);
        let depth = at(&batch.inverse_depth) + (x * at(&batch.gradient[0]) + y * at(&batch.gradient[1]));
        let high = depth + at(&batch.depth_error);
        let old_low = f32x16::from_slice(simd, &self.samples.low[block * LANES..(block + 1) * LANES]);
        let possible = !missed & high.simd_ge(old_low);
        let inside = lowest.simd_gt(bound);
        PossibleHits { queued, possible: possible.to_bitmask() as u16, inside: inside.to_bitmask() as u16 }
    }

    /// Stores a triangle where it is nearer than the hits so far, given its possible and its certain hits.
    #[inline(always)]
    fn take_nearer<S: Simd>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        lane: usize,
        block: usize,
        [possible, inside]: [mask32x16<S>; 2],
    ) {
        let [x, y] = self.coordinates(simd, block);
        let at = |values: &[f32; LANES]| splat(simd, values[lane]);
        let depth = at(&batch.inverse_depth) + (x * at(&batch.gradient[0]) + y * at(&batch.gradient[1]));
        let error = at(&batch.depth_error);
        let (low, high) = (depth - error, depth + error);
        let samples = block * LANES..(block + 1) * LANES;
        let old_low = f32x16::from_slice(simd, &self.samples.low[samples.clone()]);
        let old_high = f32x16::from_slice(simd, &self.samples.high[samples.clone()]);
        let possible = possible & high.simd_ge(old_low);
        if !possible.any_true() {
            return;
        }
        let certain = possible & inside & low.simd_gt(old_high);
        let undecided = possible & !certain;
        if undecided.any_true() {
            let high: [f32; LANES] = high.into();
            self.samples.note_undecided(block, batch.ids[lane], undecided.to_bitmask(), &high);
        }
        let new_low = certain.select(low, old_low);
        new_low.store_slice(&mut self.samples.low[samples.clone()]);
        certain.select(high, old_high).store_slice(&mut self.samples.high[samples.clone()]);
        let old_triangle = u32x16::from_slice(simd, &self.samples.triangle[samples.clone()]);
        let triangle = u32x16::splat(simd, batch.ids[lane]);
        certain.select(triangle, old_triangle).store_slice(&mut self.samples.triangle[samples]);
        self.farthest[block] = new_low.reduce_min();
    }

    /// Tests a general triangle against the samples of one block, as [`Samples::test_general`] does.
    #[inline(always)]
    pub fn test_general<S: Simd>(
        &mut self,
        simd: S,
        triangle: &HomogeneousTriangle,
        id: u32,
        masked: bool,
        block: usize,
        square: Square,
    ) {
        self.samples.test_general(simd, triangle, id, masked, block, square);
        let low = f32x16::from_slice(simd, &self.samples.low[block * LANES..(block + 1) * LANES]);
        self.farthest[block] = low.reduce_min();
    }

    /// Writes the middles between the bounds of a block to `inverse_depth`, NaN for no hit. Returns those whose error may
    /// exceed [`SeenPixels::RELATIVE_ERROR`].
    #[inline(always)]
    pub(crate) fn write_middles<S: Simd>(&self, simd: S, block: usize, inverse_depth: &mut [f32]) -> u64 {
        let samples = block * LANES..(block + 1) * LANES;
        let low = f32x16::from_slice(simd, &self.samples.low[samples.clone()]);
        let high = f32x16::from_slice(simd, &self.samples.high[samples]);
        let sum = low + high;
        // The error of the middle is half the difference plus half an ulp. Relative to the middle, that is the difference
        // over the sum, with two roundings of each, plus 1.01 half ulps. Outside of the range where that holds, nothing is
        // certain.
        const MOST: f32 = SeenPixels::RELATIVE_ERROR - 1.1 * HALF_ULP;
        let sure = (high - low).simd_lt(sum * splat(simd, MOST));
        let in_range = sum.simd_gt(splat(simd, 1e-30)) & sum.simd_lt(splat(simd, 1e30));
        let is_hit = sum.simd_gt(splat(simd, 0.0));
        is_hit.select(sum * splat(simd, 0.5), splat(simd, f32::NAN)).store_slice(inverse_depth);
        (is_hit & !(sure & in_range)).to_bitmask()
    }

    /// Merges a sample of a tiny triangle.
    #[inline(always)]
    pub(crate) fn merge(&mut self, fragment: &Fragment) {
        let &Fragment { triangle, low, high, .. } = fragment;
        let (index, samples) = (fragment.index as usize % SAMPLES, &mut self.samples);
        if high < samples.low[index] {
            return;
        }
        if fragment.index & Fragment::UNDECIDED == 0 && low > samples.high[index] {
            (samples.low[index], samples.high[index], samples.triangle[index]) = (low, high, triangle);
        } else {
            samples.undecided.push(Undecided { index: index as u32, triangle, high });
        }
    }
}

/// The range of block columns (or rows) that hold the samples from `low` to `high`, in tile-local coordinates.
#[inline(always)]
pub(crate) fn block_range<S: Simd>(simd: S, low: f32x16<S>, high: f32x16<S>) -> [i32x16<S>; 2] {
    let (first, last) = (splat(simd, -HALF as f32), splat(simd, (HALF - 1) as f32));
    let low = (low.max(first).min(last) - first) * splat(simd, 0.25);
    let high = (high.max(first).min(last) - first) * splat(simd, 0.25);
    [low.to_int(), high.to_int()]
}
