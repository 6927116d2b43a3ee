//! Sums of solid angles of triangles.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::exact::side;

/// Sums of solid angles, as seen from several points.
///
/// Half the solid angle of a triangle is the argument of a complex number of its corners' positions (Van Oosterom and
/// Strackee, *The solid angle of a plane triangle*, 1983). So a sum of them is the argument of the product of these numbers
/// and whole turns: one arc tangent for a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolidAngles<const POINTS: usize> {
    real: [f64; POINTS],
    imaginary: [f64; POINTS],
    /// Turns of the product, beyond an argument in (−π, π].
    turns: [f64; POINTS],
}

impl<const POINTS: usize> Default for SolidAngles<POINTS> {
    fn default() -> Self {
        Self { real: [1.0; POINTS], imaginary: [0.0; POINTS], turns: [0.0; POINTS] }
    }
}

/// More than the rounding errors of a number's parts, of the product of the corners' distances.
///
/// With u = 2⁻⁵³: coordinates relative to the point are wrong by u of themselves, a product of three of them by 5 u, the sum of
/// six by 8 u of the sum of their magnitudes, which is at most 3 √3 times the product of the distances. The real part is a
/// sum of four terms no larger than that product, each wrong by less than 10 u.
const ERROR: f64 = 64.0 * f64::EPSILON / 2.0;

impl<const POINTS: usize> SolidAngles<POINTS> {
    /// Adds a triangle's solid angle as seen from the points of `slots`: above zero for points that its back faces. It is zero
    /// for points in the triangle's plane, on the triangle as well.
    #[inline(always)]
    pub(super) fn add(&mut self, [x, y, z]: &[[f64; POINTS]; 3], corners: [Vec3; 3], slots: u16) {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (mut real, mut imaginary) = ([0.0; POINTS], [0.0; POINTS]);
        let mut unsure = 0_u32;
        for point in 0..POINTS {
            let [a, b, c] = [a, b, c].map(|corner| [corner.x - x[point], corner.y - y[point], corner.z - z[point]]);
            let [of_a, of_b, of_c] = [a, b, c].map(|corner| dot(corner, corner).sqrt());
            let all = of_a * of_b * of_c;
            real[point] = all + dot(a, b) * of_c + dot(b, c) * of_a + dot(c, a) * of_b;
            imaginary[point] = a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            // Where the real part is certainly above zero, the angle has no jump at the plane.
            let is_unsure = real[point] <= ERROR * all && imaginary[point].abs() <= ERROR * all;
            unsure |= u32::from(is_unsure) << point;
        }
        unsure &= u32::from(slots);
        while unsure != 0 {
            let point = unsure.trailing_zeros() as usize;
            unsure &= unsure - 1;
            let at = DVec3::new(x[point], y[point], z[point]).as_vec3();
            (real[point], imaginary[point]) = match side(at, corners) {
                Ordering::Equal => (1.0, 0.0),
                Ordering::Greater => (real[point], imaginary[point].abs()),
                Ordering::Less => (real[point], -imaginary[point].abs()),
            };
        }
        for point in 0..POINTS {
            let size = real[point].abs() + imaginary[point].abs();
            // No product of corners' distances is too large or too small for f64, so this is zero at a corner alone.
            let is_added = slots >> point & 1 == 1 && size > 0.0;
            let (re, im) = (real[point] / size, imaginary[point] / size);
            let (old_re, old_im) = (self.real[point], self.imaginary[point]);
            let (new_re, new_im) = (old_re * re - old_im * im, old_re * im + old_im * re);
            // Both arguments in [0, π] or both in (−π, 0), and their sum beyond.
            let is_beyond = is_added & (old_im >= 0.0) & (im >= 0.0) & (new_im < 0.0);
            let is_below = is_added & (old_im < 0.0) & (im < 0.0) & (new_im >= 0.0);
            self.turns[point] += f64::from(u8::from(is_beyond)) - f64::from(u8::from(is_below));
            let size = new_re.abs() + new_im.abs();
            self.real[point] = if is_added { new_re / size } else { old_re };
            self.imaginary[point] = if is_added { new_im / size } else { old_im };
        }
    }

    /// A point's sum, in whole spheres.
    pub(super) fn turns(&self, point: usize) -> f64 {
        // Minus zero would be half a turn off.
        let argument = libm::atan2(self.imaginary[point] + 0.0, self.real[point]);
        self.turns[point] + argument / TAU
    }
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
