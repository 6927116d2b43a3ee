use glam::Vec3;

use crate::kdtree::extent::{Extent, Plane};

/// The coordinates of packets: their origin is the middle of the tree's bounds, and their unit a power of two, so that
/// the tree reaches from −1 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The point that becomes zero.
    pub middle: [f32; 3],
    /// The power of two that differences are multiplied with.
    pub unit: f32,
}

impl Scale {
    /// The coordinates for a tree's bounds, which aren't empty.
    pub fn of(extent: &Extent) -> Self {
        let middle: [f32; 3] =
            std::array::from_fn(|axis| (0.5 * (f64::from(extent.min[axis]) + f64::from(extent.max[axis]))) as f32);
        let half = (0..3).fold(f64::MIN_POSITIVE, |half, axis| {
            let middle = f64::from(middle[axis]);
            half.max(f64::from(extent.max[axis]) - middle).max(middle - f64::from(extent.min[axis]))
        });
        // The power of two below its inverse. The smallest, 2⁻¹²⁸, is a subnormal f32, but exact.
        let exponent = -(((half.to_bits() >> 52) as i32) - 1023) - 1;
        Self { middle, unit: power_of_two(exponent.clamp(-128, 127)) }
    }

    /// A coordinate: one rounding, relative to the result.
    #[inline(always)]
    pub fn coordinate(&self, at: f32, axis: usize) -> f32 {
        (at - self.middle[axis]) * self.unit
    }

    /// Returns the coordinate of a plane.
    #[inline(always)]
    pub fn plane(&self, plane: Plane) -> f32 {
        self.coordinate(plane.at, plane.axis)
    }

    /// Returns the coordinates of a point.
    #[inline(always)]
    pub fn point(&self, point: Vec3) -> [f32; 3] {
        let [x, y, z] = self.middle;
        ((point - Vec3::new(x, y, z)) * self.unit).to_array()
    }

    /// A difference of points: one rounding, relative to the result.
    #[inline(always)]
    pub(super) fn difference(&self, from: Vec3, to: Vec3) -> [f32; 3] {
        ((to - from) * self.unit).to_array()
    }
}

fn power_of_two(exponent: i32) -> f32 {
    if exponent < -126 {
        f32::from_bits(1 << (exponent + 149))
    } else {
        f32::from_bits(((exponent + 127) as u32) << 23)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_from_minus_one_to_one_and_little_is_given_away() {
        for (low, high) in [(-1.0, 1.0), (0.0, 3.0), (1e8, 1.1e8), (f32::MIN, f32::MAX), (1e-38, 1e-30), (5.0, 5.0)] {
            let scale = Scale::of(&Extent { min: [low; 3], max: [high; 3] });
            let [low, high] = [low, high].map(|at| scale.coordinate(at, 1));
            assert!((-1.0..=1.0).contains(&low) && (-1.0..=1.0).contains(&high), "{low} {high} {scale:?}");
            assert!(high - low > 0.5 || high == low, "{low} {high} {scale:?}");
        }
    }
}
