use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::pixel_space::{HALF_ULP, Vertex};

/// Triangles, or samples of a block, handled at once.
pub(super) const LANES: usize = 16;

/// The corners of 16 triangles: x, y and inverse depth of each.
pub(super) struct Corners<S: Simd> {
    pub(super) x: [f32x16<S>; 3],
    pub(super) y: [f32x16<S>; 3],
    pub(super) inverse_depth: [f32x16<S>; 3],
}

impl<S: Simd> Corners<S> {
    /// The corners of up to 16 triangles; the rest of the lanes is awkward, and so are triangles with an index out of
    /// range.
    #[inline(always)]
    pub(super) fn load<'a>(
        simd: S,
        vertices: &[Vertex],
        triangles: impl ExactSizeIterator<Item = &'a [u32; 3]>,
    ) -> Self {
        const AWKWARD: [f32; 4] = [0.0, 0.0, -1.0, 0.0];
        let mut packed = [[AWKWARD; LANES]; 3];
        for (lane, triangle) in triangles.take(LANES).enumerate() {
            for (corner, &vertex) in triangle.iter().enumerate() {
                packed[corner][lane] = vertices.get(vertex as usize).copied().unwrap_or(Vertex::AWKWARD).to_array();
            }
        }
        let [a, b, c] = packed.map(|corner| transpose(simd, &corner));
        Self { x: [a[0], b[0], c[0]], y: [a[1], b[1], c[1]], inverse_depth: [a[2], b[2], c[2]] }
    }
}

/// The first three columns of 16 rows.
#[inline(always)]
fn transpose<S: Simd>(simd: S, rows: &[[f32; 4]; LANES]) -> [f32x16<S>; 3] {
    let quarter = |first: usize| f32x16::from_slice(simd, rows[first..first + 4].as_flattened());
    // Two rounds of unzipping take every fourth number.
    let (low, high) = ((quarter(0), quarter(4)), (quarter(8), quarter(12)));
    let even = [low.0.unzip_low(low.1), high.0.unzip_low(high.1)];
    let odd = [low.0.unzip_high(low.1), high.0.unzip_high(high.1)];
    [even[0].unzip_low(even[1]), odd[0].unzip_low(odd[1]), even[0].unzip_high(even[1])]
}

#[inline(always)]
pub(super) fn min3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.min(b).min(c)
}

#[inline(always)]
pub(super) fn max3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.max(b).max(c)
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
        let largest = max3(x).max(max3(y)).max(-(min3(x).min(min3(y))));
        let corners = error * (size + splat(simd, 2.0 * overhang) + error) * splat(simd, 2.0);
        let rounding = size * splat(simd, samples) + largest * largest * splat(simd, 2.0);
        // The last factor covers the bound's own rounding.
        let bound = (corners + rounding * splat(simd, 4.0 * HALF_ULP)) * splat(simd, 1.001);

        let edge = |p: usize, q: usize| (y[p] - y[q], x[q] - x[p], x[p] * y[q] - x[q] * y[p]);
        let (ab, ac) = ((x[1] - x[0], y[1] - y[0]), (x[2] - x[0], y[2] - y[0]));
        let area = ab.0 * ac.1 - ac.0 * ab.1;
        let sign = splat(simd, 1.0).copysign(area);
        let edges = [edge(1, 2), edge(2, 0), edge(0, 1)].map(|(a, b, c)| (a * sign, b * sign, c * sign));
        let area = area * sign;

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
        Self {
            a: edges.map(|edge| edge.0),
            b: edges.map(|edge| edge.1),
            c: edges.map(|edge| edge.2),
            bound,
            area,
            slopes: rises.map(|rise| rise * inverse_area),
            depth_error,
            nearest,
        }
    }

    /// Whether the area is certain enough for the edge functions' signs and for the depth.
    #[inline(always)]
    pub(super) fn is_certain(&self, simd: S) -> fearless_simd::mask32x16<S> {
        self.area.simd_ge(self.bound * splat(simd, 8.0))
    }
}
