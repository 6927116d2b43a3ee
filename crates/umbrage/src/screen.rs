//! Eight bits a channel for screens.

use std::sync::OnceLock;

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use umbrage_rays::{SimdLevel, dispatch};

use crate::develop::levels;
use crate::shade::lanes::Each;

/// Converts linear values to levels of an sRGB-encoded channel, without computing a power for each.
pub(crate) struct Levels {
    /// The least value of each level.
    least: [f32; 256],
    /// The level of the least value whose bits begin with the index's.
    first: Vec<u8>,
}

impl Levels {
    /// Low bits of a value that the index of `first` ignores: it has eight entries for each doubling.
    const SHIFT: u32 = 23 - 3;
    const ONE: u32 = 1.0_f32.to_bits();

    pub(crate) fn get() -> &'static Self {
        static LEVELS: OnceLock<Levels> = OnceLock::new();
        LEVELS.get_or_init(Self::new)
    }

    /// The least value of each level; they ascend from zero.
    #[cfg(feature = "gpu")]
    pub(crate) fn least(&self) -> &[f32; 256] {
        &self.least
    }

    fn new() -> Self {
        let mut least = [0.0; 256];
        for (level, least) in least.iter_mut().enumerate() {
            // Bits of positive numbers are in the numbers' order.
            let (mut below, mut reached) = (0, Self::ONE);
            while below < reached {
                let middle = u32::midpoint(below, reached);
                if usize::from(eight_bits(f32::from_bits(middle))) < level {
                    below = middle + 1;
                } else {
                    reached = middle;
                }
            }
            *least = f32::from_bits(reached);
        }
        let indices = 0..=Self::ONE >> Self::SHIFT;
        let first = indices.map(|index| eight_bits(f32::from_bits(index << Self::SHIFT))).collect();
        Self { least, first }
    }

    /// The level of a value, clamped to [0, 1]; NaN counts as zero.
    #[inline]
    pub(crate) fn level(&self, linear: f32) -> u8 {
        // NaN is not above zero either.
        let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
        let mut level = self.first[(linear.to_bits() >> Self::SHIFT) as usize];
        while level < u8::MAX && linear >= self.least[usize::from(level) + 1] {
            level += 1;
        }
        level
    }
}

/// The level of a linear value in a channel of an eight-bit file.
fn eight_bits(linear: f32) -> u8 {
    let levels: Each<u32> = dispatch!(SimdLevel::default(), simd => levels(simd, f32x16::splat(simd, linear)).into());
    crate::output::eight_bits(levels[0] as u16)
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;
    use crate::{Film, Settings, ToneMap};

    #[test]
    fn levels_are_those_of_files() {
        let levels = Levels::get();
        let steps = 0..=1_000_000;
        let special = [f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE, -0.0, 1.5];
        // The power of a number has an error of a few last bits, so the order of levels is checked near their borders.
        let borders = levels.least.iter().flat_map(|least| {
            (-64..=64).map(|step| f32::from_bits(least.to_bits().saturating_add_signed(step).min(Levels::ONE)))
        });
        for linear in steps.map(|step| step as f32 / 1e6).chain(special).chain(borders) {
            assert_eq!(levels.level(linear), eight_bits(linear.clamp(0.0, 1.0).max(0.0)), "{linear}");
        }
    }

    #[test]
    fn a_screen_shows_what_a_file_holds() {
        let color = (0..3000).map(|pixel| Vec4::splat(pixel as f32 * 7e-4)).collect();
        let film = Film { width: 3000, height: 1, color, ..Film::default() };
        for settings in
            [Settings::default(), Settings { tone_map: ToneMap::Clip, exposure_stops: -0.3, ..Settings::default() }]
        {
            let mut screen = Vec::new();
            film.develop_for_screen(&settings, &mut screen);
            let file = film.develop(&settings).pixels;
            for (&[red, green, blue, alpha], file) in screen.iter().zip(file) {
                assert_eq!([red, green, blue], file.map(crate::output::eight_bits));
                assert_eq!(alpha, u8::MAX);
            }
        }
    }
}
