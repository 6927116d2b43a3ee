//! Angles in one of the light's planes, and the arcs that triangles cover there.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use umbrage_rays::simd::vectors::splat;

/// Relative error bound of an angle of [`atan2`].
///
/// The polynomial is wrong by at most 2 · 10⁻⁸ of the angle, and has 16 roundings of ε = 2⁻²⁴. t has three more, and each
/// coordinate one, which moves the angle by at most a rounding of its tangent. Beyond an octant there is one more of π.
pub(super) const ANGLE_ERROR: f32 = 1.0 / (1 << 18) as f32;

/// The least difference between half a turn and the angles between corners at which it is certain which of two arcs a
/// triangle covers: far more than the error of all three.
const HALF_TURN_MARGIN: f32 = 1e-4;

/// Far more than the rounding of an angle plus a turn, or of π.
const OF_A_TURN: f32 = 4e-6;

/// The angle of the vector (`across`, `along`) from `along`, from −π to π: NaN for the zero vector.
///
/// It uses the polynomial of Abramowitz and Stegun, 4.4.49, in the octant where the tangent is at most one.
#[inline(always)]
pub(super) fn atan2<S: Simd>(simd: S, across: f32x16<S>, along: f32x16<S>) -> f32x16<S> {
    let (x, z) = (along.abs(), across.abs());
    let tangent = x.min(z) / x.max(z);
    let square = tangent * tangent;
    let mut sum = splat(simd, 0.002_866_225_7);
    for factor in
        [-0.016_165_737, 0.042_909_614, -0.075_289_64, 0.106_562_64, -0.142_089, 0.199_935_51, -0.333_331_45, 1.0]
    {
        sum = sum.mul_add(square, splat(simd, factor));
    }
    let angle = sum * tangent;
    let angle = z.simd_gt(x).select(splat(simd, FRAC_PI_2) - angle, angle);
    let angle = along.simd_lt(splat(simd, 0.0)).select(splat(simd, PI) - angle, angle);
    angle.copysign(across)
}

/// The angles of a triangle's points in one of the light's planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// The start, at least −π, and the end, which may be beyond π; NaN for an empty arc.
    start: f32,
    end: f32,
}

impl Arc {
    const EVERYTHING: Self = Self { start: f32::NEG_INFINITY, end: f32::INFINITY };

    /// The arc of a triangle from its corners' angles, grown by `margin` on either side.
    ///
    /// Seen along the plane's normal, a triangle that doesn't meet the normal's line spans less than half a turn around the
    /// light, with a corner at either end. A triangle that meets the line may be all around.
    pub(super) fn of([a, b, c]: [f32; 3], margin: f32) -> Self {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let middle = a.max(b).min(a.min(b).max(c));
        const ENOUGH: f32 = PI + HALF_TURN_MARGIN;
        // A corner without an angle may be on the line.
        let is_known = (a + b + c).is_finite();
        let (start, end) = if !is_known {
            return Self::EVERYTHING;
        } else if TAU - (high - low) > ENOUGH {
            (low, high)
        } else if high - middle > ENOUGH {
            (high, middle + TAU)
        } else if middle - low > ENOUGH {
            (middle, low + TAU)
        } else {
            return Self::EVERYTHING;
        };
        Self { start: start - margin, end: end + margin }
    }

    /// The parts of the arc on either side of the seam at half a turn, each as its lowest and highest angle; the second part
    /// may be empty, with its ends swapped.
    pub(super) fn parts(self) -> [[f32; 2]; 2] {
        let Self { start, end } = self;
        let beyond = if end > PI - OF_A_TURN {
            [f32::NEG_INFINITY, end - TAU + OF_A_TURN]
        } else if start < OF_A_TURN - PI {
            [start + TAU - OF_A_TURN, f32::INFINITY]
        } else {
            [f32::INFINITY, f32::NEG_INFINITY]
        };
        [[start, end], beyond]
    }
}

#[cfg(test)]
mod tests {
    use umbrage_rays::dispatch;

    use super::*;
    use umbrage_rays::SimdLevel;

    fn angles(across: [f32; 16], along: [f32; 16]) -> [f32; 16] {
        dispatch!(SimdLevel::default(), simd => {
            atan2(simd, f32x16::simd_from(simd, across), f32x16::simd_from(simd, along)).into()
        })
    }

    #[test]
    fn angles_are_as_exact_as_they_say() {
        let mut worst = 0.0_f64;
        for step in 0..2_000_000 {
            let turn = f64::from(step) * (std::f64::consts::TAU / 2e6) - std::f64::consts::PI;
            let size = 10_f64.powi(step % 30 - 15);
            let [across, along] = [turn.sin() * size, turn.cos() * size].map(|value| value as f32);
            let small = [across * 1e-6, along];
            let found = angles(std::array::from_fn(|lane| if lane == 0 { across } else { small[0] }), [along; 16]);
            for (angle, across) in [(found[0], across), (found[1], small[0])] {
                let exact = f64::from(across).atan2(f64::from(along));
                if exact != 0.0 && across.abs() > 1e-30 {
                    worst = worst.max((f64::from(angle) - exact).abs() / exact.abs());
                }
            }
        }
        // The other half is for the roundings of coordinates.
        assert!(worst < 0.5 * f64::from(ANGLE_ERROR), "{worst}");
        assert!(angles([0.0; 16], [0.0; 16])[0].is_nan());
    }

    #[test]
    fn arcs_hold_all_points_of_triangles() {
        let mut random = crate::random::Random::new(5);
        let mut unit = || random.signed();
        let mut widths = [0; 3];
        for _ in 0..20_000 {
            let corners = [[unit(), unit()], [unit(), unit()], [unit(), unit()]];
            let angle = |[across, along]: [f64; 2]| across.atan2(along) as f32;
            let parts = Arc::of(corners.map(angle), 1e-6).parts();
            for _ in 0..20 {
                let (u, v) = (unit().abs(), unit().abs());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let weights = [1.0 - u - v, u, v];
                let sum = |axis: usize| (0..3).map(|corner| weights[corner] * corners[corner][axis]).sum();
                let at = angle([sum(0), sum(1)]);
                assert!(parts.iter().any(|[low, high]| (*low..=*high).contains(&at)), "{at} of {corners:?}: {parts:?}");
            }
            let is_everything = parts[0][0] == f32::NEG_INFINITY;
            let is_split = parts[1][0] <= parts[1][1];
            widths[if is_everything { 0 } else { 1 + usize::from(is_split) }] += 1;
        }
        // All three kinds occurred, and few are everything.
        assert!(widths.iter().all(|&count| count > 1000) && widths[0] < 8000, "{widths:?}");
    }
}
