//! Develops films to pictures, sixteen pixels at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::{SimdLevel, dispatch};

use crate::screen::Levels;
use crate::shade::lanes::{Each, LANES, Vectors, put};
use crate::tone_map::encoded_srgb;
use crate::{Background, Film, Image, Settings, ToneMap};

/// Pixels for each piece of work.
const PIXELS: usize = 1 << 12;

impl Film {
    /// Tone maps and encodes the film for a screen.
    #[must_use]
    pub fn develop(&self, settings: &Settings) -> Image {
        self.develop_sum(settings, 1)
    }

    /// As [`Film::develop`], for pixels that are still sums of `samples` samples.
    pub(crate) fn develop_sum(&self, settings: &Settings, samples: u32) -> Image {
        let (developer, level) = (Developer::new(settings, samples), SimdLevel::default());
        let Self { width, height, ref color, .. } = *self;
        let mut pixels = vec![[0; 3]; color.len()];
        let mut alpha = vec![0; if developer.covers { color.len() } else { 0 }];
        let planes = pixels.par_chunks_mut(PIXELS).zip(color.par_chunks(PIXELS)).enumerate();
        if developer.covers {
            planes.zip(alpha.par_chunks_mut(PIXELS)).each(|((number, (pixels, color)), alpha)| {
                let film = (color, self.flat_of(number));
                dispatch!(level, simd => developer.encode(simd, film, pixels, alpha));
            });
        } else {
            planes.each(|(number, (pixels, color))| {
                let film = (color, self.flat_of(number));
                dispatch!(level, simd => developer.encode(simd, film, pixels, &mut []));
            });
        }
        Image { width, height, pixels, alpha }
    }

    /// As [`Film::develop`], as opaque rows of RGB with eight bits a channel, in the memory of an earlier picture.
    pub(crate) fn develop_rows(&self, settings: &Settings, rows: &mut Vec<u8>) {
        let (developer, level) = (Developer::new(settings, 1), SimdLevel::default());
        rows.resize(3 * self.color.len(), 0);
        let planes = rows.par_chunks_mut(3 * PIXELS).zip(self.color.par_chunks(PIXELS)).enumerate();
        planes.each(|(number, (rows, color))| {
            let film = (color, self.flat_of(number));
            dispatch!(level, simd => developer.encode_rows(simd, film, rows));
        });
    }

    /// As [`Film::develop`], with eight bits a channel and as opaque RGBA, in the memory of an earlier picture. The levels
    /// are the same as those of `develop` in an eight-bit file.
    pub fn develop_for_screen(&self, settings: &Settings, pixels: &mut Vec<[u8; 4]>) {
        let (developer, level, levels) = (Developer::new(settings, 1), SimdLevel::default(), Levels::get());
        pixels.resize(self.color.len(), [u8::MAX; 4]);
        let planes = pixels.par_chunks_mut(PIXELS).zip(self.color.par_chunks(PIXELS)).enumerate();
        planes.each(|(number, (pixels, color))| {
            let flat = self.flat_of(number);
            for (number, (pixels, color)) in pixels.chunks_mut(LANES).zip(color.chunks(LANES)).enumerate() {
                let flat = flat.chunks(LANES).nth(number).unwrap_or(&[]);
                let shown = dispatch!(level, simd => developer.shown(simd, color, flat, &[1.0; LANES]).store());
                for (lane, pixel) in pixels.iter_mut().enumerate() {
                    let [red, green, blue] = shown.each_ref().map(|channel| levels.level(channel[lane]));
                    *pixel = [red, green, blue, u8::MAX];
                }
            }
        });
    }

    /// The flat part of a piece of work's pixels; empty if the film has none.
    fn flat_of(&self, number: usize) -> &[Vec4] {
        self.flat.chunks(PIXELS).nth(number).unwrap_or(&[])
    }
}

/// The parameters of developing.
#[derive(Clone, Copy)]
pub(crate) struct Developer {
    /// Factor from the film's sums to means.
    weight: f32,
    exposure: f32,
    tone_map: ToneMap,
    /// Whether pictures have an alpha channel.
    covers: bool,
}

impl Developer {
    pub(crate) fn new(settings: &Settings, samples: u32) -> Self {
        let Settings { exposure_stops, tone_map, ref background, .. } = *settings;
        let covers = *background == Background::Transparent;
        Self { weight: 1.0 / samples as f32, exposure: libm::exp2f(exposure_stops), tone_map, covers }
    }

