//! Smooth random functions of space.

use glam::Vec3;

use super::random::{hash, unit};

/// A smooth random function, from −1 to 1, whose bumps are about one unit wide (value noise, quintic fade).
pub(crate) fn noise(at: Vec3) -> f32 {
    let [x, y, z] = at.to_array().map(floor);
    let part = at - Vec3::new(x as f32, y as f32, z as f32);
    let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let value = |dx: i32, dy: i32, dz: i32| unit(hash(x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz)));
    let along_x = |dy: i32, dz: i32| {
        let low = value(0, dy, dz);
        low + (value(1, dy, dz) - low) * fade.x
    };
    let along_y = |dz: i32| {
        let low = along_x(0, dz);
        low + (along_x(1, dz) - low) * fade.y
    };
    let low = along_y(0);
    2.0 * (low + (along_y(1) - low) * fade.z) - 1.0
}

/// The greatest whole number not above `number`. Three times as fast as `f32::floor`, which is a call on the oldest
/// x86-64 machines.
fn floor(number: f32) -> i32 {
    let truncated = number as i32;
    truncated.wrapping_sub(i32::from(truncated as f32 > number))
}

/// The sum of `octaves` noises, each twice as fine and half as strong as the last; about −1 … 1.
pub(crate) fn fractal_noise(at: Vec3, octaves: u32) -> f32 {
    let (mut sum, mut strength, mut at) = (0.0, 0.5, at);
    for _ in 0..octaves {
        sum += strength * noise(at);
        strength *= 0.5;
        // The offset keeps the octaves' lattices apart: shared points would show as a grid.
        at = at * 2.0 + Vec3::new(17.3, 5.1, 31.7);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_bounded_and_alive() {
        let points = (0..2000).map(|i| Vec3::new(i as f32 * 0.37, i as f32 * -0.11, 3.3));
        let (mut low, mut high) = (0.0_f32, 0.0_f32);
        for at in points {
            let value = noise(at);
            assert!((value - noise(at + Vec3::splat(1e-3))).abs() < 0.02, "a jump at {at}");
            (low, high) = (low.min(value), high.max(value));
        }
        assert!((-1.0..-0.5).contains(&low) && (0.5..=1.0).contains(&high), "{low} … {high}");
    }
}
