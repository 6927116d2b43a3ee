use super::{DevelopSettings, FilmPlanes};
use crate::{Buffer, Gpu, GpuError, Groups, Kernel};

/// From linear radiance to what a screen can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: colours up to 0.8 keep their hue and contrast, brighter ones are compressed towards white.
    #[default]
    PbrNeutral,
    /// Everything above one is cut off.
    Clip,
}

/// The develop stage: tone maps and encodes the film for a screen.
#[derive(Debug)]
pub struct Develop {
    kernel: Kernel,
    settings: Buffer,
    image: Buffer,
    pixels: u32,
}

impl Develop {
    /// Pixels that a workgroup takes.
    const WIDTH: u32 = 256;

    /// Ready to develop.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernel: Kernel::new(gpu, "shade::develop", "develop", &[]),
            settings: Buffer::uniform(gpu, "develop settings"),
            image: Buffer::storage(gpu, "image"),
            pixels: 0,
        }
    }

    /// Makes ready for a film of so many samples, until it is called again.
    ///
    /// # Errors
    /// Where the device has no room for the image.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        film: &FilmPlanes,
        samples: u32,
        exposure_stops: f32,
        tone_map: ToneMap,
    ) -> Result<(), GpuError> {
        self.pixels = film.pixels();
        let tone_map = match tone_map {
            ToneMap::PbrNeutral => DevelopSettings::NEUTRAL,
            ToneMap::Clip => DevelopSettings::CLIP,
        };
        let scale = exposure_stops.exp2() / samples as f32;
        let settings = DevelopSettings { scale, tone_map, pixels: self.pixels };
        self.settings.write(gpu, &[settings])?;
        self.image.reserve(gpu, u64::from(self.pixels) * 4)
    }

    /// Develops the film.
    pub fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, film: &FilmPlanes) {
        let groups = Groups::Flat(self.pixels.div_ceil(Self::WIDTH));
        self.kernel.dispatch(gpu, pass, &[&self.settings, film.planes(), &self.image], groups);
    }

    /// The image: sRGB-encoded RGBA8 with red in the lowest byte and full alpha, in rows from the upper left corner.
    #[must_use]
    pub fn image(&self) -> &Buffer {
        &self.image
    }
}
