use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::{DVec3, Vec3};
use umbrage_rays::light_grid::face::{Block, Face, HALF_ULP, POINT_LIMIT, VERTEX_MARGIN};
use umbrage_rays::light_grid::large_triangles::{HomogeneousCorners, LargeTriangle};
use umbrage_rays::simd::lanes::min3;
use umbrage_rays::simd::vectors::splat;

use super::{BlockErrors, Cells};

/// A [`LargeTriangle`] rounded to f32, for the cells that it covers. 64 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoveringTriangle {
    /// Factors of X, Y and 1, whose magnitudes sum up to about one.
    edges: [[f32; 3]; 3],
    /// Error bounds of the edge functions, to which the point's error is added.
    edge_errors: [f32; 3],
    nearness: [f32; 3],
    /// Error bound of the difference from a point's nearness, to which the point's error in W and `steepness` times its
    /// error in X and Y are added.
    depth_error: f32,
    steepness: f32,
    /// The triangle's bounds in X and Y: lowest and highest.
    pub(super) bounds: [[f32; 2]; 2],
}

/// The forms of a triangle: none if it can't shadow a point of the face, two if the light may be in its plane, so that the
/// light's side is unknown.
pub(super) fn covering(face: &Face, corners: [Vec3; 3], id: u32) -> [Option<CoveringTriangle>; 2] {
    let points = HomogeneousCorners::new(face, corners.map(Vec3::as_dvec3));
    let Some(bounds) = bounds(&points, f64::from(VERTEX_MARGIN) + 1e-6) else { return [None; 2] };
    LargeTriangle::of(face, corners, id).map(|of| of.map(|of| CoveringTriangle::new(&of, face.is_parallel, bounds)))
}

/// The bounds of the part of a triangle that is on the face, grown by `margin`; `None` if there is none.
fn bounds(corners: &HomogeneousCorners, margin: f64) -> Option<[[f32; 2]; 2]> {
    let HomogeneousCorners { points, sizes, .. } = corners;
    let everything = Some([[-POINT_LIMIT as f32, POINT_LIMIT as f32]; 2]);
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    if largest > 1e100 {
        return everything;
    }
    // Slightly more than the face, so that rounding can't lose a point of it; the rest may reach behind the light.
    let limit = POINT_LIMIT + 1e-3;
    let slack = 1e-12 * largest;
    let mut polygon = [DVec3::ZERO; 8];
    polygon[..3].copy_from_slice(points);
    let mut count = 3;
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let height = |point: DVec3| limit * point.z - sign * point[axis] + slack;
        let mut clipped = [DVec3::ZERO; 8];
        let mut kept = 0;
        for corner in 0..count {
            let (from, to) = (polygon[corner], polygon[(corner + 1) % count]);
            let (start, end) = (height(from), height(to));
            if start >= 0.0 && kept < clipped.len() {
                clipped[kept] = from;
                kept += 1;
            }
            if (start < 0.0) != (end < 0.0) && kept < clipped.len() {
                clipped[kept] = from + (to - from) * (start / (start - end));
                kept += 1;
            }
        }
        (polygon, count) = (clipped, kept);
    }
    if count == 0 {
        return None;
    }
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in &polygon[..count] {
        // So near to the light that it may be in any direction, once rounded.
        if point.z < 1e-7 * largest {
            return everything;
        }
        for axis in 0..2 {
            let at = point[axis] / point.z;
            (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
        }
    }
    let grow = margin + 1e-6;
    Some([0, 1].map(|axis| [(low[axis] - grow).max(-limit) as f32, (high[axis] + grow).min(limit) as f32]))
}

/// Growth of rows and spans for the rounding of their computation: far less than a cell.
const GROW: f32 = 1e-5;

impl CoveringTriangle {
    fn new(of: &LargeTriangle, is_parallel: bool, bounds: [[f32; 2]; 2]) -> Self {
        // Roundings of the factors, and of the two sums and products: eight ε of the largest value.
        const ROUNDED: f64 = HALF_ULP * 8.5;
        let size: f64 = of.nearness.iter().map(|factor| factor.abs()).sum();
        let rounded = |factors: [f64; 3]| factors.map(|factor| factor as f32);
        Self {
            edges: of.edges.map(rounded),
            edge_errors: of.edge_errors.map(|error| (ROUNDED + error) as f32),
            nearness: rounded(of.nearness),
            // In parallel light the nearness of points is up to one.
            depth_error: (ROUNDED * size.max(f64::from(u8::from(is_parallel))) + of.depth_error) as f32,
            steepness: (1.001 * size) as f32,
            bounds,
        }
    }

    /// Lowest and highest X of the part of the triangle that may overlap a row of cells, and its largest nearness there.
    pub(super) fn span(&self, cells: &Cells, row: usize) -> Option<([f32; 2], f32)> {
        let [low_y, high_y] = cells.row_range(row);
        let (low_y, high_y) = ((low_y - GROW).max(self.bounds[1][0]), (high_y + GROW).min(self.bounds[1][1]));
        let most = |slope: f32| (slope * low_y).max(slope * high_y);
        let [mut low, mut high] = self.bounds[0];
        for ([a, b, c], error) in self.edges.into_iter().zip(self.edge_errors) {
            if error.is_infinite() {
                continue;
            }
            // For a hit, a · X is at least this, for some Y of the row.
            let least = -(c + most(b)) - error - 4.0 * f32::EPSILON;
            if a > f32::MIN_POSITIVE {
                low = low.max(least / a - GROW);
            } else if a < -f32::MIN_POSITIVE {
                high = high.min(least / a + GROW);
            } else if least > GROW {
                return None;
            }
        }
        if low > high || low_y > high_y {
            return None;
        }
        let [a, b, c] = self.nearness;
        let nearest = c + most(b) + (a * low).max(a * high) + self.depth_error;
        let nearest = nearest + nearest.abs() * 4.0 * f32::EPSILON + f32::MIN_POSITIVE;
        Some(([low, high], nearest))
    }

    /// As [`Batch::test`](super::Batch::test).
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, block: &Block, error: BlockErrors) -> (mask32x16<S>, mask32x16<S>) {
        let (x, y) = (f32x16::simd_from(simd, block.x), f32x16::simd_from(simd, block.y));
        let [first, second, third] = self.edges;
        let (e0, e1, e2) = (line(simd, first, x, y), line(simd, second, x, y), line(simd, third, x, y));
        let [error0, error1, error2] = self.edge_errors;
        let of_point = error.position * 1.001;
        let (error0, error1) = (splat(simd, error0 + of_point), splat(simd, error1 + of_point));
        let error2 = splat(simd, error2 + of_point);
        // With an infinite error the former is never negative, the latter always.
        let possible = min3([e0 + error0, e1 + error1, e2 + error2]).simd_ge(splat(simd, 0.0));
        let certain = min3([e0 - error0, e1 - error1, e2 - error2]).simd_gt(splat(simd, 0.0));
        let nearer = line(simd, self.nearness, x, y) - f32x16::simd_from(simd, block.nearness);
        let depth_error = self.depth_error + (error.nearness + error.position * self.steepness) * 1.001;
        let depth_error = splat(simd, depth_error);
        let possible = possible & !nearer.simd_lt(-depth_error);
        let certain = certain & nearer.simd_gt(depth_error);
        (certain, possible)
    }
}

#[inline(always)]
fn line<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    splat(simd, a).mul_add(x, splat(simd, b).mul_add(y, splat(simd, c)))
}
