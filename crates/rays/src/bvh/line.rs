use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::Node;
use crate::Ray;
use crate::simd::each;

/// A ray prepared for boxes and triangles in f32. Its t is the distance along the axis k of the direction's largest
/// component, in scaled coordinates.
///
/// **Box test.** With ε = 2⁻²⁴, rounding moves the origin by ε |o| and each slab's t by 5 ε |t|: from the difference, the
/// slope, its reciprocal, the growth of that, and the product. Boxes are grown by more than twice the former, and intervals
/// by 8 ε |t|. A ray with positive t only doesn't leave a box that it meets at negative t, so its intervals grow with the
/// reciprocal alone. Overflow gives NaN, which rules nothing out.
#[derive(Clone, Copy)]
pub struct Line {
    /// Origin, scaled and rounded to f32.
    pub origin: [f32; 3],
    /// Subtracted from the coordinate at which a ray enters a box: the origin, moved by the growth of the box.
    pub enter_origin: [f32; 3],
    /// Subtracted from the coordinate at which it leaves.
    pub leave_origin: [f32; 3],
    /// Growth of t per unit along each axis.
    pub inverse: [f32; 3],
    /// 1 for each axis along which the ray goes down.
    pub is_backward: [usize; 3],
    /// The two other axes, and k.
    pub axes: [usize; 3],
    /// Movement of the ray along the two other axes, negated, per unit along k.
    pub slopes: [f32; 2],
    /// Sign of the direction along k: 1 or −1.
    pub sign: f32,
    /// The origin's largest coordinate if f32 can't hold the origin, else almost zero.
    pub(super) blur: f32,
    /// Factor from the ray's own t to the t here.
    scale: f64,
    /// Lower bound of the least t.
    pub near: f32,
    /// Upper bound of the largest t.
    pub far: f32,
    /// Upper bound of the least t.
    pub(super) after: f32,
    /// Lower bound of the largest t; below all t where f64 may not hold a hit's t.
    pub(super) before: f32,
    /// Whether no t is negative, as for nearly all rays.
    pub is_ahead: bool,
}

/// Relative growth of boxes' intervals.
const RELATIVE_MARGIN: f32 = 4.0 * f32::EPSILON;
/// Factor of a reciprocal for the end of an interval with positive t.
pub const MORE: f32 = 1.0 + RELATIVE_MARGIN;
/// Factor for its start.
pub const LESS: f32 = 1.0 - RELATIVE_MARGIN;

