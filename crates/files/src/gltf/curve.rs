//! Keyframes and their interpolation.

use glam::{Quat, Vec4};

/// Values over time, one or more numbers at each keyframe.
#[derive(Debug)]
pub(super) struct Curve {
    /// Time of each keyframe in seconds; at least one, finite, never falling.
    pub(super) times: Vec<f32>,
    /// `width` numbers per keyframe. For [`Interpolation::CubicSpline`] three times as many: in-tangent, value, out-tangent.
    pub(super) values: Vec<f32>,
    /// Number of components of a value, at least 1.
    pub(super) width: usize,
    pub(super) interpolation: Interpolation,
}

/// Interpolation between keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// The value of the previous keyframe.
    Step,
    /// Linear, component by component.
    Linear,
    /// Spherical, for rotations: at constant speed along the shorter arc.
    Spherical,
    /// A Hermite spline, component by component.
    CubicSpline,
}

impl Curve {
    /// Writes the value at `seconds` to `value`, which has length `width`. Times are clamped to the first and last keyframe.
    pub(super) fn sample(&self, seconds: f64, value: &mut [f32]) {
        let after = self.times.partition_point(|&time| f64::from(time) <= seconds);
        if after == 0 || after == self.times.len() || self.interpolation == Interpolation::Step {
            value.copy_from_slice(self.value(after.saturating_sub(1)));
            return;
        }
        let before = after - 1;
        let (start, end) = (f64::from(self.times[before]), f64::from(self.times[after]));
        let part = ((seconds - start) / (end - start)) as f32;
        let (from, to) = (self.value(before), self.value(after));
        match self.interpolation {
            Interpolation::Spherical => slerp(from, to, part, value),
            Interpolation::CubicSpline => {
                let leaving = self.numbers(before, 2);
                let arriving = self.numbers(after, 0);
                let weights = hermite(part, (end - start) as f32);
                for (at, value) in value.iter_mut().enumerate() {
                    *value = weights.dot(Vec4::new(from[at], leaving[at], to[at], arriving[at]));
                }
            }
            Interpolation::Linear | Interpolation::Step => {
                for (at, value) in value.iter_mut().enumerate() {
                    *value = from[at] * (1.0 - part) + to[at] * part;
                }
            }
        }
    }

    /// The time of the last keyframe.
    pub(super) fn end_seconds(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The value at a keyframe.
    pub(super) fn value(&self, keyframe: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::CubicSpline => self.numbers(keyframe, 1),
            _ => &self.values[keyframe * self.width..][..self.width],
        }
    }

    /// One of a spline's three sets of numbers at a keyframe.
    fn numbers(&self, keyframe: usize, set: usize) -> &[f32] {
        &self.values[(3 * keyframe + set) * self.width..][..self.width]
    }
}

/// Hermite weights of the first value, its tangent, the last value and its tangent, for tangents per second and an interval
/// of `seconds` (glTF specification, §C.5).
fn hermite(part: f32, seconds: f32) -> Vec4 {
    let (square, cube) = (part * part, part * part * part);
    Vec4::new(
        2.0 * cube - 3.0 * square + 1.0,
        seconds * (cube - 2.0 * square + part),
        3.0 * square - 2.0 * cube,
        seconds * (cube - square),
    )
}

/// Interpolates two unit quaternions along the shorter arc (glTF specification, §C.4).
fn slerp(from: &[f32], to: &[f32], part: f32, value: &mut [f32]) {
    let (from, to) = (Quat::from_slice(from), Quat::from_slice(to));
    let cosine = from.dot(to);
    let to = if cosine < 0.0 { -to } else { to };
    let cosine = cosine.abs();
    // Below 2°, where the sines lose digits, a straight line differs by less than one in a million.
    const ALMOST_PARALLEL: f32 = 0.9998;
    let mixed = if cosine > ALMOST_PARALLEL {
        from * (1.0 - part) + to * part
    } else {
        let angle = libm::acosf(cosine);
        (from * libm::sinf((1.0 - part) * angle) + to * libm::sinf(part * angle)) / libm::sinf(angle)
    };
    value.copy_from_slice(&mixed.to_array());
}
