use crate::{Buffer, Gpu, GpuError};

/// The film on the GPU: planes of four f32 a pixel, in rows from the upper left corner.
///
/// 16 bytes a pixel for the colour, 20 for what is kept of the first sample, and 16 where the scene is seen through.
#[derive(Debug)]
pub struct FilmPlanes {
    planes: Buffer,
    triangle: Buffer,
    width: u32,
    height: u32,
    keeps_first: bool,
    keeps_through: bool,
}

impl FilmPlanes {
    /// A film without pixels.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let (planes, triangle) = (Buffer::storage(gpu, "film"), Buffer::storage(gpu, "film triangles"));
        Self { planes, triangle, width: 0, height: 0, keeps_first: false, keeps_through: false }
    }

    /// Makes room for an image. What it held before is not erased: the first layer of the first sample does that.
    ///
    /// `keeps_first` says whether depth, normal and triangle of each pixel's first sample are kept, `keeps_through` whether
    /// several layers of surfaces are seen.
    ///
    /// # Errors
    /// Where the device has no buffer of that size.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        [width, height]: [u32; 2],
        keeps_first: bool,
        keeps_through: bool,
    ) -> Result<(), GpuError> {
        let pixels = u64::from(width) * u64::from(height);
        let planes = 1 + u64::from(keeps_first) + u64::from(keeps_through);
        self.planes.reserve(gpu, pixels * planes * 16)?;
        if keeps_first {
            self.triangle.reserve(gpu, pixels * 4)?;
        }
        (self.width, self.height) = (width, height);
        (self.keeps_first, self.keeps_through) = (keeps_first, keeps_through);
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
        self.keeps_first.then(|| self.pixels())
    }

    /// Where the plane of what the layers so far let through starts, in pixels; `None` where it isn't kept.
    #[must_use]
    pub fn through_plane(&self) -> Option<u32> {
        self.keeps_through.then(|| self.pixels() * (1 + u32::from(self.keeps_first)))
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

    /// Waits, then gives linear radiance and coverage, summed over the samples.
    ///
    /// # Errors
    /// Where the device is lost or has reported an error.
    pub fn read_color(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, GpuError> {
        self.planes.read(gpu, self.pixels() as usize)
    }

    /// Waits, then gives the normal, which is zero for a miss, and the depth, which is infinite for a miss, of each pixel
    /// at the first sample; nothing where they aren't kept.
    ///
    /// # Errors
    /// Where the device is lost or has reported an error.
    pub fn read_first(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, GpuError> {
        let Some(first) = self.first_plane() else { return Ok(Vec::new()) };
        Ok(self.planes.read(gpu, (first + self.pixels()) as usize)?.split_off(first as usize))
    }

    /// Waits, then gives each pixel's triangle at the first sample, `0xffffffff` for a miss; nothing where they aren't
    /// kept.
    ///
    /// # Errors
    /// Where the device is lost or has reported an error.
    pub fn read_triangle(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        self.triangle.read(gpu, if self.keeps_first { self.pixels() as usize } else { 0 })
    }
}