impl Line {
    /// A line for coordinates that are `unit` times those of the ray; `None` where they are out of f32's range, or the
    /// direction's length times `unit` is out of f64's.
    ///
    /// There are no branches on directions, which would be unpredictable.
    #[inline(always)]
    pub fn new(ray: &Ray, unit: f32) -> Option<Self> {
        // A ray along a slab has no crossing with it. A finite stand-in for 1/0 gives it a crossing so far away that it
        // doesn't matter, for every box that holds the ray once grown by `SMALLEST`.
        const STEEPEST: f32 = 1e38;
        const SMALLEST: f32 = 1e-20;
        const FARTHEST: f64 = 1e30;
        // With lengths in this range the predicate's t is neither zero nor infinite, and nothing on its way overflows.
        const USUAL: std::ops::Range<f64> = 1e-100..1e100;
        let unit = f64::from(unit);
        let size = ray.direction.abs().to_array();
        let of_two = usize::from(size[1] > size[0]);
        let k = if size[2] > size[of_two] { 2 } else { of_two };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][k];
        let (length, scaled) = (size[k], ray.origin * unit);
        let scale = length * unit;
        // A factor of zero or infinity makes NaN of infinite or zero ends.
        if scaled.abs().max_element() > FARTHEST || !scale.is_normal() {
            return None;
        }
        let scaled = scaled.to_array();
        let origin = each!(scaled in scaled => scaled as f32);
        // Slope of each axis per unit along k; ±1 for k itself. A slope below f32's range becomes a ray along the slab.
        let slopes = each!(slope in (ray.direction / length).to_array() => slope as f32);
        let growth = each!(axis in [0, 1, 2] => {
            (origin[axis].abs() * (2.0 * f32::EPSILON) + SMALLEST).copysign(slopes[axis])
        });
        let lost = each!(axis in [0, 1, 2] => {
            if f64::from(origin[axis]) == scaled[axis] { LEAST_BLUR } else { origin[axis].abs() }
        });
        let sign = slopes[k];
        let (is_ahead, near) = (ray.t_min >= 0.0, at_most(ray.t_min * scale));
        Some(Self {
            origin,
            enter_origin: each!(axis in [0, 1, 2] => origin[axis] + growth[axis]),
            leave_origin: each!(axis in [0, 1, 2] => origin[axis] - growth[axis]),
            inverse: each!(slope in slopes => (1.0 / slope.abs()).min(STEEPEST).copysign(slope)),
            is_backward: each!(slope in slopes => usize::from(slope.is_sign_negative())),
            axes,
            slopes: [-slopes[axes[0]] * sign, -slopes[axes[1]] * sign],
            sign,
            blur: lost[0].max(lost[1]).max(lost[2]).max(LEAST_BLUR),
            scale,
            near: if is_ahead { near.max(0.0) } else { near },
            far: at_least(ray.t_max * scale),
            after: at_least(ray.t_min * scale),
            before: if USUAL.contains(&length) { at_most(ray.t_max * scale) } else { f32::NEG_INFINITY },
            is_ahead,
        })
    }

    /// The line for boxes and triangles that may be off by `moved` along each axis.
    #[inline(always)]
    pub(super) fn widened(self, moved: f32) -> Self {
        const EPSILON: f32 = 1.0 / (1 << 24) as f32;
        let grown = moved * 1.001;
        let growth = each!(slope in self.inverse => grown.copysign(slope));
        Self {
            enter_origin: each!(axis in [0, 1, 2] => self.enter_origin[axis] + growth[axis]),
            leave_origin: each!(axis in [0, 1, 2] => self.leave_origin[axis] - growth[axis]),
            // Corners are wrong by ε times the blur.
            blur: self.blur + grown / EPSILON,
            ..self
        }
    }

    /// An upper bound, here, of a t of the ray.
    #[inline(always)]
    pub(super) fn at_least(&self, t: f64) -> f32 {
        at_least(t * self.scale)
    }

    #[cfg(test)]
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }
}

/// An f32 above a number, in spite of rounding and scaling.
#[inline(always)]
fn at_least(t: f64) -> f32 {
    let t = (t as f32).clamp(f32::MIN, f32::MAX);
    t + (t.abs() * (2.0 * f32::EPSILON) + f32::MIN_POSITIVE)
}

#[inline(always)]
fn at_most(t: f64) -> f32 {
    -at_least(-t)
}

/// The least blur: eight roundings of this are more than scaling loses of coordinates.
const LEAST_BLUR: f32 = 1.0 / (1_u128 << 100) as f32;

/// A line prepared for box tests, in all lanes.
pub struct Slabs<S: Simd> {
    enter_origin: [f32x8<S>; 3],
    leave_origin: [f32x8<S>; 3],
    /// Reciprocals; for a ray that is ahead, with the growth of intervals.
    enter_inverse: [f32x8<S>; 3],
    leave_inverse: [f32x8<S>; 3],
    is_ahead: bool,
    /// The bound, of each axis, that a ray comes to first.
    first: [usize; 3],
    near: f32x8<S>,
}

impl<S: Simd> Slabs<S> {
    #[inline(always)]
    /// The slabs of a line.
    pub fn new(simd: S, line: &Line) -> Self {
        let (less, more) = if line.is_ahead { (LESS, MORE) } else { (1.0, 1.0) };
        Self {
            enter_origin: each!(origin in line.enter_origin => f32x8::splat(simd, origin)),
            leave_origin: each!(origin in line.leave_origin => f32x8::splat(simd, origin)),
            enter_inverse: each!(inverse in line.inverse => f32x8::splat(simd, inverse * less)),
            leave_inverse: each!(inverse in line.inverse => f32x8::splat(simd, inverse * more)),
            is_ahead: line.is_ahead,
            first: [line.is_backward[0] & 1, line.is_backward[1] & 1, line.is_backward[2] & 1],
            near: f32x8::splat(simd, line.near),
        }
    }

