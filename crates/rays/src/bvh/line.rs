use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::Node;
use crate::Ray;
use crate::simd::each;

/// A ray prepared for boxes and triangles in f32. Its t is the distance along the axis k of the direction's largest component,
/// in scaled coordinates.
///
/// **How a box is left out.** With ε = 2⁻²⁴, rounding moves the origin by ε |o| and each slab's t by 5 ε |t|: from the
/// difference, the slope, its reciprocal, what that grows by, and the product. Boxes are grown by more than twice the one, and
/// intervals by 8 ε |t|. No ray whose t are above zero leaves a box that it meets below zero, so the intervals of these grow
/// with the reciprocal alone. What overflows is no number, which leaves nothing out.
#[derive(Clone, Copy)]
pub struct Line {
    /// Scaled, and rounded to f32.
    pub origin: [f32; 3],
    /// What is taken from the coordinate at which a ray enters a box: the origin, and what the box grows by.
    pub enter_origin: [f32; 3],
    /// What is taken from the coordinate at which it leaves.
    pub leave_origin: [f32; 3],
    /// What its t grows by for a step along each axis.
    pub inverse: [f32; 3],
    /// 1 where the ray goes down an axis.
    pub is_backward: [usize; 3],
    /// The two other axes, and k.
    pub axes: [usize; 3],
    /// How far the ray goes back along the two other axes for one step along k.
    pub slopes: [f32; 2],
    /// 1 or −1: the direction along k.
    pub sign: f32,
    /// The origin's largest coordinate if f32 can't hold the origin, else next to nothing.
    pub(super) blur: f32,
    /// The ray's own t, times this, is the t here.
    scale: f64,
    /// At most the least t, and at least the largest.
    pub near: f32,
    /// The latter.
    pub far: f32,
    /// At least the least t.
    pub(super) after: f32,
    /// Whether no t is below zero, as of nearly all rays.
    pub is_ahead: bool,
}

/// Boxes' intervals grow by this share of t.
const RELATIVE_MARGIN: f32 = 4.0 * f32::EPSILON;
/// What a reciprocal is multiplied with for the end of an interval whose t are above zero.
pub const MORE: f32 = 1.0 + RELATIVE_MARGIN;
/// The same for its beginning.
pub const LESS: f32 = 1.0 - RELATIVE_MARGIN;

impl Line {
    /// For coordinates that are `unit` times those of the ray; `None` where they are beyond f32's.
    ///
    /// Without branches on directions, which nobody could guess.
    #[inline(always)]
    pub fn new(ray: &Ray, unit: f32) -> Option<Self> {
        // A ray along a slab has no crossing with it: a finite stand-in for 1/0 gives it one that is so far away, for
        // every box that holds the ray once grown by `SMALLEST`, that it doesn't matter.
        const STEEPEST: f32 = 1e38;
        const SMALLEST: f32 = 1e-20;
        const FARTHEST: f64 = 1e30;
        let unit = f64::from(unit);
        let size = ray.direction.abs().to_array();
        let of_two = usize::from(size[1] > size[0]);
        let k = if size[2] > size[of_two] { 2 } else { of_two };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][k];
        let scaled = ray.origin * unit;
        if scaled.abs().max_element() > FARTHEST {
            return None;
        }
        let (length, scaled) = (size[k], scaled.to_array());
        let origin = each!(scaled in scaled => scaled as f32);
        // Of each axis for a step along k; ±1 for k itself. One that f32 can't hold is one along the slab.
        let slopes = each!(slope in (ray.direction / length).to_array() => slope as f32);
        let growth = each!(axis in [0, 1, 2] => {
            (origin[axis].abs() * (2.0 * f32::EPSILON) + SMALLEST).copysign(slopes[axis])
        });
        let lost = each!(axis in [0, 1, 2] => {
            if f64::from(origin[axis]) == scaled[axis] { LEAST_BLUR } else { origin[axis].abs() }
        });
        let (sign, scale) = (slopes[k], length * unit);
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
            is_ahead,
        })
    }

    /// A number here that is at least a t of the ray.
    #[inline(always)]
    pub(super) fn at_least(&self, t: f64) -> f32 {
        at_least(t * self.scale)
    }

    #[cfg(test)]
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }
}

/// An f32 that is above a number, whatever rounding and scaling have made of it.
#[inline(always)]
fn at_least(t: f64) -> f32 {
    let t = (t as f32).clamp(f32::MIN, f32::MAX);
    t + (t.abs() * (2.0 * f32::EPSILON) + f32::MIN_POSITIVE)
}

#[inline(always)]
fn at_most(t: f64) -> f32 {
    -at_least(-t)
}

/// The origin is taken to be off by eight roundings of this at least: more than what scaling loses of coordinates.
const LEAST_BLUR: f32 = 1.0 / (1_u128 << 100) as f32;

/// What boxes are tested with, in all lanes.
pub struct Slabs<S: Simd> {
    enter_origin: [f32x8<S>; 3],
    leave_origin: [f32x8<S>; 3],
    /// Where the ray is ahead, intervals grow by these.
    enter_inverse: [f32x8<S>; 3],
    leave_inverse: [f32x8<S>; 3],
    is_ahead: bool,
    /// Which of a node's bounds a ray comes to first.
    first: [usize; 3],
    near: f32x8<S>,
}

impl<S: Simd> Slabs<S> {
    #[inline(always)]
    /// Those of a line.
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

    /// Where a ray may enter the boxes of a node's children at the earliest, and a bit for each that it doesn't certainly miss
    /// before `far`.
    #[inline(always)]
    pub fn enter(&self, simd: S, node: &Node, far: f32) -> (f32x8<S>, u64) {
        let [x, y, z] = each!(axis in [0, 1, 2] => {
            let bound = f32x8::from_slice(simd, &node.bounds[2 * axis + self.first[axis]]);
            (bound - self.enter_origin[axis]) * self.enter_inverse[axis]
        });
        let mut enter = x.max(y).max(z);
        let [x, y, z] = each!(axis in [0, 1, 2] => {
            let bound = f32x8::from_slice(simd, &node.bounds[2 * axis + (1 - self.first[axis])]);
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
            // Some are in planes of boxes, and some rays along axes.
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
            // One whose corner, edge or inside has the target, and one anywhere.
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
