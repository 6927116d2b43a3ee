//! The filter: bounds of a point's distances from sixteen triangles, in f32.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::simd::each;
use crate::simd::lanes::{LANES, load_local_corner, splat};

/// Numbers are multiplied by a power of two that makes the scene's size about one. The filter can't tell distances from
/// triangles that reach farther than this: products of degree four don't overflow below it.
pub(super) const FARTHEST: f32 = (1 << 30) as f32;

/// Shorter distances can't be told from zero. It is more than longer ones lose to products that underflow.
const SMALLEST: f32 = 1.0 / (1_u64 << 48) as f32;

/// More than the rounding errors of a distance: 16 ε.
const ERROR: f32 = 16.0 / (1 << 24) as f32;

/// Sixteen triangles, prepared for many points.
pub(super) struct SixteenTriangles<S: Simd> {
    a: [f32x16<S>; 3],
    /// B − A and C − A.
    ab: [f32x16<S>; 3],
    ac: [f32x16<S>; 3],
    /// AB², AB · AC, AC², BC².
    squares: [f32x16<S>; 4],
    /// Inverses of AB², AC² and BC²; zero for an edge without length.
    inverses: [f32x16<S>; 3],
    /// The inverse of |AB × AC|²; zero for a triangle without area.
    inverse_area: f32x16<S>,
    /// |AB|₁ + |AC|₁.
    size: f32x16<S>,
    /// Lanes with a triangle whose corners are finite.
    pub(super) filled: u16,
    /// The box around these.
    pub(super) bounds: [[f32; 3]; 2],
}

/// Bounds of the distances from sixteen triangles.
pub(super) struct Distances<S: Simd> {
    pub(super) least: f32x16<S>,
    pub(super) most: f32x16<S>,
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
fn minus<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn sum_of<S: Simd>(a: [f32x16<S>; 3]) -> f32x16<S> {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// One over each number; zero unless that is a normal number.
#[inline(always)]
fn inverse<S: Simd>(simd: S, number: f32x16<S>) -> f32x16<S> {
    let is_normal = number.simd_gt(splat(simd, 1e-37)) & number.simd_lt(splat(simd, 1e37));
    is_normal.select(splat(simd, 1.0) / number, splat(simd, 0.0))
}

impl<S: Simd> SixteenTriangles<S> {
    /// Prepares the first `count` of sixteen triangles, with corners that are indices of scaled vertices. A vertex that isn't
    /// finite is NaN.
    #[inline(always)]
    pub(super) fn new(simd: S, vertices: &[[f32; 4]], corners: &[[u8; 4]], count: usize) -> Self {
        let a = load_local_corner(simd, vertices, corners, 0);
        let b = load_local_corner(simd, vertices, corners, 1);
        let c = load_local_corner(simd, vertices, corners, 2);
        let (ab, ac, bc) = (minus(b, a), minus(c, a), minus(c, b));
        let squares = [dot(ab, ab), dot(ab, ac), dot(ac, ac), dot(bc, bc)];
        let inverses = [inverse(simd, squares[0]), inverse(simd, squares[2]), inverse(simd, squares[3])];
        let inverse_area = inverse(simd, squares[0] * squares[2] - squares[1] * squares[1]);
        // False for NaN. A coordinate that is infinite because it was scaled is one of a triangle that exists.
        let sum = sum_of(a) + sum_of(b) + sum_of(c);
        let is_number = sum.simd_eq(sum);
        let (infinity, none) = (splat(simd, f32::INFINITY), splat(simd, f32::NEG_INFINITY));
        let lanes = f32x16::simd_from(simd, NUMBERS);
        let filled = is_number & lanes.simd_lt(splat(simd, count as f32));
        let low = each!(axis in [0, 1, 2] => filled.select(a[axis].min(b[axis]).min(c[axis]), infinity).reduce_min());
        let high = each!(axis in [0, 1, 2] => filled.select(a[axis].max(b[axis]).max(c[axis]), none).reduce_max());
        // Nothing is known of the distance from a lane without a triangle.
        let size = filled.select(sum_of(ab) + sum_of(ac), infinity);
        let filled = filled.to_bitmask() as u16;
        Self { a, ab, ac, squares, inverses, inverse_area, size, filled, bounds: [low, high] }
    }

    /// Bounds of a point's distances from the triangles.
    ///
    /// As [`measure`](super::measure::measure), with ε = 2⁻²⁴ for u. Weights come from the squares of edges, which is faster;
    /// bounds hold for any weights.
    #[inline(always)]
    pub(super) fn distances(&self, simd: S, [x, y, z]: [f32; 3]) -> Distances<S> {
        let Self { ab, ac, squares: [ab_ab, ab_ac, ac_ac, bc_bc], inverses, inverse_area, .. } = *self;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let a = [self.a[0] - splat(simd, x), self.a[1] - splat(simd, y), self.a[2] - splat(simd, z)];
        let (to_b, to_c) = (-dot(ab, a), -dot(ac, a));
        let v = (to_b * ac_ac - to_c * ab_ac) * inverse_area;
        let w = (to_c * ab_ab - to_b * ab_ac) * inverse_area;
        let inside = v.simd_ge(zero) & w.simd_ge(zero) & (v + w).simd_le(one) & inverse_area.simd_gt(zero);
        let on_ab = (to_b * inverses[0]).max(zero).min(one);
        let on_ac = (to_c * inverses[1]).max(zero).min(one);
        let from_b_to_c = (to_c - to_b) + (ab_ab - ab_ac);
        let on_bc = (from_b_to_c * inverses[2]).max(zero).min(one);
        // Squared distances from the three edges, less that from A.
        let of_ab = on_ab * (on_ab * ab_ab - (to_b + to_b));
        let of_ac = on_ac * (on_ac * ac_ac - (to_c + to_c));
        let of_bc = (ab_ab - (to_b + to_b)) + on_bc * (on_bc * bc_bc - (from_b_to_c + from_b_to_c));
        let is_ac = of_ac.simd_lt(of_ab);
        let is_bc = of_bc.simd_lt(of_ab.min(of_ac));
        let edge_v = is_bc.select(one - on_bc, is_ac.select(zero, on_ab));
        let edge_w = is_bc.select(on_bc, is_ac.select(on_ac, zero));
        let (v, w) = (inside.select(v, edge_v), inside.select(w, edge_w));
        let q = [
            ac[0].mul_add(w, ab[0].mul_add(v, a[0])),
            ac[1].mul_add(w, ab[1].mul_add(v, a[1])),
            ac[2].mul_add(w, ab[2].mul_add(v, a[2])),
        ];
        let distance = dot(q, q).sqrt();
        let behind = dot(q, a) + dot(q, ab).min(dot(q, ac)).min(zero);
        let reach = sum_of(a) + self.size;
        let error = reach.mul_add(splat(simd, ERROR), splat(simd, SMALLEST));
        // False for NaN.
        let can_tell = reach.simd_lt(splat(simd, FARTHEST));
        let least = behind / distance - error;
        let is_above_zero = can_tell & distance.simd_gt(splat(simd, SMALLEST)) & least.simd_gt(zero);
        Distances {
            least: is_above_zero.select(least, zero),
            most: can_tell.select(distance + error, splat(simd, f32::INFINITY)),
        }
    }
}

const NUMBERS: [f32; LANES] = {
    let mut numbers = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        numbers[lane] = lane as f32;
        lane += 1;
    }
    numbers
};