    /// Lower bounds of the t at which a ray enters the boxes of a node's children, and a bit for each child not certainly
    /// missed before `far`.
    #[inline(always)]
    pub fn enter(&self, simd: S, node: &Node, far: f32) -> (f32x8<S>, u64) {
        let [x, y, z] = each!(axis in [0, 1, 2] => {
            let bound = f32x8::from_slice(simd, &node.bounds[2 * axis + (self.first[axis] & 1)]);
            (bound - self.enter_origin[axis]) * self.enter_inverse[axis]
        });
        let mut enter = x.max(y).max(z);
        let [x, y, z] = each!(axis in [0, 1, 2] => {
            let bound = f32x8::from_slice(simd, &node.bounds[2 * axis + (!self.first[axis] & 1)]);
            (bound - self.leave_origin[axis]) * self.leave_inverse[axis]
        });
        let mut leave = x.min(y).min(z);
        if !self.is_ahead {
            enter = (enter * LESS).min(enter * MORE);
            leave = (leave * LESS).max(leave * MORE);
        }
        let enter = enter.max(self.near);
        let leave = leave.min(f32x8::splat(simd, far));
        let missed = enter.simd_gt(leave).to_bitmask();
        (enter, !missed & 0xff)
    }
}

#[cfg(test)]
mod tests {
    use crate::dispatch;
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::SimdLevel;
    use crate::random::Random;

    #[test]
    fn no_box_is_left_out_that_a_ray_enters() {
        let mut random = Random::new(8);
        let mut point = |round: usize| {
            let point = DVec3::new(random.signed(), random.signed(), random.signed());
            // Some points are in planes of boxes, and some rays along axes.
            if round.is_multiple_of(3) { (point * 2.0).round() } else { point }
        };
        let mut left_out = 0;
        for round in 0..100_000_usize {
            let world = f64::exp2((round % 61) as f64 - 30.0);
            let (origin, target) = (point(round) * world, point(round) * world);
            let ray = Ray::new(origin, (target - origin) * f64::exp2((round % 40) as f64 - 20.0));
            if ray.direction == DVec3::ZERO {
                continue;
            }
            // Two boxes: one with the target at its corner, on its edge or inside, and one anywhere.
            let half = (point(round) * world).abs() * f64::exp2(-((round % 17) as f64));
            let away = half * point(0).clamp(DVec3::NEG_ONE, DVec3::ONE);
            let mut node = Node::EMPTY;
            let boxes = [(target - away, half), (point(1) * world, half)];
            for (slot, (middle, half)) in boxes.into_iter().enumerate() {
                // Rounded outward.
                let bounds = [(middle - half).as_vec3(), (middle + half).as_vec3()];
                for (axis, (low, high)) in bounds[0].to_array().into_iter().zip(bounds[1].to_array()).enumerate() {
                    node.bounds[2 * axis][slot] = low.next_down();
                    node.bounds[2 * axis + 1][slot] = high.next_up();
                }
            }
            let line = Line::new(&ray, 1.0).expect("a line");
            for level in SimdLevel::available() {
                let (enter, met) = dispatch!(level, simd => {
                    let (enter, met) = Slabs::new(simd, &line).enter(simd, &node, line.far);
                    (<[f32; 8]>::from(enter), met)
                });
                assert!(met & 1 == 1, "{ray:?} goes to {target} in {:?}", boxes[0]);
                let t = (target - origin).abs().max_element();
                assert!(f64::from(enter[0]) <= t, "{ray:?} comes to {target} at {t} and not {}", enter[0]);
                assert!(met & 0xfc == 0, "there are no other boxes");
                left_out += u32::from(met & 2 == 0);
            }
        }
        assert!(left_out > 50_000, "{left_out}");
    }

    #[test]
    fn what_f32_cannot_hold_has_no_line() {
        for origin in [DVec3::splat(1e300), DVec3::X * -1e36] {
            assert!(Line::new(&Ray::new(origin, Vec3::ONE.as_dvec3()), 1.0).is_none());
        }
    }
}
