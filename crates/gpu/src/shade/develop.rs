use super::FilmPlanes;
use super::tables::DevelopSettings;
use crate::{Buffer, Gpu, GpuError, Groups, Kernel, Recorder};

/// Mapping from linear radiance to display light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: colours up to 0.8 keep their hue and contrast, brighter ones are compressed towards white.
    #[default]
    PbrNeutral,
    /// Values above one are clamped.
    Clip,
}

/// The develop stage: tone maps and encodes the film for a screen.
#[derive(Debug)]
pub struct Develop {
    kernel: Kernel,
    settings: Buffer,
    levels: Buffer,
    image: Buffer,
    size: [u32; 2],
}

impl Develop {
    /// Pixels of a workgroup.
    const WIDTH: u32 = 256;
    /// Rows of images begin at multiples of this many pixels, as copies to textures require.
    const ROW_STEP: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 4;

    /// Makes the stage. `levels` has the least linear value of each level of an sRGB-encoded channel, ascending from zero.
    ///
    /// # Errors
    /// If the device has reported an error.
    pub fn new(gpu: &Gpu, levels: &[f32; 256]) -> Result<Self, GpuError> {
        let mut develop = Self {
            kernel: Kernel::new(gpu, "shade::develop", "develop", &[]),
            settings: Buffer::uniform(gpu, "develop settings"),
            levels: Buffer::storage(gpu, "levels"),
            image: Buffer::storage(gpu, "image"),
            size: [0, 0],
        };
        develop.levels.write(gpu, levels)?;
        Ok(develop)
    }

    /// Prepares for a film of `samples` samples, until the next call.
    ///
    /// # Errors
    /// If the device has no room for the image.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        film: &FilmPlanes,
        samples: u32,
        exposure_stops: f32,
        tone_map: ToneMap,
    ) -> Result<(), GpuError> {
        self.size = film.size();
        let [width, height] = self.size;
        let tone_map = match tone_map {
            ToneMap::PbrNeutral => DevelopSettings::NEUTRAL,
            ToneMap::Clip => DevelopSettings::CLIP,
        };
        let (weight, exposure, row_pixels) = (1.0 / samples as f32, exposure_stops.exp2(), self.row_pixels());
        let flat_plane = film.flat_plane().unwrap_or(DevelopSettings::NO_PLANE);
        let settings = DevelopSettings { weight, exposure, tone_map, width, height, row_pixels, flat_plane };
        self.settings.write(gpu, &[settings])?;
        self.image.reserve(gpu, u64::from(row_pixels) * u64::from(height) * 4)
    }

    /// Records the stage.
    pub fn record(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, film: &FilmPlanes) {
        let groups = Groups::Flat((self.size[0] * self.size[1]).div_ceil(Self::WIDTH));
        self.kernel.dispatch(gpu, pass, &[&self.settings, film.planes(), &self.levels, &self.image], groups);
    }

    /// Records a copy of the image to the rows of a texture from `first` on.
    pub fn copy(&self, recorder: &mut Recorder<'_>, texture: &wgpu::Texture, first: u32) {
        recorder.copy_rows((&self.image, self.row_pixels()), (texture, first), self.size);
    }

    /// Fetches the image: sRGB-encoded RGBA8 with red in the lowest byte and full alpha, in rows from the upper
    /// left corner.
    ///
    /// # Errors
    /// If the device is lost or has reported an error.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_image(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let [width, height] = self.size.map(|side| side as usize);
        let row = self.row_pixels() as usize;
        let padded: Vec<u32> = self.image.read(gpu, row * height)?;
        Ok(padded.chunks_exact(row.max(1)).flat_map(|row| &row[..width]).copied().collect())
    }

    /// Bytes of the image.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.image.bytes()
    }

    /// Distance between rows of the image, in pixels.
    fn row_pixels(&self) -> u32 {
        self.size[0].next_multiple_of(Self::ROW_STEP)
    }
}
