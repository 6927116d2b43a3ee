//! Shrinking boxes around the parts of triangles that a plane cuts (Soupikov et al. 2008), in f32 for speed.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use glam::Vec3;

use super::boxes::Boxed;
use crate::kdtree::extent::Plane;

/// The largest coordinate that is clipped: crossings of larger ones might overflow.
pub(super) const LARGEST: f32 = 1e37;

/// More than twice the error bound of a crossing, for each unit of the magnitudes of its edge's ends: the weight has three
/// roundings, one minus it a fourth, products and sum two more and the margin's subtraction a last one, of 2⁻²⁴ each.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// Shrinks the boxes of a triangle below and above a plane that goes through it.
#[inline(always)]
pub(super) fn clip<S: Simd>(simd: S, corners: [Vec3; 3], plane: Plane, below: &mut Boxed, above: &mut Boxed) {
    let Plane { axis, at } = plane;
    let nothing = f32x8::splat(simd, f32::INFINITY);
    let mut corner = [nothing; 3];
    let mut along = [0.0; 3];
    for index in 0..3 {
        let Vec3 { x, y, z } = corners[index];
        corner[index] = f32x8::from_slice(simd, &[x, y, z, 0.0, -x, -y, -z, 0.0]);
        along[index] = corners[index][axis];
    }
    let (mut low, mut high) = (nothing, nothing);
    for index in 0..3 {
        let next = if index == 2 { 0 } else { index + 1 };
        let (from, to) = (corner[index], corner[next]);
        let (start, end) = (along[index], along[next]);
        if start <= at {
            low = low.min(from);
        }
        if start >= at {
            high = high.min(from);
        }
        if (start < at) != (end < at) && start != at && end != at {
            let weight = (at - start) / (end - start);
            let crossing = from * (1.0 - weight) + to * weight;
            let margin = (from.abs() + to.abs()) * MARGIN + f32::MIN_POSITIVE;
            // Rounding might lead beyond the ends.
            let crossing = (crossing - margin).max(from.min(to));
            low = low.min(crossing);
            high = high.min(crossing);
        }
    }
    below.shrink(simd, low);
    above.shrink(simd, high);
}

#[cfg(test)]
mod tests {
    use umbrage_rays::dispatch;

    use super::*;
    use crate::kdtree::validate::part;
    use umbrage_rays::SimdLevel;

    /// Numbers from −1 to 1.
    fn random(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn clipped_boxes_hold_their_part_and_little_else_on_all_levels() {
        let mut state = 1;
        for step in 0..3000 {
            // Around the origin, far from it, and flat.
            let offset = [0.0, 1000.0, -1e6][step % 3];
            let thin = [1.0, 1e-3][step % 2];
            let mut point = || Vec3::new(random(&mut state), random(&mut state) * thin, random(&mut state)) + offset;
            let corners = [point(), point(), point()];
            let axis = step % 3;
            let whole = Boxed::around(corners, step as u32);
            let weight = (random(&mut state) + 1.0) * 0.5;
            let at = whole.low(axis) * (1.0 - weight) + whole.high(axis) * weight;
            if !(whole.low(axis) < at && at < whole.high(axis)) {
                continue;
            }
            let plane = Plane { axis, at };
            let clipped = |level: SimdLevel| {
                let (mut below, mut above) = (whole, whole);
                below.0[4 + axis] = -at;
                above.0[axis] = at;
                dispatch!(level, simd => clip(simd, corners, plane, &mut below, &mut above));
                [below, above]
            };
            let all = SimdLevel::available().into_iter().map(clipped);
            let all: Vec<_> = all.collect();
            for [below, above] in &all {
                for (boxed, first, side) in [(below, &all[0][0], 1.0), (above, &all[0][1], -1.0)] {
                    assert_eq!(boxed.0, first.0);
                    assert_eq!(boxed.id(), step as u32);
                    let part = part(&corners.map(Vec3::as_dvec3), plane, side);
                    for axis in 0..3 {
                        let low = part.iter().map(|point| point[axis]).fold(f64::INFINITY, f64::min);
                        let high = part.iter().map(|point| point[axis]).fold(f64::NEG_INFINITY, f64::max);
                        let slack = (low.abs() + high.abs() + 1.0) * 3e-6;
                        let found = [f64::from(boxed.low(axis)), f64::from(boxed.high(axis))];
                        // The error bound of this test's own numbers.
                        let own = slack * 1e-8;
                        assert!(found[0] <= low + own && found[0] >= low - slack, "{found:?} {low} {high}");
                        assert!(found[1] >= high - own && found[1] <= high + slack, "{found:?} {low} {high}");
                    }
                }
            }
        }
    }
}
