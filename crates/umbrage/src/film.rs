use std::collections::TryReserveError;

use glam::{Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::SeenPixels;

use crate::{Background, Error, Settings};

/// What a render gathered for each pixel, in rows from the upper left corner.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean linear radiance (Rec. 709 primaries), and how much of the pixel is covered by the scene. Always finite:
    /// radiance that is above 10³⁰, or would overflow on its way, is 10³⁰.
    pub color: Vec<Vec4>,
    /// Depth along the camera's forward axis at the pixel's first sample, in world units; infinite for a miss.
    pub depth: Vec<f32>,
    /// World-space shading normal at the first sample; zero for a miss.
    pub normal: Vec<Vec3>,
    /// Id of the triangle at the first sample; [`Film::NO_TRIANGLE`] for a miss.
    pub triangle: Vec<u32>,
}

/// A picture for a screen: sRGB-encoded rows of RGB, 16 bits a channel, from the upper left corner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels. Where there is an `alpha`, colours are those of what covers them, however little that is.
    pub pixels: Vec<[u16; 3]>,
    /// How much of each pixel is covered; empty where all of all pixels is.
    pub alpha: Vec<u16>,
}

impl Film {
    /// What [`Film::triangle`] holds where nothing was hit.
    pub const NO_TRIANGLE: u32 = SeenPixels::NONE;

    /// Empties the film, which will have another size.
    ///
    /// # Errors
    /// Where the system hasn't as much memory as the picture will take; the film then stays as it was.
    pub(crate) fn clear(&mut self, [width, height]: [u32; 2]) -> Result<(), Error> {
        let pixels = width as usize * height as usize;
        self.reserve(pixels).map_err(|_| no_memory([width, height]))?;
        (self.width, self.height) = (width, height);
        refill(&mut self.color, pixels, Vec4::ZERO);
        refill(&mut self.depth, pixels, f32::INFINITY);
        refill(&mut self.normal, pixels, Vec3::ZERO);
        refill(&mut self.triangle, pixels, Self::NO_TRIANGLE);
        Ok(())
    }

    /// Makes room for more pixels than there were, and sees that there is as much again for what is made of them: nobody
    /// who makes that can say that it failed.
    fn reserve(&mut self, pixels: usize) -> Result<(), TryReserveError> {
        let more = pixels.saturating_sub(self.color.len());
        if more == 0 {
            return Ok(());
        }
        self.color.try_reserve_exact(more)?;
        self.depth.try_reserve_exact(more)?;
        self.normal.try_reserve_exact(more)?;
        self.triangle.try_reserve_exact(more)?;
        let beside = Settings::BYTES_OF_PIXEL - (size_of::<(Vec4, f32, u32)>() + size_of::<Vec3>());
        Vec::<u8>::new().try_reserve_exact(beside.saturating_mul(more))
    }

    /// Sees that there is memory for what is found out about the pixels of a picture without a film.
    ///
    /// # Errors
    /// Where there isn't.
    pub(crate) fn check_memory_without([width, height]: [u32; 2]) -> Result<(), Error> {
        let bytes = Settings::BYTES_OF_PIXEL * width as usize * height as usize;
        Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| no_memory([width, height]))
    }

    /// A sum of samples, as bright as can be and opaque where it has overflowed.
    #[cfg(feature = "gpu")]
    pub(crate) fn bounded(sum: Vec4) -> Vec4 {
        if sum.is_finite() { sum } else { Vec3::splat(crate::shade::lanes::BRIGHTEST).extend(1.0) }
    }

    /// Turns sums over the samples into means.
    pub(crate) fn average(&mut self, samples: u32) {
        if samples == 1 {
            return;
        }
        let weight = 1.0 / samples as f32;
        self.color.par_iter_mut().for_each(|color| *color *= weight);
    }

    /// Tone maps and encodes the film for a screen.
    #[must_use]
    pub fn develop(&self, settings: &Settings) -> Image {
        let exposure = settings.exposure_stops.exp2();
        let level = |part: f32| (part * f32::from(u16::MAX)).round() as u16;
        let encode = |radiance: Vec3| {
            settings.tone_map.apply(radiance * exposure).to_array().map(|linear| level(encoded_srgb(linear)))
        };
        let Self { width, height, ref color, .. } = *self;
        if settings.background != Background::Transparent {
            let pixels = color.par_iter().map(|color| encode(color.truncate())).collect();
            return Image { width, height, pixels, alpha: Vec::new() };
        }
        let covering = |color: &Vec4| {
            // What covers so little that its level is zero has no colour, and what mirrors the sky in thin air is no more than
            // whole.
            let coverage = color.w.clamp(0.0, 1.0);
            let alpha = level(coverage);
            if alpha == 0 { ([0; 3], 0) } else { (encode(color.truncate() / coverage), alpha) }
        };
        let (pixels, alpha) = color.par_iter().map(covering).unzip();
        Image { width, height, pixels, alpha }
    }

    /// Bytes held for the pixels.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.color.as_slice())
            + size_of_val(self.depth.as_slice())
            + size_of_val(self.normal.as_slice())
            + size_of_val(self.triangle.as_slice())
    }
}

fn no_memory([width, height]: [u32; 2]) -> Error {
    let settings = Settings { width, height, ..Settings::default() };
    Error::PictureMemory { width, height, megabytes: settings.picture_bytes().div_ceil(1_000_000) }
}

fn refill<T: Copy + Send + Sync>(values: &mut Vec<T>, count: usize, value: T) {
    values.resize(count, value);
    values.par_chunks_mut(1 << 16).for_each(|values| values.fill(value));
}

/// The sRGB transfer function (IEC 61966-2-1), from [0, 1] to [0, 1]; what lies outside is cut off, NaN becomes zero.
pub(crate) fn encoded_srgb(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ToneMap;

    fn developed(color: Vec4, settings: &Settings) -> [u16; 3] {
        let film = Film { width: 1, height: 1, color: vec![color], ..Film::default() };
        film.develop(settings).pixels[0]
    }

    #[test]
    fn known_values_are_encoded_as_srgb() {
        let clip = Settings { tone_map: ToneMap::Clip, ..Settings::default() };
        // 0.2140 linear is the middle of the encoded scale.
        let [red, green, blue] = developed(Vec4::new(0.0, 0.214_041, 1.0, 1.0), &clip);
        assert_eq!((red, blue), (0, u16::MAX));
        assert!(green.abs_diff(u16::MAX / 2) < 4, "{green}");
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
}
