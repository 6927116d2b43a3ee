use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::lanes::{Corners, PixelBounds, Setup, splat};
use super::pixel_space::HALF_ULP;
use crate::simd::each;
use crate::simd::lanes::{max3, min3};

/// Sixteen triangles of at most two by two samples, in coordinates with an origin at the first of these.
pub(crate) struct Tiny<S: Simd> {
    setup: Setup<S>,
    certain: mask32x16<S>,
    first_depth: f32x16<S>,
}

/// Which of sixteen tiny triangles are hit at one of their samples.
pub(crate) struct TinyHits<S: Simd> {
    /// Those that may be hit.
    pub(crate) possible: mask32x16<S>,
    /// Those that certainly are.
    pub(crate) inside: mask32x16<S>,
    /// Lower bounds of one over the depth.
    pub(crate) low: f32x16<S>,
    /// Upper bounds.
    pub(crate) high: f32x16<S>,
}

impl<S: Simd> Tiny<S> {
    /// The samples of a tiny triangle: columns and rows from its first.
    pub(crate) const SAMPLES: [(i32, i32); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

    /// Which of sixteen triangles are tiny.
    #[inline(always)]
    pub(crate) fn are(simd: S, bounds: &PixelBounds<S>) -> mask32x16<S> {
        let one = splat(simd, 1.0);
        (bounds.x[1] - bounds.x[0]).simd_le(one) & (bounds.y[1] - bounds.y[0]).simd_le(one)
    }

    #[inline(always)]
    pub(crate) fn new(simd: S, corners: &Corners<S>, bounds: &PixelBounds<S>) -> Self {
        // Coordinates are below four, so their own rounding is below 4 half ulps.
        let error = bounds.error + splat(simd, 4.0 * HALF_ULP);
        const OVERHANG_PIXELS: f32 = 0.01;
        let x = each!(x in corners.x => x - bounds.x[0]);
        let y = each!(y in corners.y => y - bounds.y[0]);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, error, 1.0, OVERHANG_PIXELS);
        let certain = setup.is_certain(simd);
        Self { setup, certain, first_depth: corners.inverse_depth[0] }
    }

    /// Tests those triangles that have a `valid` sample in this column and row.
    #[inline(always)]
    pub(crate) fn hits(&self, simd: S, (column, row): (i32, i32), valid: mask32x16<S>) -> TinyHits<S> {
        let Self { ref setup, certain, first_depth } = *self;
        let edges = setup.edges(splat(simd, column as f32), splat(simd, row as f32));
        let (lowest, highest) = (min3(edges), max3(edges));
        // Where the area's sign isn't certain, a miss takes two edge functions with opposite certain signs.
        let missed = lowest.simd_lt(-setup.bound) & (certain | highest.simd_gt(setup.bound));
        let depth = first_depth + (edges[1] * setup.slopes[0] + edges[2] * setup.slopes[1]);
        let nearest = setup.nearest * splat(simd, 1.0 + 4.0 * HALF_ULP);
        TinyHits {
            possible: valid & !missed,
            inside: lowest.simd_gt(setup.bound) & certain,
            low: depth - setup.depth_error,
            high: certain.select(depth + setup.depth_error, nearest),
        }
    }
}
