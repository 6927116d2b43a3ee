//! Origins of scenes that are far from the origin of their files' coordinates.

use glam::{DVec3, Vec3};

/// The box around the points of a scene, as long as they are far from the origin of their coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarBounds {
    min: DVec3,
    max: DVec3,
}

impl Default for FarBounds {
    fn default() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }
}

impl FarBounds {
    /// The largest coordinate of scenes that keep the origin of their coordinates, in diagonals of the scene. From there on f32
    /// rounds positions by 2⁻¹⁵ of the diagonal and more, a 32nd of a pixel where the diagonal is a thousand.
    const MOST_DIAGONALS: f64 = 512.0;

    /// Adds a point, unless it isn't finite in f32, and returns whether all points so far are far. Nearly all scenes turn
    /// out not to be far within their first few points.
    pub(crate) fn add(&mut self, point: DVec3) -> bool {
        if point.as_vec3().is_finite() {
            (self.min, self.max) = (self.min.min(point), self.max.max(point));
        }
        self.are_far()
    }

    fn are_far(&self) -> bool {
        let largest = self.min.abs().max(self.max.abs()).max_element();
        largest > Self::MOST_DIAGONALS * (self.max - self.min).length() || self.min.x > self.max.x
    }

    /// The origin of a scene with these points: their middle, in whole numbers, or in halves, quarters and so on of scenes
    /// smaller than 1. Zero for scenes that aren't far.
    pub(crate) fn origin(&self) -> DVec3 {
        if self.min.x > self.max.x || !self.are_far() {
            return DVec3::ZERO;
        }
        let diagonal = (self.max - self.min).length();
        let step = if 0.0 < diagonal && diagonal < 1.0 { power_of_two_below(diagonal) } else { 1.0 };
        (((self.min + self.max) * (0.5 / step)).round() * step).map(|axis| axis + 0.0)
    }

    /// The origin of a scene with these points.
    pub(crate) fn origin_of(points: impl IntoIterator<Item = DVec3>) -> DVec3 {
        let mut bounds = Self::default();
        if points.into_iter().all(|point| bounds.add(point)) { bounds.origin() } else { DVec3::ZERO }
    }
}

/// The largest power of two that isn't above a positive number, or that f32 holds.
fn power_of_two_below(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7FF << 52;
    f64::from_bits(number.to_bits() & EXPONENT).max(f64::from(f32::MIN_POSITIVE))
}

/// A point of the world, from a scene's origin.
pub(crate) fn local(world: DVec3, origin: DVec3) -> Vec3 {
    (world - origin).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(points: &[[f64; 3]]) -> [f64; 3] {
        FarBounds::origin_of(points.iter().copied().map(DVec3::from)).into()
    }

    #[test]
    fn origins_are_whole_numbers_or_powers_of_two_in_the_middle_of_far_scenes() {
        assert_eq!(origin(&[[1e6, -3e6, 0.25], [1e6 + 3.0, -3e6 + 1.0, 0.5]]), [1_000_002.0, -3e6, 0.0]);
        assert_eq!(origin(&[[7.0, 0.0, 0.0], [7.0, 0.006, 0.008]]), [7.0, 0.0, 0.0078125]);
        assert_eq!(origin(&[[2.5, f64::NAN, 0.0], [1e300, 0.0, 0.0], [3e5, 0.0, 0.0], [3e5, 1.0, 0.0]])[0], 3e5);
    }

    #[test]
    fn near_scenes_keep_their_origin() {
        for points in [&[][..], &[[511.0, 0.0, 0.0], [512.0, 0.0, 0.0]], &[[1e6, 0.0, 0.0], [1e6, 0.0, 1.0], [0.0; 3]]]
        {
            assert_eq!(origin(points), [0.0; 3]);
        }
        assert_ne!(origin(&[[512.0, 0.0, 0.0], [513.0, 0.0, 0.0]]), [0.0; 3]);
    }
}
