use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

use super::pixel_space::{HALF_ULP, Vertex};
use crate::grid::extremes::{max3, min3};

/// Triangles, or samples of a block, handled at once.
pub(super) const LANES: usize = 16;

/// The corners of 16 triangles: x, y and inverse depth of each.
pub(super) struct Corners<S: Simd> {
    pub(super) x: [f32x16<S>; 3],
    pub(super) y: [f32x16<S>; 3],
    pub(super) inverse_depth: [f32x16<S>; 3],
}

impl<S: Simd> Corners<S> {
    /// The corners of 16 triangles, given as places in `vertices`, the last of which stands for all that are out of
    /// range.
    #[inline(always)]
    pub(super) fn load(simd: S, vertices: &[Vertex], triangles: &[[u32; 3]; LANES]) -> Self {
        let (ax, ay, az) = load_corner(simd, vertices, triangles, 0);
        let (bx, by, bz) = load_corner(simd, vertices, triangles, 1);
        let (cx, cy, cz) = load_corner(simd, vertices, triangles, 2);
        Self { x: [ax, bx, cx], y: [ay, by, cy], inverse_depth: [az, bz, cz] }
    }
}

/// x, y and inverse depth of one corner of 16 triangles.
#[inline(always)]
fn load_corner<S: Simd>(
    simd: S,
    vertices: &[Vertex],
    triangles: &[[u32; 3]; LANES],
    corner: usize,
) -> (f32x16<S>, f32x16<S>, f32x16<S>) {
    let first = load_quarter(simd, vertices, triangles, corner, 0);
    let second = load_quarter(simd, vertices, triangles, corner, 4);
    let third = load_quarter(simd, vertices, triangles, corner, 8);
    let fourth = load_quarter(simd, vertices, triangles, corner, 12);
    // Two rounds of unzipping take every fourth number.
    let (even_low, even_high) = (first.unzip_low(second), third.unzip_low(fourth));
    let (odd_low, odd_high) = (first.unzip_high(second), third.unzip_high(fourth));
    (even_low.unzip_low(even_high), odd_low.unzip_low(odd_high), even_low.unzip_high(even_high))
}

/// One corner of four triangles, vertex after vertex. Combining registers is what avoids a store and a load through
/// memory, which wait for each other.
#[inline(always)]
fn load_quarter<S: Simd>(
    simd: S,
    vertices: &[Vertex],
    triangles: &[[u32; 3]; LANES],
    corner: usize,
    lane: usize,
) -> f32x16<S> {
    let a = load_vertex(simd, vertices, triangles[lane][corner]);
    let b = load_vertex(simd, vertices, triangles[lane + 1][corner]);
    let c = load_vertex(simd, vertices, triangles[lane + 2][corner]);
    let d = load_vertex(simd, vertices, triangles[lane + 3][corner]);
    a.combine(b).combine(c.combine(d))
}

#[inline(always)]
fn load_vertex<S: Simd>(simd: S, vertices: &[Vertex], place: u32) -> f32x4<S> {
    f32x4::simd_from(simd, vertices[(place as usize).min(vertices.len() - 1)].0)
}

/// The results of `f` for each of three, inlined together with it as SIMD code has to be.
#[inline(always)]
pub(super) fn each<T, U>([a, b, c]: [T; 3], f: impl Fn(T) -> U) -> [U; 3] {
    [f(a), f(b), f(c)]
}

/// The largest magnitude of three corners' coordinates.
#[inline(always)]
pub(super) fn largest<S: Simd>(x: [f32x16<S>; 3], y: [f32x16<S>; 3]) -> f32x16<S> {
    max3(x).max(max3(y)).max(-(min3(x).min(min3(y))))
}

/// The lowest and highest of three corners' coordinates, widened by `error` and rounded to the samples between.
#[inline(always)]
pub(super) fn sample_range<S: Simd>(corners: [f32x16<S>; 3], error: f32x16<S>) -> [f32x16<S>; 2] {
    [(min3(corners) - error).ceil(), (max3(corners) + error).floor()]
}

