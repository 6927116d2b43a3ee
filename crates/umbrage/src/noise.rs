//! The remaining noise of a picture.

use std::f64::consts::FRAC_1_SQRT_2;

use rayon::prelude::*;

use crate::{Background, Film, Image, Settings};

/// Compares a film with its last state whenever its samples have doubled.
#[derive(Debug, Default)]
pub(crate) struct NoiseMeter {
    /// The picture with half as many samples.
    last: Option<Image>,
    /// Its difference, in levels, from the picture with a quarter as many samples.
    last_levels: Option<f64>,
}

impl NoiseMeter {
    /// Fewer samples than this may miss details that only few of them see.
    pub(crate) const LEAST_SAMPLES: u32 = 16;

    /// Whether it compares a film of `samples` samples.
    pub(crate) fn looks_at(samples: u32, settings: &Settings) -> bool {
        settings.noise > 0.0 && samples.is_power_of_two() && samples >= Self::LEAST_SAMPLES / 4
    }

    /// Whether the noise of a film, the sum of `samples` samples, is at most the settings' [`noise`](Settings::noise).
    ///
    /// Where samples are drawn independently, the difference between a pixel's mean of n and that of the first half of them
    /// has the variance of the whole mean: (a + b) / 2 − a is half of b − a, and a and b have twice its variance each.
    /// Samples that are spread evenly have less noise than that. But all pixels have the same points of the lens, the time
    /// and the lights, so that both halves of these may agree by chance: the doubling before has to be as good, for its
    /// number of samples.
    pub(crate) fn is_even(&mut self, film: &Film, samples: u32, settings: &Settings) -> bool {
        if !Self::looks_at(samples, settings) {
            return false;
        }
        let opaque = Settings { background: Background::Sky, ..settings.clone() };
        let shown = film.develop_sum(&opaque, samples);
        let levels = self.last.as_ref().map(|last| difference(last, &shown));
        self.last = Some(shown);
        let last_levels = std::mem::replace(&mut self.last_levels, levels);
        match (levels, last_levels) {
            (Some(levels), Some(last)) => levels.max(last * FRAC_1_SQRT_2) <= f64::from(settings.noise),
            _ => false,
        }
    }
}

/// The root of the mean squared difference of two pictures of one size, in levels of 255.
fn difference(one: &Image, other: &Image) -> f64 {
    let squares = one.pixels.par_iter().zip(&other.pixels).map(|(one, other)| {
        let differences = one.iter().zip(other).map(|(&one, &other)| u64::from(one.abs_diff(other)));
        differences.map(|difference| difference * difference).sum::<u64>()
    });
    let count = 3 * one.pixels.len().max(1);
    (squares.sum::<u64>() as f64 / count as f64).sqrt() / 257.0
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};

    use super::*;
    use crate::ToneMap;

    #[test]
    fn noise_is_the_standard_error_of_the_mean() {
        // Pixels around half of the screen's white, with a deviation of about 20 levels each sample.
        let pixels = 20_000;
        let settings = |noise: f32| Settings { noise, tone_map: ToneMap::Clip, ..Settings::default() };
        for (noise, expected) in [(6.0, 16), (2.7, 64), (0.1, 1024)] {
            let mut film =
                Film { width: pixels, height: 1, color: vec![Vec4::ZERO; pixels as usize], ..Film::default() };
            let (mut meter, mut state) = (NoiseMeter::default(), 1_u32);
            let mut random = || {
                state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                (state >> 8) as f32 / (1 << 24) as f32
            };
            let mut samples = 0;
            while samples < 1024 {
                film.color
                    .iter_mut()
                    .for_each(|sum| *sum += Vec3::splat(0.2 + 0.12 * (random() - 0.5) * 2.0).extend(1.0));
                samples += 1;
                if meter.is_even(&film, samples, &settings(noise)) {
                    break;
                }
            }
            assert_eq!(samples, expected, "noise of {noise} levels");
        }
    }
}
