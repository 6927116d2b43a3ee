//! Sixteen triangles at once: their corners, bounds in pixels, edge functions and depths, and which show a side that stops
//! rays.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, u8x64, u32x16};

use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use crate::Triangles;
use crate::shot::{Shot, Sides};
use crate::simd::each;
pub(crate) use crate::simd::lanes::{LANES, splat};
use crate::simd::lanes::{TABLE, bits_of, load_corner, load_local_corner, look_up, max3, min3};

/// The corners of 16 triangles: x, y and inverse depth of each.
#[derive(Clone, Copy)]
pub struct Corners<S: Simd> {
    pub(crate) x: [f32x16<S>; 3],
    pub(crate) y: [f32x16<S>; 3],
    pub inverse_depth: [f32x16<S>; 3],
}

impl<S: Simd> Corners<S> {
    /// The corners of at most 16 triangles, given as indices of `vertices`. The last vertex stands for all indices out of
    /// range, and for missing triangles.
    #[inline(always)]
    pub fn load(simd: S, vertices: &[Vertex], triangles: &[[u32; 3]]) -> Self {
        let mut padded = [[u32::MAX; 3]; LANES];
        let triangles = triangles.try_into().unwrap_or_else(|_| {
            padded[..triangles.len()].copy_from_slice(triangles);
            &padded
        });
        let [ax, ay, az, _] = load_corner(simd, vertices, triangles, 0);
        let [bx, by, bz, _] = load_corner(simd, vertices, triangles, 1);
        let [cx, cy, cz, _] = load_corner(simd, vertices, triangles, 2);
        Self { x: [ax, bx, cx], y: [ay, by, cy], inverse_depth: [az, bz, cz] }
    }

    /// The corners of 16 triangles, given as numbers of a few vertices, from the vertices' x, y and inverse depth.
    #[inline(always)]
    pub(crate) fn of_few(simd: S, [x, y, inverse_depth]: &[[f32; TABLE]; 3], corners: &[[u8; 4]; LANES]) -> Self {
        let quads = u8x64::from_slice(simd, corners.as_flattened()).bitcast::<u32x16<S>>();
        let corners = [quads & 0xff, (quads >> 8) & 0xff, quads >> 16];
        Self {
            x: each!(corner in corners => look_up(simd, x, corner)),
            y: each!(corner in corners => look_up(simd, y, corner)),
            inverse_depth: each!(corner in corners => look_up(simd, inverse_depth, corner)),
        }
    }

    /// The corners of 16 triangles of a patch, given its vertices.
    #[inline(always)]
    pub(crate) fn of_patch(simd: S, vertices: &[Vertex], corners: &[[u8; 4]]) -> Self {
        let [ax, ay, az] = load_local_corner(simd, vertices, corners, 0);
        let [bx, by, bz] = load_local_corner(simd, vertices, corners, 1);
        let [cx, cy, cz] = load_local_corner(simd, vertices, corners, 2);
        Self { x: [ax, bx, cx], y: [ay, by, cy], inverse_depth: [az, bz, cz] }
    }

    /// Whether two corners are at the same point of the image.
    #[inline(always)]
    pub fn coincide(&self) -> mask32x16<S> {
        let Self { x, y, .. } = self;
        (x[0].simd_eq(x[1]) & y[0].simd_eq(y[1]))
            | (x[1].simd_eq(x[2]) & y[1].simd_eq(y[2]))
            | (x[2].simd_eq(x[0]) & y[2].simd_eq(y[0]))
    }

    /// Twice the signed area of each triangle in pixel space, and its error bound if corners have errors of at most `error`.
    ///
    /// With δ the error of a corner and w and h the sides of the bounds, the bound is 4 δ (w + h) + 8 δ² + 8 ε w h (see
    /// [`Setup::new`]).
    #[inline(always)]
    pub fn signed_area(&self, simd: S, error: f32x16<S>) -> [f32x16<S>; 2] {
        let Self { x, y, .. } = *self;
        let (width, height) = (max3(x) - min3(x), max3(y) - min3(y));
        let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        let of_corners = error * (width + height + error + error) * splat(simd, 4.0);
        [area, (of_corners + width * height * splat(simd, 8.0 * HALF_ULP)) * splat(simd, 1.001)]
    }
}

/// The largest magnitude of three corners' coordinates.
#[inline(always)]
pub(crate) fn largest<S: Simd>(x: [f32x16<S>; 3], y: [f32x16<S>; 3]) -> f32x16<S> {
    max3(x).max(max3(y)).max(-(min3(x).min(min3(y))))
}

