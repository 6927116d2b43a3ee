//! Tiny triangles, of at most 2×2 samples, tested where they are set up.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::lanes::{Corners, PixelBounds, Setup, splat};
use super::pixel_space::{HALF_ULP, PixelSpace};
use crate::shot::Shifts;
use crate::simd::each;
use crate::simd::lanes::{max3, min3};

/// Sixteen triangles of at most two by two samples, in coordinates with an origin at their first sample.
pub(crate) struct TinyTriangles<S: Simd> {
    setup: Setup<S>,
    certain: mask32x16<S>,
    first_depth: f32x16<S>,
    shifts: Shifts,
    /// Whether the column, and the row, of its first pixel is odd.
    odd: [mask32x16<S>; 2],
}

/// The hits of sixteen tiny triangles at one of their samples.
pub(crate) struct TinyHits<S: Simd> {
    /// Triangles that may be hit.
    pub(crate) possible: mask32x16<S>,
    /// Triangles that are certainly hit.
    pub(crate) inside: mask32x16<S>,
    /// Lower bounds of the inverse depth.
    pub(crate) low: f32x16<S>,
    /// Upper bounds.
    pub(crate) high: f32x16<S>,
}

impl<S: Simd> TinyTriangles<S> {
    /// The samples of a tiny triangle: columns and rows from its first.
    pub(crate) const SAMPLES: [(i32, i32); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

    /// Returns a mask of the tiny ones of sixteen triangles.
    #[inline(always)]
    pub(crate) fn are(simd: S, bounds: &PixelBounds<S>) -> mask32x16<S> {
        let one = splat(simd, 1.0);
        (bounds.x[1] - bounds.x[0]).simd_le(one) & (bounds.y[1] - bounds.y[0]).simd_le(one)
    }

    #[inline(always)]
    pub(crate) fn new(simd: S, space: &PixelSpace, corners: &Corners<S>, bounds: &PixelBounds<S>) -> Self {
        // Coordinates are below four, so their own rounding is below 4 half ulps.
        let error = bounds.error + splat(simd, 4.0 * HALF_ULP);
        // Pixels are as far outside of the bounds as their samples may be from them, and samples as far again.
        let shift = space.shifts.reach();
        let overhang = 0.01 + 2.0 * shift;
        let x = each!(x in corners.x => x - bounds.x[0]);
        let y = each!(y in corners.y => y - bounds.y[0]);
        let setup = Setup::new(simd, x, y, corners.inverse_depth, error, 1.0 + shift, overhang);
        let certain = setup.is_certain(simd);
        let odd = [is_odd(simd, bounds.x[0], space.middle.x), is_odd(simd, bounds.y[0], space.middle.y)];
        Self { setup, certain, first_depth: corners.inverse_depth[0], shifts: space.shifts, odd }
    }

    /// Tests the triangles with a `valid` sample in this column and row.
    #[inline(always)]
    pub(crate) fn hits(&self, simd: S, (column, row): (i32, i32), valid: mask32x16<S>) -> TinyHits<S> {
        let Self { ref setup, certain, first_depth, ref shifts, odd } = *self;
        let (right, down) = (splat(simd, column as f32), splat(simd, row as f32));
        let edges = if shifts.reach() == 0.0 {
            setup.edges(right, down)
        } else {
            let odd_columns = if column == 1 { !odd[0] } else { odd[0] };
            let odd_rows = if row == 1 { !odd[1] } else { odd[1] };
            let [x, y] = shifts.of_sixteen(simd, odd_columns, odd_rows);
            setup.edges(right + x, down + y)
        };
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

/// Whether integers in pixel space, in which the image starts at `-middle`, are odd columns or rows.
#[inline(always)]
fn is_odd<S: Simd>(simd: S, at: f32x16<S>, middle: i32) -> mask32x16<S> {
    let one = i32x16::splat(simd, 1);
    let number: i32x16<S> = (at + splat(simd, middle as f32)).to_int();
    (number & one).simd_eq(one)
}
