use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use crate::camera_grid::build::lanes_of;
use crate::camera_grid::lanes::{LANES, Setup, each, splat};
use crate::camera_grid::pixel_space::HALF_ULP;
use crate::camera_grid::samples::{COLUMNS, ROWS, Samples};
use crate::shot::{SeenPixels, TileOrder};
use crate::simd::lanes::{max3, min3};

/// Triangles in coordinates with an origin near their samples, one number a lane.
#[derive(Default)]
#[repr(C, align(64))]
pub(super) struct Batch {
    a: [[f32; LANES]; 3],
    b: [[f32; LANES]; 3],
    c: [[f32; LANES]; 3],
    bound: [f32; LANES],
    inverse_depth: [f32; LANES],
    slopes: [[f32; LANES]; 2],
    depth_error: [f32; LANES],
    /// Upper bound of one over the depth.
    nearest: [f32; LANES],
    /// First and last column of samples that may be hit, then rows.
    bounds: [[f32; LANES]; 4],
    pub(super) ids: [u32; LANES],
    /// A bit for each lane whose orientation is certain.
    pub(super) certain: u64,
    /// A bit for each lane whose every hit the predicate has to settle.
    pub(super) questioned: u64,
}

/// A block of samples in its tile, and where its first sample is in a batch's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) index: usize,
    pub(super) x: f32,
    pub(super) y: f32,
}

impl Block {
    /// The indices of its samples in the tile.
    #[inline(always)]
    pub(super) fn samples(&self) -> Range<usize> {
        self.index * LANES..(self.index + 1) * LANES
    }
}

impl Batch {
    /// Takes over 16 triangles, but for their ids. Where the orientation isn't `certain`, all that is known of the depth
    /// is that the nearest corner's is the nearest.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<S>,
        inverse_depth: f32x16<S>,
        bounds: [[f32x16<S>; 2]; 2],
    ) {
        let zero = splat(simd, 0.0);
        let certain = setup.is_certain(simd);
        let nearest = setup.nearest * splat(simd, 1.0 + 4.0 * HALF_ULP);
        for edge in 0..3 {
            setup.a[edge].store_slice(&mut self.a[edge]);
            setup.b[edge].store_slice(&mut self.b[edge]);
            setup.c[edge].store_slice(&mut self.c[edge]);
        }
        setup.bound.store_slice(&mut self.bound);
        nearest.store_slice(&mut self.nearest);
        certain.select(inverse_depth, zero).store_slice(&mut self.inverse_depth);
        certain.select(setup.slopes[0], zero).store_slice(&mut self.slopes[0]);
        certain.select(setup.slopes[1], zero).store_slice(&mut self.slopes[1]);
        certain.select(setup.depth_error, nearest).store_slice(&mut self.depth_error);
        for (to, bound) in self.bounds.iter_mut().zip(bounds.as_flattened()) {
            bound.store_slice(to);
        }
        self.certain = certain.to_bitmask();
    }

    /// The lanes whose bounds reach into a block and that may be nearer than `farthest`.
    #[inline(always)]
    fn reaching<S: Simd>(&self, simd: S, block: &Block, farthest: f32) -> u64 {
        let at = |values: &[f32; LANES]| f32x16::from_slice(simd, values);
        let last = (TileOrder::BLOCK - 1) as f32;
        let [left, right, top, bottom] = &self.bounds;
        let across = at(left).simd_le(splat(simd, block.x + last)) & at(right).simd_ge(splat(simd, block.x));
        let down = at(top).simd_le(splat(simd, block.y + last)) & at(bottom).simd_ge(splat(simd, block.y));
        (across & down & at(&self.nearest).simd_ge(splat(simd, farthest))).to_bitmask()
    }

    /// The edge functions of the triangle in `lane` at 16 points.
    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, lane: usize, x: f32x16<S>, y: f32x16<S>) -> [f32x16<S>; 3] {
        let at = |factors: &[f32; LANES]| splat(simd, factors[lane]);
        each(
            [0, 1, 2],
            #[inline(always)]
            |edge: usize| at(&self.a[edge]) * x + (at(&self.b[edge]) * y + at(&self.c[edge])),
        )
    }
}

/// The 16 samples of a block.
struct Found<S: Simd> {
    low: f32x16<S>,
    high: f32x16<S>,
    triangle: u32x16<S>,
}

impl Samples {
    /// The lower bound of the inverse depth of the farthest sample of a block.
    #[inline(always)]
    pub(super) fn farthest<S: Simd>(&self, simd: S, block: usize) -> f32 {
        f32x16::from_slice(simd, &self.low[block * LANES..(block + 1) * LANES]).reduce_min()
    }

