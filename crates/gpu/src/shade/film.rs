use crate::{Buffer, Fetch, Gpu, GpuError, Recorder};

/// The film on the GPU: planes of four f32 a pixel, in rows from the upper left corner.
///
/// 16 bytes a pixel for the colour, and what is kept besides.
#[derive(Debug)]
pub struct FilmPlanes {
    planes: Buffer,
    triangle: Buffer,
    width: u32,
    height: u32,
    keeps: FilmKeeps,
}

/// What a film keeps of each pixel besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilmKeeps {
    /// Depth, normal and triangle at the first sample, in 20 bytes.
    pub first: bool,
    /// What several layers of surfaces let through, in 16 bytes.
    pub through: bool,
    /// What of the colour is shown as it is, in 16 bytes.
    pub flat: bool,
    /// Planes that say where light comes from that is followed, of 16 bytes: none, [`Onward::MIRRORS`](crate::Onward::MIRRORS),
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

    /// Makes room for an image. What it held before is not erased: the first layer of the first sample does that.
    ///
    /// # Errors
    /// Where the device has no buffer of that size.
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

    /// How many pixels it has.
    #[must_use]
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// Where the plane of normals (xyz) and depths (w) at the first sample starts, in pixels; `None` where it isn't kept.
    #[must_use]
    pub fn first_plane(&self) -> Option<u32> {
        self.keeps.first.then(|| self.pixels())
    }

    /// Where the plane of what the layers so far let through starts, in pixels; `None` where it isn't kept.
    #[must_use]
    pub fn through_plane(&self) -> Option<u32> {
        self.keeps.through.then(|| self.pixels() * (1 + u32::from(self.keeps.first)))
    }

    /// Where the plane of what is shown as it is starts, in pixels, with how much of the pixel that is; `None` where it isn't
    /// kept.
    #[must_use]
    pub fn flat_plane(&self) -> Option<u32> {
        let FilmKeeps { first, through, flat, .. } = self.keeps;
        flat.then(|| self.pixels() * (1 + u32::from(first) + u32::from(through)))
    }

    /// How many planes say where light comes from that is followed.
    #[must_use]
    pub fn ways(&self) -> u32 {
        self.keeps.ways
    }

    /// Where these planes start, in pixels; `None` where there are none.
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

    /// Each pixel's triangle at the first sample, where that is kept; `0xffffffff` for a miss.
    #[must_use]
    pub fn triangle(&self) -> &Buffer {
        &self.triangle
    }

    /// Fetches linear radiance and coverage, four f32 a pixel, summed over the samples.
    pub fn fetch_color(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, Some(0))
    }

    /// Fetches the normal, which is zero for a miss, and the depth, which is infinite for a miss, of each pixel at the first
    /// sample, four f32 a pixel; nothing where they aren't kept.
    pub fn fetch_first(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, self.first_plane())
    }

    /// Fetches what of the radiance is shown as it is, and of how much of the pixel, four f32 a pixel, summed over the
    /// samples; nothing where it isn't kept.
    pub fn fetch_flat(&self, recorder: &mut Recorder<'_>) -> Fetch {
        self.fetch_plane(recorder, self.flat_plane())
    }

    fn fetch_plane(&self, recorder: &mut Recorder<'_>, first_pixel: Option<u32>) -> Fetch {
        let words = |pixels: u32| 4 * u64::from(pixels);
        first_pixel
            .map_or_else(Fetch::default, |first| recorder.fetch_from(&self.planes, words(first), words(self.pixels())))
    }

    /// Fetches each pixel's triangle at the first sample, a u32, `0xffffffff` for a miss; nothing where they aren't kept.
    pub fn fetch_triangle(&self, recorder: &mut Recorder<'_>) -> Fetch {
        recorder.fetch(&self.triangle, if self.keeps.first { self.pixels().into() } else { 0 })
    }
}
