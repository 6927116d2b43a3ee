mod coverage;
mod layers;
mod meter;

use std::collections::TryReserveError;

use glam::{Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::{SeenPixels, View};

pub use coverage::{Coverage, Covered};
pub use layers::{FilmLayers, LightLayer};

use crate::engine::Staged;
use crate::{Error, Settings};

/// A rendered frame: linear values for each pixel, in rows from the upper left corner.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean linear radiance (Rec. 709 primaries), and the scene's coverage of the pixel. Always finite: radiance above
    /// 10³⁰, or that would overflow on its way, is 10³⁰.
    pub color: Vec<Vec4>,
    /// The part of `color` that pictures show without exposure and tone map, and its share of the pixel: unlit
    /// materials and a background of one colour, where the camera sees them directly. Empty if there is nothing of the
    /// kind.
    pub flat: Vec<Vec4>,
    /// Depth along the camera's forward axis at the pixel's first sample, in world units; infinite for a miss. Empty, like
    /// the normals and triangles, without [`Settings::first_hits`].
    pub depth: Vec<f32>,
    /// World-space shading normal at the first sample; zero for a miss.
    pub normal: Vec<Vec3>,
    /// Id of the triangle at the first sample; [`Film::NO_TRIANGLE`] for a miss.
    pub triangle: Vec<u32>,
    /// The layers that [`Settings::layers`] chooses.
    pub layers: FilmLayers,
    /// The view, from the middle of the lens; `None` before the first render.
    pub view: Option<View>,
    /// The point of the world that the view's camera counts from ([`Scene::origin`](umbrage_scene::Scene::origin)).
    pub origin: [f64; 3],
}

/// A picture for a screen: sRGB-encoded rows of RGB, 16 bits a channel, from the upper left corner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels' colours. With an `alpha`, each is that of the surfaces that cover the pixel, however little they
    /// cover.
    pub pixels: Vec<[u16; 3]>,
    /// Coverage of each pixel; empty if all pixels are fully covered.
    pub alpha: Vec<u16>,
}

impl Film {
    /// The value of [`Film::triangle`] for a miss.
    pub const NO_TRIANGLE: u32 = SeenPixels::NONE;

    /// Gives the film its size, and the planes that the settings ask for. The engine writes every pixel with its first
    /// sample.
    ///
    /// # Errors
    /// Where the system hasn't as much memory as the picture will take; the film then stays as it was.
    pub(crate) fn resize(&mut self, [width, height]: [u32; 2], staged: &Staged<'_>) -> Result<(), Error> {
        let pixels = width as usize * height as usize;
        let flat = if staged.has_flat() { pixels } else { 0 };
        let hits = if staged.settings.first_hits { pixels } else { 0 };
        self.reserve(pixels, hits).map_err(|_| no_memory([width, height]))?;
        self.flat.try_reserve(flat.saturating_sub(self.flat.len())).map_err(|_| no_memory([width, height]))?;
        (self.width, self.height) = (width, height);
        self.color.resize(pixels, Vec4::ZERO);
        self.flat.resize(flat, Vec4::ZERO);
        self.depth.resize(hits, f32::INFINITY);
        self.normal.resize(hits, Vec3::ZERO);
        self.triangle.resize(hits, Self::NO_TRIANGLE);
        Ok(())
    }

    /// Makes room for the chosen layers, after [`resize`](Self::resize), and takes over the view and origin.
    ///
    /// # Errors
    /// As [`resize`](Self::resize).
    pub(crate) fn clear_layers(&mut self, staged: &Staged<'_>) -> Result<(), Error> {
        let size = [self.width, self.height];
        (self.view, self.origin) = (Some(staged.view), staged.frame.origin);
        self.layers.clear(size, staged.settings.layers, staged.lights).map_err(|_| no_memory(size))
    }

    /// Reserves memory for more pixels and first hits, and checks that later stages, which can't report a failure, will have
    /// enough for them.
    fn reserve(&mut self, pixels: usize, hits: usize) -> Result<(), TryReserveError> {
        let more_hits = hits.saturating_sub(self.triangle.len());
        self.depth.try_reserve_exact(more_hits)?;
        self.normal.try_reserve_exact(more_hits)?;
        self.triangle.try_reserve_exact(more_hits)?;
        let more = pixels.saturating_sub(self.color.len());
        if more == 0 {
            return Ok(());
        }
        self.color.try_reserve_exact(more)?;
        let beside = Settings::BYTES_OF_PIXEL - (size_of::<(Vec4, f32, u32)>() + size_of::<Vec3>());
        Vec::<u8>::new().try_reserve_exact(beside.saturating_mul(more))
    }

    /// Checks that there is memory for the pixels of an answer without a film.
    ///
    /// # Errors
    /// Where there is too little.
    pub(crate) fn check_memory_without([width, height]: [u32; 2]) -> Result<(), Error> {
        let bytes = Settings::BYTES_OF_PIXEL * width as usize * height as usize;
        Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| no_memory([width, height]))
    }

    /// A sum of samples; an opaque pixel of the largest radiance if the sum has overflowed.
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
        self.color.par_iter_mut().chain(&mut self.flat).each(|sum| *sum *= weight);
        self.layers.average(self.width as usize, samples);
    }

    /// Bytes held for the pixels.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.color.as_slice())
            + size_of_val(self.flat.as_slice())
            + size_of_val(self.depth.as_slice())
            + size_of_val(self.normal.as_slice())
            + size_of_val(self.triangle.as_slice())
            + self.layers.bytes()
    }
}

fn no_memory([width, height]: [u32; 2]) -> Error {
    let settings = Settings { width, height, ..Settings::default() };
    Error::PictureMemory { width, height, megabytes: settings.picture_bytes().div_ceil(1_000_000) }
}

fn refill<T: Copy + Send + Sync>(values: &mut Vec<T>, count: usize, value: T) {
    values.resize(count, value);
    values.par_chunks_mut(1 << 16).each(|values| values.fill(value));
}
