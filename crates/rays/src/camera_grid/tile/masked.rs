//! Triangles with masks, whose certain hits count only where the mask is certain too.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::{BLOCKS, HALF, PossibleHits, TileHits, TriangleBatch, lane_and_block};
use crate::camera_grid::lanes::{Corners, LANES, Setup, largest, splat};
use crate::camera_grid::pixel_space::{HALF_ULP, PixelSpace};
use crate::shot::{MaskPoints, Opacity};
use crate::simd::each;
use crate::simd::lanes::{bits_of, max3, min3};
use crate::vectorized;

/// The factors from the edge functions of a batch to the predicate's barycentric coordinates.
#[repr(C, align(64))]
pub(crate) struct MaskWeights {
    /// The inverse depth of each corner.
    inverse_depth: [[f32; LANES]; 3],
    /// Error bound of a barycentric coordinate, times the sum D of [`new`](Self::new).
    error: [f32; LANES],
}

impl MaskWeights {
    /// `x` and `y` are the corners relative to the tile's middle, with errors of at most δ, the `error`. The bound holds
    /// where [`Setup::is_certain`], for samples in the tile at which the predicate finds a hit.
    ///
    /// The predicate's weight of a corner is Eᵢ zᵢ / D, where z is the inverse depth and D the sum of all Eⱼ zⱼ, for any
    /// common factor of all E. Let λ be a sample's true barycentric coordinates in the image, each from 0 to 1. The point
    /// with the same λ in the displaced triangle is no farther than δ from the sample along each axis. So the displaced
    /// triangle's edge function at the sample, without roundings, differs from its area times λᵢ by at most δ (|a| + |b|).
    /// To this come
    /// - 5 ε (samples + m) (w + h), as in [`Setup::new`], for the roundings of an edge function, with ε half an ulp;
    /// - 64 roundings in f64 of the predicate's weights relative to d r², where d is the largest coordinate of the ray's
    ///   direction and r the largest of the corners' from the eye. In square pixels that is s² d (r / z)² 2⁻⁴⁷ with s
    ///   pixels a unit and z the depth of the nearest corner. [`PixelSpace::edge_error`] is above s² d 2⁻³⁹, and r is at
    ///   most 1.01 (1 + 2 |x/z|) times the depth of the farthest.
    ///
    /// If the sum of all three, times the nearest corner's inverse depth, is H, the error of a weight is at most H / D,
    /// since the error of D enters times the weight, which is at most one. Some ε more are for the inverse depths, the
    /// products, sums and quotient, and the predicate's own rounding to f32.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        space: &PixelSpace,
        corners: &Corners<S>,
        setup: &Setup<S>,
        [x, y]: [[f32x16<S>; 3]; 2],
        error: f32x16<S>,
    ) -> Self {
        let of_corners = |edge: usize| setup.a[edge].abs() + setup.b[edge].abs();
        let slopes = of_corners(0) + of_corners(1) + of_corners(2);
        let size = (max3(x) - min3(x)) + (max3(y) - min3(y));
        let samples = HALF as f32 + space.shifts.reach();
        let rounding = size * (largest(x, y) + splat(simd, samples)) * splat(simd, 15.0 * HALF_ULP);
        let axis = space.axis_pixels.abs().max_element() as f32;
        let steepness = (largest(corners.x, corners.y) + splat(simd, axis)) * splat(simd, 2.0 / space.scale as f32);
        let reach = (steepness + splat(simd, 1.0)) * setup.nearest / min3(corners.inverse_depth);
        let of_predicate = reach * reach * splat(simd, (3.0 / 128.0 * space.edge_error) as f32);
        let sum = slopes * error + rounding + of_predicate;
        let mut weights = Self { inverse_depth: [[0.0; LANES]; 3], error: [0.0; LANES] };
        // The factor covers the bound's own roundings.
        (sum * setup.nearest * splat(simd, 1.01)).store_slice(&mut weights.error);
        for (to, inverse_depth) in weights.inverse_depth.iter_mut().zip(corners.inverse_depth) {
            inverse_depth.store_slice(to);
        }
        weights
    }

    /// Barycentric coordinates and their errors, for the triangle in `lane` with the edge functions `edges`.
    #[inline(always)]
    fn points<S: Simd>(&self, simd: S, lane: usize, edges: [f32x16<S>; 3], lanes: u16) -> MaskPoints {
        let weighted = each!(corner in [0, 1, 2] => edges[corner] * splat(simd, self.inverse_depth[corner][lane]));
        let inverse_sum = splat(simd, 1.0) / (weighted[0] + weighted[1] + weighted[2]);
        let error = inverse_sum * splat(simd, self.error[lane]) + splat(simd, 12.0 * HALF_ULP);
        MaskPoints {
            barycentric: [(weighted[1] * inverse_sum).into(), (weighted[2] * inverse_sum).into()],
            error: error.into(),
            lanes,
        }
    }
}

impl TileHits {
    /// Tests the triangles of a batch in `lanes`, all of them masked and with a certain orientation. Returns the same
    /// numbers as [`test_batch`](Self::test_batch).
    #[inline(never)]
    pub(crate) fn test_masked<S: Simd>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        weights: &MaskWeights,
        opacity: &dyn Opacity,
        lanes: u64,
    ) -> [usize; 2] {
        vectorized!(simd => self.test_masked_inlined(simd, batch, weights, opacity, lanes))
    }

    #[inline(always)]
    fn test_masked_inlined<S: Simd>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        weights: &MaskWeights,
        opacity: &dyn Opacity,
        lanes: u64,
    ) -> [usize; 2] {
        let (mut waiting, mut covered) = (0, 0);
        for lane in bits_of(lanes) {
            let lane = lane % LANES;
            let blocks = [0, 1, 2, 3].map(|bound: usize| batch.blocks[bound][lane] as usize % BLOCKS);
            (waiting, covered) = self.enqueue_blocks(simd, batch, lane, blocks, (waiting, covered));
        }
        for entry in 0..covered {
            self.test_masked_block(simd, batch, weights, opacity, self.covered[entry]);
        }
        for entry in 0..waiting {
            self.test_masked_block(simd, batch, weights, opacity, self.queue[entry]);
        }
        [waiting, covered]
    }

    /// Tests the 16 samples of one queued block.
    #[inline(always)]
    fn test_masked_block<S: Simd>(
        &mut self,
        simd: S,
        batch: &TriangleBatch,
        weights: &MaskWeights,
        opacity: &dyn Opacity,
        queued: u32,
    ) {
        let (lane, block) = lane_and_block(queued);
        let PossibleHits { possible, inside, .. } = self.possible_hits::<S, true>(simd, batch, queued);
        if possible == 0 {
            return;
        }
        let [x, y] = self.coordinates(simd, block);
        let points = weights.points(simd, lane, batch.edges(simd, lane, x, y), possible);
        let answers = opacity.which_stop(batch.ids[lane], &points);
        let masks = [u64::from(possible & !answers.cut), u64::from(inside & answers.opaque)];
        let masks = [mask32x16::from_bitmask(simd, masks[0]), mask32x16::from_bitmask(simd, masks[1])];
        self.take_nearer(simd, batch, lane, block, masks);
    }
}
