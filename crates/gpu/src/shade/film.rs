use crate::{Buffer, Fetch, Gpu, GpuError, Recorder};

/// The film on the GPU: planes of four f32 for each pixel, in rows from the upper left corner.
///
/// 16 bytes for a pixel's colour, and those of the planes in [`FilmKeeps`].
#[derive(Debug)]
pub struct FilmPlanes {
    planes: Buffer,
    triangle: Buffer,
    width: u32,
    height: u32,
    keeps: FilmKeeps,
}

/// Planes of a film besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilmKeeps {
    /// Depth, normal and triangle at the first sample, in 20 bytes.
    pub first: bool,
    /// Transmittance of several layers of surfaces, in 16 bytes.
    pub through: bool,
    /// The part of the colour that is shown without tone mapping, in 16 bytes.
    pub flat: bool,
    /// Number of planes for followed rays, of 16 bytes: none, [`Onward::MIRRORS`](crate::Onward::MIRRORS),
    /// [`Onward::ALL_WAYS`](crate::Onward::ALL_WAYS) or [`Onward::GLOSSY_WAYS`](crate::Onward::GLOSSY_WAYS).
    pub ways: u32,
}

impl FilmKeeps {
    /// Bytes of a pixel in the buffer of all planes.
    #[must_use]
    pub fn plane_bytes(self) -> u64 {
        let Self { first, through, flat, ways } = self;
        16 * (1 + u64::from(first) + u64::from(through) + u64::from(flat) + u64::from(ways))
    }
}

impl FilmPlanes {
    /// A film without pixels.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let (planes, triangle) = (Buffer::storage(gpu, "film"), Buffer::storage(gpu, "film triangles"));
        Self { planes, triangle, width: 0, height: 0, keeps: FilmKeeps::default() }
    }

    /// Makes room for an image. It doesn't erase the old contents: the first layer of the first sample does that.
    ///
    /// # Errors
    /// If the device has no buffer of that size.
    pub fn prepare(&mut self, gpu: &Gpu, [width, height]: [u32; 2], keeps: FilmKeeps) -> Result<(), GpuError> {
        let pixels = u64::from(width) * u64::from(height);
        self.planes.reserve(gpu, pixels * keeps.plane_bytes())?;
        if keeps.first {
            self.triangle.reserve(gpu, pixels * 4)?;
        }
        (self.width, self.height, self.keeps) = (width, height, keeps);
        Ok(())
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// First pixel of the plane of normals (xyz) and depths (w) at the first sample; `None` if it isn't kept.
    #[must_use]
    pub fn first_plane(&self) -> Option<u32> {
        self.keeps.first.then(|| self.pixels())
    }

    /// First pixel of the plane of the layers' transmittance so far; `None` if it isn't kept.
    #[must_use]
    pub fn through_plane(&self) -> Option<u32> {
        self.keeps.through.then(|| self.pixels() * (1 + u32::from(self.keeps.first)))
    }

    /// First pixel of the plane of colour that is shown without tone mapping, with the fraction of the pixel that it
    /// covers; `None` if it isn't kept.
    #[must_use]
    pub fn flat_plane(&self) -> Option<u32> {
        let FilmKeeps { first, through, flat, .. } = self.keeps;
        flat.then(|| self.pixels() * (1 + u32::from(first) + u32::from(through)))
    }

    /// Number of planes for followed rays.
    #[must_use]
    pub fn ways(&self) -> u32 {
        self.keeps.ways
    }

    /// First pixel of these planes; `None` if there are none.
    #[must_use]
    pub fn ways_plane(&self) -> Option<u32> {
        let FilmKeeps { first, through, flat, ways } = self.keeps;
        (ways > 0).then(|| self.pixels() * (1 + u32::from(first) + u32::from(through) + u32::from(flat)))
    }

    /// The planes; the first holds linear radiance and coverage, summed over the samples.
    #[must_use]
    pub fn planes(&self) -> &Buffer {
        &self.planes
    }

    /// Each pixel's triangle at the first sample, if that is kept; `0xffffffff` for a miss.
    #[must_use]
    pub fn triangle(&self) -> &Buffer {
        &self.triangle
    }

    /// Fetches linear radiance and coverage, four f32 for each pixel, summed over the samples.
    pub fn fetch_color(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, Some(0))
    }

    /// Fetches each pixel's normal (zero for a miss) and depth (infinite for a miss) at the first sample, four f32 for
    /// each pixel; nothing if they aren't kept.
    pub fn fetch_first(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, self.first_plane())
    }

    /// Fetches the radiance that is shown without tone mapping, and the fraction of the pixel that it covers, four f32
    /// for each pixel, summed over the samples; nothing if it isn't kept.
    pub fn fetch_flat(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, self.flat_plane())
    }

    fn fetch_plane(&self, recorder: &mut Recorder<'_>, first_pixel: Option<u32>) -> Fetch {
        let words = |pixels: u32| 4 * u64::from(pixels);
        first_pixel
            .map_or_else(Fetch::default, |first| recorder.fetch_from(&self.planes, words(first), words(self.pixels())))
    }

    /// Fetches each pixel's triangle at the first sample, a u32, `0xffffffff` for a miss; nothing if they aren't kept.
    pub fn fetch_triangle(&self, recorder: &mut Recorder<'_>) -> Fetch {
        recorder.fetch(&self.triangle, if self.keeps.first { self.pixels().into() } else { 0 })
    }
}