/// The lowest and highest of three corners' coordinates, widened by `error` and rounded to the pixels between. `error`
/// includes the distance of samples from integers.
#[inline(always)]
pub(crate) fn sample_range<S: Simd>(corners: [f32x16<S>; 3], error: f32x16<S>) -> [f32x16<S>; 2] {
    [(min3(corners) - error).ceil(), (max3(corners) + error).floor()]
}

/// Pixels of the image whose samples 16 triangles may hit.
pub struct PixelBounds<S: Simd> {
    pub x: [f32x16<S>; 2],
    pub y: [f32x16<S>; 2],
    /// Error bound of a corner.
    pub error: f32x16<S>,
}

impl<S: Simd> PixelBounds<S> {
    #[inline(always)]
    pub fn new(simd: S, space: &PixelSpace, corners: &Corners<S>) -> Self {
        let largest = largest(corners.x, corners.y);
        // The second half ulp is for the sum of a coordinate and its error.
        let error = largest * splat(simd, 2.1 * HALF_ULP) + splat(simd, 1.1 * Vertex::ERROR_PIXELS);
        let (width, height) = space.size();
        let beside = error + splat(simd, space.shifts.reach());
        let x = clamp(simd, sample_range(corners.x, beside), space.middle.x, width);
        let y = clamp(simd, sample_range(corners.y, beside), space.middle.y, height);
        Self { x, y, error }
    }

    /// Returns a mask of the triangles with the sample that is `column` and `row` from their first.
    #[inline(always)]
    pub(crate) fn have(&self, simd: S, (column, row): (i32, i32)) -> mask32x16<S> {
        let [x, y] = self.sample(simd, (column, row));
        x.simd_le(self.x[1]) & y.simd_le(self.y[1])
    }

    /// The sample that is `column` and `row` from each triangle's first.
    #[inline(always)]
    pub(crate) fn sample(&self, simd: S, (column, row): (i32, i32)) -> [f32x16<S>; 2] {
        [self.x[0] + splat(simd, column as f32), self.y[0] + splat(simd, row as f32)]
    }
}

/// The part of a range of samples that is in an image of `side` pixels.
#[inline(always)]
fn clamp<S: Simd>(simd: S, [low, high]: [f32x16<S>; 2], middle: i32, side: u32) -> [f32x16<S>; 2] {
    let (first, last) = (-middle as f32, (side as i32 - 1 - middle) as f32);
    [low.max(splat(simd, first)), high.min(splat(simd, last))]
}

/// Edge functions, depth and their error bounds of 16 triangles in coordinates with an origin near the samples.
pub struct Setup<S: Simd> {
    /// Factor of x of each edge function; positive edge functions are inside.
    pub(crate) a: [f32x16<S>; 3],
    /// Factor of y.
    pub(crate) b: [f32x16<S>; 3],
    /// Constant.
    pub(crate) c: [f32x16<S>; 3],
    /// Error bound of an edge function.
    pub(crate) bound: f32x16<S>,
    /// Twice the area, in pixels squared.
    pub(crate) area: f32x16<S>,
    /// Factors of the second and third edge function, whose sum with the first corner's inverse depth is the inverse depth.
    pub(crate) slopes: [f32x16<S>; 2],
    /// Error bound of that sum.
    pub(crate) depth_error: f32x16<S>,
    /// The largest inverse depth of the corners.
    pub(crate) nearest: f32x16<S>,
}