/// The same number in all lanes.
#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Edge functions, depth and their error bounds of 16 triangles in coordinates with an origin near the samples.
pub(super) struct Setup<S: Simd> {
    /// Factor of x of each edge function; positive edge functions are inside.
    pub(super) a: [f32x16<S>; 3],
    /// Factor of y.
    pub(super) b: [f32x16<S>; 3],
    /// Constant.
    pub(super) c: [f32x16<S>; 3],
    /// How wrong an edge function may be.
    pub(super) bound: f32x16<S>,
    /// Twice the area, in pixels squared.
    pub(super) area: f32x16<S>,
    /// What the second and third edge function are multiplied with and added to the first corner's inverse depth.
    pub(super) slopes: [f32x16<S>; 2],
    /// How wrong the sum may be.
    pub(super) depth_error: f32x16<S>,
    /// The largest inverse depth of the corners.
    pub(super) nearest: f32x16<S>,
}

impl<S: Simd> Setup<S> {
    /// `x` and `y` are the corners in relation to the origin, δ `wrong` by at most `error`, and `samples` says how far
    /// from it, at most, the samples are along each axis, and `overhang` how far outside the triangle's bounds.
    ///
    /// With m the largest coordinate, w and h the sides of the bounds and ε half an ulp, an edge function is wrong
    /// - by 2 δ (w + h + 2 · overhang) + 2 δ² for the corners: E = (p − s) × (q − s), and each difference is no longer
    ///   than the bounds and the overhang;
    /// - by 4 ε (samples · (w + h) + 2 m²) for its own rounding in the form a·x + (b·y + c): four roundings in each of
    ///   a·x, b·y and the products of c.
    ///
    /// The area is wrong by at most 4 δ (w + h) + 8 δ² + 8 ε w h, which is less than four times that, since w and h are
    /// at most 2 m.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        x: [f32x16<S>; 3],
        y: [f32x16<S>; 3],
        inverse_depth: [f32x16<S>; 3],
        error: f32x16<S>,
        samples: f32,
        overhang: f32,
    ) -> Self {
        let size = max3(x) - min3(x) + (max3(y) - min3(y));
        let largest = largest(x, y);
        let corners = error * (size + splat(simd, 2.0 * overhang) + error) * splat(simd, 2.0);
        let rounding = size * splat(simd, samples) + largest * largest * splat(simd, 2.0);
        // The last factor covers the bound's own rounding.
        let bound = (corners + rounding * splat(simd, 4.0 * HALF_ULP)) * splat(simd, 1.001);

        let (ab_x, ab_y, ac_x, ac_y) = (x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]);
        let area = ab_x * ac_y - ac_x * ab_y;
        let sign = splat(simd, 1.0).copysign(area);
        let area = area * sign;
        let edges = [(1, 2), (2, 0), (0, 1)];
        let a = each(
            edges,
            #[inline(always)]
            |(p, q)| (y[p] - y[q]) * sign,
        );
        let b = each(
            edges,
            #[inline(always)]
            |(p, q)| (x[q] - x[p]) * sign,
        );
        let c = each(
            edges,
            #[inline(always)]
            |(p, q)| (x[p] * y[q] - x[q] * y[p]) * sign,
        );

        // A barycentric coordinate is wrong by (1 + 4 |λ|) bound / (area − 4 bound). Where the area is at least 8 ×
        // the bound, and |λ| at most 1 + 1/8, that's less than 12 bound / area. Corners' inverse depths are wrong by
        // 1.01 ε; the difference, reciprocal and two products have 4 roundings relative to each difference, and the
        // two sums and the bounds themselves one each relative to the result.
        let inverse_area = splat(simd, 1.0) / area;
        let rises = [inverse_depth[1] - inverse_depth[0], inverse_depth[2] - inverse_depth[0]];
        let rise = rises[0].abs() + rises[1].abs();
        let nearest = max3(inverse_depth);
        let of_barycentric = bound * inverse_area * splat(simd, 12.5) + splat(simd, 8.0 * HALF_ULP);
        let depth_error = (nearest * splat(simd, 8.0 * HALF_ULP) + rise * of_barycentric) * splat(simd, 1.001);
        Self { a, b, c, bound, area, slopes: [rises[0] * inverse_area, rises[1] * inverse_area], depth_error, nearest }
    }

    /// Whether the area is certain enough for the edge functions' signs and for the depth.
    #[inline(always)]
    pub(super) fn is_certain(&self, simd: S) -> fearless_simd::mask32x16<S> {
        self.area.simd_ge(self.bound * splat(simd, 8.0))
    }

    /// The edge functions at a place.
    #[inline(always)]
    pub(super) fn edges(&self, x: f32x16<S>, y: f32x16<S>) -> [f32x16<S>; 3] {
        each(
            [0, 1, 2],
            #[inline(always)]
            |edge| self.a[edge] * x + (self.b[edge] * y + self.c[edge]),
        )
    }
}
