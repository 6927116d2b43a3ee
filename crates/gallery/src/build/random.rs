//! Random numbers that are the same everywhere: PCG (O'Neill 2014), hashes of lattice points, and smooth random functions.

use std::f32::consts::TAU;

use glam::Vec3;

use super::math::sin_cos;

/// A stream of random numbers (PCG-XSH-RR, 64 bits of state and 32 of output).
#[derive(Clone, Debug)]
pub(crate) struct Random {
    state: u64,
}

impl Random {
    const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
    const INCREMENT: u64 = 1_442_695_040_888_963_407;

    /// The stream that `seed` starts. Neighbouring seeds give unrelated streams.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self { state: 0 };
        random.next();
        random.state = random.state.wrapping_add(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        random.next();
        random.next();
        random
    }

    /// 32 random bits.
    pub(crate) fn next(&mut self) -> u32 {
        let state = self.state;
        self.state = state.wrapping_mul(Self::MULTIPLIER).wrapping_add(Self::INCREMENT);
        let mixed = (((state >> 18) ^ state) >> 27) as u32;
        mixed.rotate_right((state >> 59) as u32)
    }

    /// A number from 0 up to but not including 1.
    pub(crate) fn unit(&mut self) -> f32 {
        unit(self.next())
    }

    /// A number from `low` up to `high`.
    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A whole number below `count`, which is above zero.
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(count)) >> 32) as u32
    }

    /// A unit vector, all directions being equally likely.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let y = self.range(-1.0, 1.0);
        let (sin, cos) = sin_cos(self.range(0.0, TAU));
        let across = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(across * cos, y, across * sin)
    }
}

/// 32 bits that depend on a lattice point alone.
pub(crate) fn hash(x: i32, y: i32, z: i32) -> u32 {
    let mixed = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f);
    let mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x7feb_352d);
    let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x846c_a68b);
    mixed ^ (mixed >> 16)
}

/// A number from 0 up to but not including 1, from 32 random bits.
pub(crate) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

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
    fn numbers_are_spread_evenly() {
        let mut random = Random::new(7);
        let mut bins = [0_u32; 10];
        for _ in 0..10_000 {
            bins[(random.unit() * 10.0) as usize] += 1;
        }
        assert!(bins.iter().all(|&count| (850..1150).contains(&count)), "{bins:?}");
        let mean = (0..10_000).map(|_| random.direction()).sum::<Vec3>() / 10_000.0;
        assert!(mean.length() < 0.03, "{mean}");
        assert!((0..1000).all(|_| random.below(3) < 3));
    }

    #[test]
    fn neighbouring_seeds_and_places_are_unrelated() {
        assert_ne!(Random::new(1).next(), Random::new(2).next());
        let mean = (0..1000).map(|x| unit(hash(x, 5, -x))).sum::<f32>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
    }

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