impl<S: Simd> Setup<S> {
    /// `x` and `y` are the corners relative to the origin, with errors δ of at most `error`. `samples` bounds the distance
    /// of samples from the origin along each axis, and `overhang` their distance from the triangle's bounds.
    ///
    /// With m the largest coordinate, w and h the sides of the bounds and ε half an ulp, an edge function is wrong
    /// - by 2 δ (w + h + 2 · overhang) + 2 δ² for the corners: E = (p − s) × (q − s), and each difference is no longer
    ///   than the bounds and the overhang;
    /// - by 5 ε (samples + m) (w + h) for its own rounding in the form a·x + (b·y − (a·p + b·q)): at most five roundings on
    ///   each path, where |a| ≤ h and |b| ≤ w.
    ///
    /// The area is wrong by at most 4 δ (w + h) + 8 δ² for the corners and 6 ε w h for rounding, which is less than four
    /// times that, since w h ≤ m (w + h).
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        x: [f32x16<S>; 3],
        y: [f32x16<S>; 3],
        inverse_depth: [f32x16<S>; 3],
        error: f32x16<S>,
        samples: f32,
        overhang: f32,
    ) -> Self {
        let (width, height) = (max3(x) - min3(x), max3(y) - min3(y));
        let size = width + height;
        let corners = error * (size + splat(simd, 2.0 * overhang) + error) * splat(simd, 2.0);
        let rounding = size * (largest(x, y) + splat(simd, samples)) * splat(simd, 5.0 * HALF_ULP);
        // The last factor covers the bound's own rounding.
        let bound = (corners + rounding) * splat(simd, 1.001);

        let (ab_x, ab_y, ac_x, ac_y) = (x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]);
        let area = ab_x * ac_y - ac_x * ab_y;
        let sign = splat(simd, 1.0).copysign(area);
        let area = area * sign;
        let edges = [(1, 2), (2, 0), (0, 1)];
        let a = each!((p, q) in edges => (y[p] - y[q]) * sign);
        let b = each!((p, q) in edges => (x[q] - x[p]) * sign);
        let c = each!(edge in [0, 1, 2] => -(a[edge] * x[edges[edge].0] + b[edge] * y[edges[edge].0]));

        // Where the area is at least 8 × the bound, the depth at a sample inside the triangle is wrong
        // - by δ |∇z|₁ for the corners: in the plane through displaced corners, the sample's barycentric coordinates
        //   belong to a point displaced by no more than they are;
        // - by the edge functions' rounding and the area's over the area, times the rise of the depth;
        // - by five more roundings relative to the rise: the difference, reciprocal, two products and a sum;
        // - by one rounding of the result and 1.01 ε for the corners' own inverse depths.
        // Factors above one cover 1 / (1 − 1/8), for the area in the denominators, and barycentric coordinates up to
        // 1/8 outside of their range, for the displaced corners.
        let inverse_area = splat(simd, 1.0) / area;
        let rises = [inverse_depth[1] - inverse_depth[0], inverse_depth[2] - inverse_depth[0]];
        let rise = rises[0].abs() + rises[1].abs();
        let nearest = max3(inverse_depth);
        let of_rise = (rounding * splat(simd, 1.2) + width * height * splat(simd, 10.5 * HALF_ULP)) * inverse_area
            + splat(simd, 8.0 * HALF_ULP);
        let gradient =
            (rises[0].abs() * (a[1].abs() + b[1].abs()) + rises[1].abs() * (a[2].abs() + b[2].abs())) * inverse_area;
        let depth_error = nearest * splat(simd, 8.0 * HALF_ULP) + rise * of_rise + gradient * error * splat(simd, 1.2);
        let depth_error = depth_error * splat(simd, 1.001);
        Self { a, b, c, bound, area, slopes: [rises[0] * inverse_area, rises[1] * inverse_area], depth_error, nearest }
    }

    /// Whether the area is certain enough for the edge functions' signs and for the depth.
    #[inline(always)]
    pub(crate) fn is_certain(&self, simd: S) -> mask32x16<S> {
        self.area.simd_ge(self.bound * splat(simd, 8.0))
    }

    /// The edge functions at a point.
    #[inline(always)]
    pub(crate) fn edges(&self, x: f32x16<S>, y: f32x16<S>) -> [f32x16<S>; 3] {
        each!(edge in [0, 1, 2] => self.a[edge] * x + (self.b[edge] * y + self.c[edge]))
    }
}

/// One over the depth of 16 triangles as a linear function of x and y in a tile, whose middle is the origin.
pub(crate) struct DepthPlane<S: Simd> {
    /// Its change per pixel to the right and downwards.
    pub(crate) gradient: [f32x16<S>; 2],
    /// Its value in the middle of the tile.
    pub(crate) middle: f32x16<S>,
    /// Error bound at a sample inside both the tile and the triangle.
    pub(crate) error: f32x16<S>,
}

