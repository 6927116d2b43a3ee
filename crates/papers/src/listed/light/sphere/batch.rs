use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use umbrage_rays::light_grid::face::HALF_ULP;
use umbrage_rays::simd::lanes::{max3, min3};
use umbrage_rays::simd::vectors::{LANES, splat};

use super::Frame;
use super::points::SpherePoints;
use super::vertices::Vertices;

/// ε, half the distance from one to the next f32.
const EPSILON: f32 = HALF_ULP as f32;

/// Coordinates and sides above this make a triangle undecided: products of three of them and of points stay finite.
const LARGEST: f32 = 1e12;

/// More than the loss of products that underflow.
const UNDERFLOW: f32 = 1e-36;

/// The corners of 16 triangles relative to the light: a, b and c, and the sides b − a, c − b and a − c.
///
/// Positions and the light are f32, so each coordinate of a corner or of a side is one difference, with an error of ε of
/// itself, times a power of two.
pub(crate) struct Corners<S: Simd> {
    corners: [[f32x16<S>; 3]; 3],
    sides: [[f32x16<S>; 3]; 3],
}

impl<S: Simd> Corners<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, frame: &Frame, vertices: &Vertices, triangles: &[[u32; 3]; LANES]) -> Self {
        let a = vertices.corner(simd, triangles, 0);
        let b = vertices.corner(simd, triangles, 1);
        let c = vertices.corner(simd, triangles, 2);
        let [x, y, z] = frame.light.to_array();
        let light = [splat(simd, x), splat(simd, y), splat(simd, z)];
        let scale = splat(simd, frame.scale as f32);
        Self {
            corners: [apart(a, light, scale), apart(b, light, scale), apart(c, light, scale)],
            sides: [apart(b, a, scale), apart(c, b, scale), apart(a, c, scale)],
        }
    }

    /// Lower bound of the largest coordinate of any point of each triangle: that of its bounds' nearest point.
    #[inline(always)]
    pub(super) fn nearest(&self, simd: S) -> f32x16<S> {
        let [a, b, c] = self.corners;
        let zero = splat(simd, 0.0);
        let mut nearest = zero;
        let mut sum = zero;
        for axis in 0..3 {
            let (low, high) = (min3([a[axis], b[axis], c[axis]]), max3([a[axis], b[axis], c[axis]]));
            nearest = nearest.max(low).max(-high);
            sum += (high - low).abs() + low.abs();
        }
        // With overflow or NaN, the triangle may be anywhere.
        let is_known = sum.simd_lt(splat(simd, 1e38));
        is_known.select(nearest * (1.0 - 4.0 * EPSILON) - UNDERFLOW, zero)
    }
}

/// The difference of positions, scaled.
#[inline(always)]
fn apart<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3], scale: f32x16<S>) -> [f32x16<S>; 3] {
    [(a[0] - b[0]) * scale, (a[1] - b[1]) * scale, (a[2] - b[2]) * scale]
}

#[inline(always)]
fn cross<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn largest<S: Simd>(a: [f32x16<S>; 3]) -> f32x16<S> {
    max3([a[0].abs(), a[1].abs(), a[2].abs()])
}

/// Triangles in the filter's form, by field. 92 bytes each.
///
/// Let a, b and c be a triangle's corners relative to the light. A point v is behind it, as seen from the light, if the edge
/// functions v · (b × c), v · (c × a) and v · (a × b) and v · n − a · n, n = (b − a) × (c − a), all have the sign of a · n:
/// that is v = λa + μb + νc with no negative factor, and a sum of factors above one. Cross products are computed from sides,
/// a × b = a × (b − a), so that no bits are lost to the corners' common offset.
///
/// Of the largest coordinates A of corners, L of sides and V of points, and with an error e of each coordinate of a point, a
/// component of a cross product of a corner and a side has four roundings of two products of A L: at most 8.2 ε A L. Its dot
/// product with a point is wrong by three of those times V, 18 ε A L V for products and sums, and 6 A L e for the point, so
/// altogether by less than A L (48 ε V + 6.1 e). n is wrong by as much of L², and a · n by 64 ε A L².
///
/// The predicate requires v · n − a · n above 6 L² (10 u (V + A) + e), u = 2⁻⁵³: doubling the bound covers that.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    /// Factors of the edge functions of a, b and c, and of the height above the plane, with signs such that all are positive
    /// behind the triangle.
    edges: [[[f32; LANES]; 3]; 3],
    normal: [[f32; LANES]; 3],
    /// The constant a · n, subtracted for the height above the plane.
    at_light: [f32; LANES],
    /// The products A L and L².
    edge_size: [f32; LANES],
    normal_size: [f32; LANES],
    /// Error bound of `at_light`; infinite where its sign isn't certain.
    height_error: [f32; LANES],
    /// Mask of triangles with valid factors.
    known: u64,
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            edges: [[zero; 3]; 3],
            normal: [zero; 3],
            at_light: zero,
            edge_size: zero,
            normal_size: zero,
            height_error: zero,
            known: 0,
        }
    }
}