    /// Display colours of up to sixteen pixels with these coverages, linear and in [0, 1].
    #[inline(always)]
    fn shown<S: Simd>(&self, simd: S, color: &[Vec4], flat: &[Vec4], coverage: &Each<f32>) -> Vectors<S> {
        let exposure = f32x16::splat(simd, self.exposure);
        if flat.is_empty() {
            if !self.covers
                && let Ok(color) = color.try_into()
            {
                let radiance = Vectors::of_first_three(simd, color).scaled(f32x16::splat(simd, self.weight));
                return self.tone_map.apply(simd, radiance.scaled(exposure));
            }
            let mut radiance = [[0.0; LANES]; 3];
            for (lane, color) in color.iter().enumerate() {
                put(lane, of_part(color.truncate() * self.weight, coverage[lane]), &mut radiance);
            }
            return self.tone_map.apply(simd, Vectors::load(simd, &radiance).scaled(exposure));
        }
        let (mut radiance, mut as_it_is) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let mut part = [0.0; LANES];
        for (lane, (color, flat)) in color.iter().zip(flat).enumerate() {
            let (color, flat, coverage) = (*color * self.weight, *flat * self.weight, coverage[lane]);
            let rest = coverage - flat.w;
            // Where all of it is flat, other light counts for the whole coverage.
            let rest = if rest < LEAST_REST { coverage } else { rest };
            put(lane, of_part((color - flat).truncate(), rest), &mut radiance);
            put(lane, of_part(flat.truncate(), coverage), &mut as_it_is);
            part[lane] = if coverage > 0.0 { rest / coverage } else { 0.0 };
        }
        let mapped = self.tone_map.apply(simd, Vectors::load(simd, &radiance).scaled(exposure));
        (mapped.scaled(f32x16::from_slice(simd, &part)) + Vectors::load(simd, &as_it_is)).at_least_zero().at_most_one()
    }

    /// Develops some pixels with their flat parts; to opaque ones where there is no `alpha`.
    #[inline(always)]
    fn encode<S: Simd>(&self, simd: S, (color, flat): (&[Vec4], &[Vec4]), pixels: &mut [[u16; 3]], alpha: &mut [u16]) {
        for (number, (pixels, color)) in pixels.chunks_mut(LANES).zip(color.chunks(LANES)).enumerate() {
            let flat = flat.chunks(LANES).nth(number).unwrap_or(&[]);
            let alpha = alpha.chunks_mut(LANES).nth(number);
            let coverage = alpha.map_or([1.0; LANES], |alpha| coverage(color, alpha));
            let Vectors { x, y, z } = self.shown(simd, color, flat, &coverage);
            let (red, green, blue) = (levels(simd, x), levels(simd, y), levels(simd, z));
            let (red_and_green, blue): (Each<u32>, Each<u32>) = ((red | green << 16).into(), blue.into());
            // Four channels are stored at once; the next pixel replaces the fourth.
            let channels = pixels.as_flattened_mut();
            for lane in 0..channels.len() / 3 {
                let pixel = [red_and_green[lane] as u16, (red_and_green[lane] >> 16) as u16, blue[lane] as u16, 0];
                let stored = &mut channels[3 * lane..];
                match stored.first_chunk_mut() {
                    Some(four) => *four = pixel,
                    None => stored.copy_from_slice(&pixel[..3]),
                }
            }
        }
    }

    /// Develops some pixels with their flat parts to opaque RGB.
    #[inline(always)]
    pub(crate) fn encode_rows<S: Simd>(&self, simd: S, (color, flat): (&[Vec4], &[Vec4]), rows: &mut [u8]) {
        for (number, (row, color)) in rows.chunks_mut(3 * LANES).zip(color.chunks(LANES)).enumerate() {
            let flat = flat.chunks(LANES).nth(number).unwrap_or(&[]);
            let Vectors { x, y, z } = self.shown(simd, color, flat, &[1.0; LANES]);
            let (red, green, blue) =
                (eight_bits(levels(simd, x)), eight_bits(levels(simd, y)), eight_bits(levels(simd, z)));
            let pixels: Each<u32> = (red | green << 8 | blue << 16).into();
            for (lane, pixel) in pixels.iter().take(color.len()).enumerate() {
                let pixel = pixel.to_le_bytes();
                let stored = &mut row[3 * lane..];
                // Four channels are stored at once; the next pixel replaces the fourth.
                match stored.first_chunk_mut() {
                    Some(four) => *four = pixel,
                    None => stored.copy_from_slice(&pixel[..3]),
                }
            }
        }
    }
}

/// Least part of a pixel that counts as not flat.
const LEAST_REST: f32 = 1.0 / 1024.0;

/// The colour of a part of a pixel, from its contribution to the pixel.
fn of_part(color: Vec3, part: f32) -> Vec3 {
    match part {
        // Most parts are whole, and divisions slow.
        1.0 => color,
        part if part > 0.0 => color / part,
        _ => Vec3::ZERO,
    }
}