impl<S: Simd> DepthPlane<S> {
    /// The planes of triangles with corner errors of at most `error` in pixel space, for the tile with its middle at
    /// `origin` and its samples at most `samples` from there along each axis. They are valid where [`Setup::is_certain`].
    ///
    /// The plane is computed in f64: in f32 a corner far from the tile would take most of the digits. With ε half an ulp of
    /// an f32, δ the error of the corners and M the largest value in the tile, it is wrong
    /// - by δ |∇z|₁ for the corners: in the plane through displaced corners, the sample's barycentric coordinates
    ///   belong to a point displaced by no more than they are; 1.2 covers an area that is wrong by 1/8;
    /// - by 1.01 ε M for the corners' own inverse depths, whose weights at a sample inside are not below zero;
    /// - by 4 ε M for rounding the plane to f32 and three roundings when it is evaluated;
    /// - by 20 · 2⁻⁵³ w h / area < 2⁻³⁰ relative to the rise for roundings in f64, since certain areas are at least
    ///   40 ε w h;
    /// - by ε M when the error is subtracted or added. The seventh ε is for the bound's own rounding.
    #[inline(always)]
    pub(crate) fn new(simd: S, corners: &Corners<S>, error: f32x16<S>, origin: [f32; 2], samples: f32) -> Self {
        let halves = |values: [f32x16<S>; 3]| {
            let [a, b, c] = each!(values in values => simd.widen_f32x16(values));
            [[a.0, b.0, c.0], [a.1, b.1, c.1]]
        };
        let (x, y, inverse_depth) = (halves(corners.x), halves(corners.y), halves(corners.inverse_depth));
        let first = Self::half(simd, x[0], y[0], inverse_depth[0], origin);
        let second = Self::half(simd, x[1], y[1], inverse_depth[1], origin);
        let [right, down, middle] = each!(part in [0, 1, 2] => simd.narrow_f64x8(first[part], second[part]));
        let [a, b, c] = corners.inverse_depth;
        let rise = (b - a).abs() + (c - a).abs();
        let slope = right.abs() + down.abs();
        let largest = middle.abs() + slope * splat(simd, samples);
        let error = slope * error * splat(simd, 1.2)
            + largest * splat(simd, 7.0 * HALF_ULP)
            + rise * splat(simd, 1.0 / (1 << 30) as f32);
        Self { gradient: [right, down], middle, error: error * splat(simd, 1.001) }
    }

    /// Slopes to the right and downwards, and the value at `origin`, of eight planes.
    #[inline(always)]
    fn half(
        simd: S,
        x: [f64x8<S>; 3],
        y: [f64x8<S>; 3],
        inverse_depth: [f64x8<S>; 3],
        origin: [f32; 2],
    ) -> [f64x8<S>; 3] {
        let (ab_x, ab_y, ac_x, ac_y) = (x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]);
        let inverse_area = f64x8::splat(simd, 1.0) / (ab_x * ac_y - ac_x * ab_y);
        let rises = [inverse_depth[1] - inverse_depth[0], inverse_depth[2] - inverse_depth[0]];
        let right = (rises[0] * ac_y - rises[1] * ab_y) * inverse_area;
        let down = (rises[1] * ab_x - rises[0] * ac_x) * inverse_area;
        let [origin_x, origin_y] = origin.map(f64::from);
        let across = f64x8::splat(simd, origin_x) - x[0];
        let along = f64x8::splat(simd, origin_y) - y[0];
        [right, down, inverse_depth[0] + (right * across + down * along)]
    }
}

/// Finds the triangles that show a side that stops rays.
#[derive(Clone, Copy)]
pub(super) struct BackFaceCull<'a> {
    space: &'a PixelSpace,
    triangles: Triangles<'a>,
    sides: Sides<'a>,
    /// The sign of the area in pixel space of triangles that show their front; zero where all have both sides.
    facing: f32,
}

impl<'a> BackFaceCull<'a> {
    pub(super) fn new(space: &'a PixelSpace, shot: &Shot<'a>) -> Self {
        let &Shot { triangles, sides, .. } = shot;
        Self { space, triangles, sides, facing: space.facing(sides) }
    }

    /// The triangles in `lanes` that have a back or show their front. Where the area isn't certain, the predicate decides.
    #[inline(always)]
    pub(super) fn keep<S: Simd>(
        &self,
        simd: S,
        ids: &[u32],
        corners: &Corners<S>,
        bounds: &PixelBounds<S>,
        lanes: u64,
    ) -> u64 {
        if self.facing == 0.0 || lanes == 0 {
            return lanes;
        }
        let with_back = bits_of(lanes).filter(|lane| self.sides.has_back(ids[lane % LANES]));
        let mut shown = with_back.fold(0, |backs, lane| backs | 1 << lane);
        let [area, bound] = corners.signed_area(simd, bounds.error);
        let area = area * splat(simd, self.facing);
        let (fronts, backs) = (area.simd_gt(bound).to_bitmask(), area.simd_lt(-bound).to_bitmask());
        shown |= fronts;
        for lane in bits_of(lanes & !(shown | backs)) {
            shown |= u64::from(self.space.sees_front(self.triangles.corners(ids[lane % LANES]))) << lane;
        }
        lanes & shown
    }
}