    /// Tests the triangles of a batch that are set in `lanes` on the samples of a block; returns how many it tested.
    ///
    /// With `skips`, only those whose bounds reach into the block and that may be nearer than what is found; else all,
    /// unless all samples have hits that are certainly no farther than inverse depth `end`.
    #[inline(always)]
    pub(super) fn test_block<S: Simd>(
        &mut self,
        simd: S,
        batch: &Batch,
        mut lanes: u64,
        block: &Block,
        skips: bool,
        end: f32,
    ) -> u32 {
        let farthest = self.farthest(simd, block.index);
        if skips {
            lanes &= batch.reaching(simd, block, farthest);
        } else if farthest >= end {
            lanes = 0;
        }
        if lanes == 0 {
            return 0;
        }
        let samples = block.samples();
        let mut found = Found {
            low: f32x16::from_slice(simd, &self.low[samples.clone()]),
            high: f32x16::from_slice(simd, &self.high[samples.clone()]),
            triangle: u32x16::from_slice(simd, &self.triangle[samples.clone()]),
        };
        let x = f32x16::simd_from(simd, COLUMNS) + splat(simd, block.x);
        let y = f32x16::simd_from(simd, ROWS) + splat(simd, block.y);
        for lane in lanes_of(lanes) {
            self.test_lane(simd, batch, lane as usize % LANES, [x, y], block.index, &mut found);
        }
        found.low.store_slice(&mut self.low[samples.clone()]);
        found.high.store_slice(&mut self.high[samples.clone()]);
        found.triangle.store_slice(&mut self.triangle[samples]);
        lanes.count_ones()
    }

    /// Tests one triangle on 16 samples.
    #[inline(always)]
    fn test_lane<S: Simd>(
        &mut self,
        simd: S,
        batch: &Batch,
        lane: usize,
        [x, y]: [f32x16<S>; 2],
        block: usize,
        found: &mut Found<S>,
    ) {
        let at = |values: &[f32; LANES]| splat(simd, values[lane]);
        let edges = batch.edges(simd, lane, x, y);
        let (lowest, bound) = (min3(edges), at(&batch.bound));
        let depth = at(&batch.inverse_depth) + (edges[1] * at(&batch.slopes[0]) + edges[2] * at(&batch.slopes[1]));
        let error = at(&batch.depth_error);
        let (low, high) = (depth - error, depth + error);
        let mut missed = lowest.simd_lt(-bound);
        if batch.certain >> lane & 1 == 0 {
            // Then a miss takes two edge functions with opposite certain signs.
            missed &= max3(edges).simd_gt(bound);
        }
        let possible = high.simd_ge(found.low) & !missed;
        if !possible.any_true() {
            return;
        }
        let certain = if batch.questioned >> lane & 1 == 0 {
            possible & lowest.simd_gt(bound) & low.simd_gt(found.high)
        } else {
            mask32x16::splat(simd, false)
        };
        let undecided = possible & !certain;
        if undecided.any_true() {
            let high: [f32; LANES] = high.into();
            self.note_undecided(block, batch.ids[lane], undecided.to_bitmask(), &high);
        }
        found.low = certain.select(low, found.low);
        found.high = certain.select(high, found.high);
        found.triangle = certain.select(u32x16::splat(simd, batch.ids[lane]), found.triangle);
    }

    /// Writes inverse depths that are certain to [`SeenPixels::RELATIVE_ERROR`], and NaN for others and for no hit.
    #[inline(always)]
    pub(super) fn write_depths<S: Simd>(&self, simd: S, inverse_depth: &mut [f32]) {
        let blocks = self.low.as_chunks::<LANES>().0.iter().zip(self.high.as_chunks::<LANES>().0);
        for ((low, high), inverse_depth) in blocks.zip(inverse_depth.as_chunks_mut::<LANES>().0) {
            let (low, high) = (f32x16::from_slice(simd, low), f32x16::from_slice(simd, high));
            let sum = low + high;
            // Half ulps of the sum: one for its rounding, which its half takes over, and less than three for those of
            // the difference and the comparison. Outside of the range where that holds, nothing is sure.
            let allowed = sum * splat(simd, SeenPixels::RELATIVE_ERROR - 4.0 * HALF_ULP);
            let in_range = sum.simd_gt(splat(simd, 1e-30)) & sum.simd_lt(splat(simd, 1e30));
            let is_sure = (high - low).simd_le(allowed) & in_range;
            is_sure.select(sum * splat(simd, 0.5), splat(simd, f32::NAN)).store_slice(inverse_depth);
        }
    }
}
