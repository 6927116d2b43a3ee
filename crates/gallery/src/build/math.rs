//! Arithmetic that gives the same bits on every machine, unlike the standard library's transcendental functions.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

/// Sine and cosine of an angle.
pub(crate) fn sin_cos(radians: f32) -> (f32, f32) {
    libm::sincosf(radians)
}

/// Sine of an angle.
pub(crate) fn sin(radians: f32) -> f32 {
    libm::sinf(radians)
}

/// Cosine of an angle.
pub(crate) fn cos(radians: f32) -> f32 {
    libm::cosf(radians)
}

/// Sine of a number of turns: `wave(0.25)` is 1.
pub(crate) fn wave(turns: f32) -> f32 {
    libm::sinf(TAU * (turns - turns.floor()))
}

/// The point at distance `radius` from the y axis and at `height`, after `turns` turns about the axis.
pub(crate) fn around(turns: f32, radius: f32, height: f32) -> Vec3 {
    let (sin, cos) = sin_cos(TAU * turns);
    Vec3::new(radius * cos, height, -radius * sin)
}

/// `base` to the power of `exponent`.
pub(crate) fn pow(base: f32, exponent: f32) -> f32 {
    libm::powf(base, exponent)
}

/// From 0 at `from` to 1 at `to` without a kink at either end; `from` may be the greater one, but not the same.
pub(crate) fn smoothstep(from: f32, to: f32, at: f32) -> f32 {
    let part = ((at - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// From `a` at `part` 0 to `b` at `part` 1.
pub(crate) fn mix(a: f32, b: f32, part: f32) -> f32 {
    a + (b - a) * part
}

/// The rotation by `radians` about the unit vector `axis`, counterclockwise seen from its tip.
pub(crate) fn rotation(axis: Vec3, radians: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * radians);
    let [x, y, z] = (axis * sin).to_array();
    Quat::from_xyzw(x, y, z, cos)
}

/// The rotation by `radians` about the vertical axis, counterclockwise seen from above.
pub(crate) fn turned(radians: f32) -> Quat {
    rotation(Vec3::Y, radians)
}

/// The shortest rotation that takes unit vector `from` to unit vector `to`.
pub(crate) fn rotation_between(from: Vec3, to: Vec3) -> Quat {
    let cos = from.dot(to);
    if cos < -0.999_99 {
        let [x, y, z] = from.any_orthonormal_vector().to_array();
        return Quat::from_xyzw(x, y, z, 0.0);
    }
    let axis = from.cross(to);
    Quat::from_xyzw(axis.x, axis.y, axis.z, 1.0 + cos).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_take_the_axes_to_where_they_say() {
        let quarter = TAU / 4.0;
        assert!((turned(quarter) * Vec3::X).abs_diff_eq(Vec3::NEG_Z, 1e-6));
        assert!((rotation(Vec3::X, quarter) * Vec3::Y).abs_diff_eq(Vec3::Z, 1e-6));
        for to in [Vec3::X, Vec3::Z, Vec3::NEG_Y, Vec3::new(0.6, -0.8, 0.0)] {
            assert!((rotation_between(Vec3::Y, to) * Vec3::Y).abs_diff_eq(to, 1e-5), "{to}");
        }
    }

    #[test]
    fn waves_and_steps_have_their_closed_forms() {
        assert!((wave(-0.75) - 1.0).abs() < 1e-6);
        assert_eq!(smoothstep(1.0, 3.0, 2.0), 0.5);
        assert_eq!(smoothstep(1.0, 3.0, 9.0), 1.0);
        assert_eq!(smoothstep(3.0, 1.0, 0.0), 1.0);
    }
}
