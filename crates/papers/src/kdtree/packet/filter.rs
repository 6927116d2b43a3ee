use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::Vec3;

use super::rays::{HALF_ULP, Rays};
use super::scale::Scale;
use umbrage_rays::each;

/// Vectors of f32, with a lane for each ray that is led to leaves together.
pub trait Wide<S: Simd>: SimdFloat<S, Element = f32> {}

impl<S: Simd, V: SimdFloat<S, Element = f32>> Wide<S> for V {}

/// A triangle that is prepared for tests in f32 against arbitrary rays: Möller and Trumbore's test (1997) without its
/// division, and with error bounds for its roundings.
///
/// With s = o − a and E the largest component of both edges from a, the weights of b and c times the determinant are sums of
/// six products s d e, each no larger than 2 E, with eight roundings: 96 ε E. The roundings in s itself add 12 ε E, and f64
/// adds 6 E times the distance by which it may have `moved` origins. The determinant has six products d e e with seven
/// roundings, 84 ε E as E is two at most. The weight of a is the determinant minus the others, with two more roundings of up
/// to 60 ε E in all. t times the determinant has six products s e e with eight roundings: 108 ε E² with the errors of s. For
/// relevant τ, the product of τ and a determinant with an error of 42 ε E² adds 110 ε E², and its roundings 44 ε E².
pub struct Filter {
    a: [f32; 3],
    b_from_a: [f32; 3],
    c_from_a: [f32; 3],
    /// Error bounds, times the determinant: of the weights of b and c, and of that of a.
    pub weight_bounds: [f32; 2],
    /// Error bound of the determinant.
    pub determinant_bound: f32,
    /// Error bound of t, times the determinant.
    t_bound: f32,
}

impl Filter {
    /// Prepares a triangle with these corners for rays whose origins f64 may have `moved` that far.
    #[inline(always)]
    pub fn new(scale: &Scale, corners: [Vec3; 3], moved: f32) -> Self {
        let [a, b, c] = corners;
        let (b_from_a, c_from_a) = (scale.difference(a, b), scale.difference(a, c));
        let size = |v: [f32; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let size = size(b_from_a).max(size(c_from_a));
        // Guards against products that are too small for an f32.
        const LEAST: f32 = 1e-30;
        let weight = size * (128.0 * HALF_ULP + 8.0 * moved) + LEAST;
        let square = size * size;
        Self {
            a: scale.point(a),
            b_from_a,
            c_from_a,
            weight_bounds: [weight, 3.0 * weight],
            determinant_bound: square * (48.0 * HALF_ULP) + LEAST,
            t_bound: square * (320.0 * HALF_ULP + 8.0 * moved) + LEAST,
        }
    }

    /// Returns a mask of the rays from `first` on that may hit the triangle before they end. NaN rules nothing out.
    #[inline(always)]
    pub fn possible<S: Simd, V: Wide<S>>(&self, simd: S, rays: &Rays, first: usize) -> u64 {
        let Values { weights: [u, v, w], determinant, t } =
            self.values::<S, V>(simd, load_three(simd, &rays.origin, first), load_three(simd, &rays.direction, first));
        let (lowest, highest) = (v.min(w), v.max(w));
        let [bound, bound_of_a] = self.weight_bounds;
        let (bound, bound_of_a) = (splat::<S, V>(simd, bound), splat::<S, V>(simd, bound_of_a));
        let below = lowest.simd_lt(-bound) | u.simd_lt(-bound_of_a);
        let above = highest.simd_gt(bound) | u.simd_gt(bound_of_a);
        let missed = below & above;
        let size = determinant.abs();
        let t = t.copysign_by(determinant);
        let (enter, leave) = (load::<S, V>(simd, &rays.enter, first), load::<S, V>(simd, &rays.leave, first));
        let error = splat::<S, V>(simd, self.t_bound);
        let outside = t.simd_gt(leave * size + error) | t.simd_lt(enter * size - error);
        let outside = outside & size.simd_gt(splat::<S, V>(simd, self.determinant_bound));
        !(missed | outside).to_bitmask()
    }

    /// Returns the edge functions and the determinant of lines, regardless of their intervals.
    #[inline(always)]
    pub fn values<S: Simd, V: Wide<S>>(&self, simd: S, origin: [V; 3], direction: [V; 3]) -> Values<V> {
        let offset = each!(axis in [0, 1, 2] => origin[axis] - splat::<S, V>(simd, self.a[axis]));
        let b = each!(value in self.b_from_a => splat::<S, V>(simd, value));
        let c = each!(value in self.c_from_a => splat::<S, V>(simd, value));
        let normal = cross(direction, c);
        let determinant = dot(b, normal);
        let v = dot(offset, normal);
        let across = cross(offset, b);
        let w = dot(direction, across);
        let u = determinant - v - w;
        Values { weights: [u, v, w], determinant, t: dot(c, across) }
    }
}

/// Values of rays and a triangle, all times the determinant.
pub struct Values<V> {
    /// Weights of a, b and c.
    pub weights: [V; 3],
    /// Its sign tells from which side rays come.
    pub determinant: V,
    t: V,
}

/// Numbers that can take the sign of others.
trait SignedBy<S: Simd>: Wide<S> {
    /// This number, negated where `other` is negative.
    #[inline(always)]
    fn copysign_by(self, other: Self) -> Self {
        let zero = Self::simd_from(self.token(), 0.0);
        other.simd_lt(zero).select(-self, self)
    }
}

impl<S: Simd, V: Wide<S>> SignedBy<S> for V {}

/// A vector of the same number.
#[inline(always)]
pub(super) fn splat<S: Simd, V: Wide<S>>(simd: S, value: f32) -> V {
    V::simd_from(simd, value)
}

/// Loads the numbers from `first` on.
#[inline(always)]
pub fn load<S: Simd, V: Wide<S>>(simd: S, numbers: &[f32], first: usize) -> V {
    V::from_slice(simd, &numbers[first..first + V::LEN])
}

#[inline(always)]
fn load_three<S: Simd, V: Wide<S>, const N: usize>(simd: S, numbers: &[[f32; N]; 3], first: usize) -> [V; 3] {
    [load(simd, &numbers[0], first), load(simd, &numbers[1], first), load(simd, &numbers[2], first)]
}

#[inline(always)]
fn dot<S: Simd, V: Wide<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd, V: Wide<S>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