/// Linear values in [0, 1] as levels of an sRGB-encoded channel with sixteen bits.
#[inline(always)]
pub(crate) fn levels<S: Simd>(simd: S, linear: f32x16<S>) -> u32x16<S> {
    (encoded_srgb(simd, linear) * f32::from(u16::MAX) + 0.5).to_int()
}

/// The nearest of 256 levels, as [`output::eight_bits`](crate::output::eight_bits).
#[inline(always)]
fn eight_bits<S: Simd>(levels: u32x16<S>) -> u32x16<S> {
    // A division by 65,535, exact below its square.
    let numerator = levels * 255 + 32_767;
    (numerator + (numerator >> 16) + 1) >> 16
}

/// The coverage of some pixels, 0 to 1, by which their sums are divided; writes the `alpha` levels.
fn coverage(color: &[Vec4], alpha: &mut [u16]) -> Each<f32> {
    let mut coverage = [0.0; LANES];
    for (coverage, (color, alpha)) in coverage.iter_mut().zip(color.iter().zip(alpha)) {
        // Reflections of the sky on thin surfaces may add up to more than one.
        let part = color.w.clamp(0.0, 1.0);
        *alpha = (part * f32::from(u16::MAX)).round() as u16;
        // A pixel whose alpha level is zero has no colour.
        *coverage = if *alpha == 0 { 0.0 } else { part };
    }
    coverage
}

#[cfg(test)]
mod tests {
    use super::*;

    fn developed(color: Vec4, settings: &Settings) -> [u16; 3] {
        let film = Film { width: 1, height: 1, color: vec![color], ..Film::default() };
        film.develop(settings).pixels[0]
    }

    #[test]
    fn known_values_are_encoded_as_srgb() {
        let clip = Settings { tone_map: ToneMap::Clip, ..Settings::default() };
        let truth = |linear: f64| {
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
        };
        for step in 0..=10_000 {
            let linear = step as f32 / 10_000.0;
            let levels = developed(Vec4::new(linear, 0.0, 1.0, 1.0), &clip);
            let expected = truth(f64::from(linear)) * 65_535.0;
            assert!((f64::from(levels[0]) - expected).abs() < 0.53, "{linear}: {levels:?} for {expected}");
            assert_eq!(levels[1..], [0, u16::MAX]);
        }
    }

    #[test]
    fn a_stop_doubles_and_what_is_no_number_is_black() {
        let clip = Settings { tone_map: ToneMap::Clip, ..Settings::default() };
        let stop = Settings { exposure_stops: 1.0, ..clip.clone() };
        assert_eq!(developed(Vec4::splat(0.2), &stop), developed(Vec4::splat(0.4), &clip));
        for settings in [clip, Settings::default()] {
            assert_eq!(developed(Vec4::NAN, &settings), [0; 3]);
            assert_eq!(developed(Vec4::splat(-1.0), &settings), [0; 3]);
            assert!(developed(Vec4::INFINITY, &Settings { tone_map: ToneMap::Clip, ..settings })[0] == u16::MAX);
        }
    }

    #[test]
    fn every_pixel_of_a_film_is_developed_whatever_the_instructions() {
        // Not a multiple of sixteen, and more than one piece of work.
        let count = 2 * PIXELS + 21;
        let color: Vec<Vec4> = (0..count).map(|pixel| Vec4::new(pixel as f32 * 1e-4, 0.3, 0.7, 0.5)).collect();
        for settings in [Settings::default(), Settings { background: Background::Transparent, ..Settings::default() }] {
            let film = Film { width: count as u32, height: 1, color: color.clone(), ..Film::default() };
            let image = film.develop(&settings);
            if image.alpha.is_empty() {
                let mut rows = vec![7; 5];
                film.develop_rows(&settings, &mut rows);
                let expected = image.pixels.as_flattened().iter().map(|&level| crate::output::eight_bits(level));
                assert!(rows.iter().copied().eq(expected));
            }
            for (number, &color) in color.iter().enumerate() {
                let alone = Film { width: 1, height: 1, color: vec![color], ..Film::default() }.develop(&settings);
                assert_eq!(image.pixels[number], alone.pixels[0]);
                assert_eq!(image.alpha.get(number), alone.alpha.first());
            }
        }
        for level in 0..=u16::MAX {
            let fast: Each<u32> = dispatch!(SimdLevel::default(), simd => {
                eight_bits(u32x16::splat(simd, level.into())).into()
            });
            assert_eq!(fast, [u32::from(crate::output::eight_bits(level)); LANES], "{level}");
        }
        for level in SimdLevel::available() {
            let linear: Each<f32> = std::array::from_fn(|lane| lane as f32 * 0.061);
            let levels_at = |level| -> Each<u32> {
                dispatch!(level, simd => levels(simd, f32x16::from_slice(simd, &linear)).into())
            };
            assert_eq!(levels_at(level), levels_at(SimdLevel::default()));
        }
    }
}