impl Batch {
    /// Sets up 16 triangles.
    #[inline(always)]
    pub(super) fn set_up<S: Simd>(&mut self, simd: S, triangles: &Corners<S>) {
        let Corners { corners: [a, b, c], sides: [ab, bc, ca] } = *triangles;
        let reach = max3([largest(a), largest(b), largest(c)]);
        let length = max3([largest(ab), largest(bc), largest(ca)]);
        let normal = cross(ca, ab);
        let at_light = a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2];
        let (edge_size, normal_size) = (reach * length, length * length);
        let error = normal_size * reach * (64.0 * EPSILON) + UNDERFLOW;
        let is_certain = at_light.abs().simd_gt(error);
        let sign = splat(simd, 1.0).copysign(at_light);
        let edges = [cross(b, bc), cross(c, ca), cross(a, ab)];
        for (to, from) in self.edges.iter_mut().zip(edges).chain([(&mut self.normal, normal)]) {
            for (to, from) in to.iter_mut().zip(from) {
                (from * sign).store_slice(to);
            }
        }
        (at_light * sign).store_slice(&mut self.at_light);
        edge_size.store_slice(&mut self.edge_size);
        normal_size.store_slice(&mut self.normal_size);
        is_certain.select(error, splat(simd, f32::INFINITY)).store_slice(&mut self.height_error);
        let largest = splat(simd, LARGEST);
        // Written so that NaN is unknown.
        self.known = (reach.simd_lt(largest) & length.simd_lt(largest)).to_bitmask();
    }

    /// As [`LightMap::test`](super::LightMap::test).
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, lane: usize, points: &SpherePoints) -> (mask32x16<S>, mask32x16<S>) {
        let lane = lane % LANES;
        if self.known >> lane & 1 == 0 {
            return (mask32x16::splat(simd, false), mask32x16::splat(simd, true));
        }
        let [x, y, z] = points.at;
        let v = [f32x16::simd_from(simd, x), f32x16::simd_from(simd, y), f32x16::simd_from(simd, z)];
        let e0 = along(simd, &self.edges[0], lane, v);
        let e1 = along(simd, &self.edges[1], lane, v);
        let e2 = along(simd, &self.edges[2], lane, v);
        let of_size = points.reach * (48.0 * EPSILON) + points.error * 6.2;
        let error = splat(simd, self.edge_size[lane] * of_size + UNDERFLOW);
        let least = min3([e0, e1, e2]);
        let height_error = self.height_error[lane];
        if height_error.is_infinite() {
            // The light may be in the triangle's plane, so signs may be turned.
            let possible = least.simd_ge(-error) | max3([e0, e1, e2]).simd_le(error);
            return (mask32x16::splat(simd, false), possible);
        }
        let height = along(simd, &self.normal, lane, v) - splat(simd, self.at_light[lane]);
        let height_error = splat(simd, self.normal_size[lane] * of_size * 2.0 + height_error * 2.0);
        let possible = least.simd_ge(-error) & height.simd_ge(-height_error);
        let certain = least.simd_gt(error) & height.simd_gt(height_error);
        (certain, possible)
    }
}

/// The dot product of a lane of factors and three coordinates.
#[inline(always)]
fn along<S: Simd>(simd: S, factors: &[[f32; LANES]; 3], lane: usize, [x, y, z]: [f32x16<S>; 3]) -> f32x16<S> {
    let [a, b, c] = [splat(simd, factors[0][lane]), splat(simd, factors[1][lane]), splat(simd, factors[2][lane])];
    a.mul_add(x, b.mul_add(y, c * z))
}
