//! Differences of films.

use umbrage::scene::Frame;
use umbrage::{Error, Film, Renderer, Settings};

use crate::common::{Pooled, renderer};

/// Both engines.
pub(crate) struct Engines {
    cpu: Renderer,
    gpu: Pooled<Renderer>,
}

/// The films of one frame.
#[derive(Clone, Debug)]
pub(crate) struct Films {
    pub(crate) cpu: Film,
    pub(crate) gpu: Film,
    /// Bytes that the frame uploaded: new parts of the frame, and its parameters.
    pub(crate) uploaded_bytes: u64,
}

/// Both.
pub(crate) fn engines() -> Option<Engines> {
    Some(Engines { cpu: Renderer::default(), gpu: renderer()? })
}

impl Engines {
    pub(crate) fn render(&mut self, frame: &Frame, settings: &Settings) -> Result<Films, Error> {
        let gpu = self.gpu.render_frame(frame, settings)?.clone();
        let cpu = self.cpu.render_frame(frame, settings)?.clone();
        Ok(Films { cpu, gpu, uploaded_bytes: self.gpu.stats().uploaded_bytes })
    }
}

/// Number of pixels in which two films differ, and their largest differences.
///
/// The CPU has hits in f64 and shades in f32; the GPU has both in f32 and may contract sums of products. Most pixels so
/// agree to about 10⁻⁶, less than a hundredth of a level. Three things can enlarge a rounding: a texel edge on a triangle
/// with so many texels that f32 weights hardly tell them apart (on a floor of 100,000 texels a side, half a unit in the last
/// place is 0.003 texels, on the CPU as well), a ray that only grazes its triangle, and a light in the plane of the triangle
/// that it shines on. On lavapipe and on `SwiftShader` no picture of these tests has such a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Difference {
    /// Number of compared pixels.
    pub(crate) pixels: usize,
    /// Pixels that differ by more than [`Difference::LEVELS`] in some channel after tone mapping.
    pub(crate) colors: usize,
    /// The largest difference after tone mapping, in levels of 255.
    pub(crate) largest_level: f32,
    /// Pixels whose coverage differs by more than [`Difference::COVERAGE`].
    pub(crate) coverages: usize,
    /// Pixels whose normal differs by more than [`Difference::NORMAL`].
    pub(crate) normals: usize,
    /// Pixels whose depth differs by more than [`Difference::RELATIVE_DEPTH`].
    pub(crate) depths: usize,
    /// Pixels with another triangle.
    pub(crate) triangles: usize,
}

impl Difference {
    /// One step of an eight-bit image.
    const LEVELS: f32 = 1.0;
    const COVERAGE: f32 = 1e-4;
    const NORMAL: f32 = 1e-2;
    /// Rays that only graze a triangle have an ill-defined depth in f32.
    const RELATIVE_DEPTH: f32 = 1e-3;

    pub(crate) fn of(cpu: &Film, gpu: &Film, settings: &Settings) -> Self {
        let mut difference = Self { pixels: cpu.color.len(), ..Self::default() };
        let [of_cpu, of_gpu] = [cpu, gpu].map(|film| film.develop(settings).pixels);
        for (pixel, (one, other)) in of_cpu.into_iter().zip(of_gpu).enumerate() {
            let levels = (0..3).map(|channel| f32::from(one[channel].abs_diff(other[channel])) / 257.0);
            let most = levels.fold(0.0, f32::max);
            difference.largest_level = difference.largest_level.max(most);
            difference.colors += usize::from(most > Self::LEVELS);
            let coverage = (cpu.color[pixel].w - gpu.color[pixel].w).abs();
            difference.coverages += usize::from(coverage.is_nan() || coverage > Self::COVERAGE);
            let apart = cpu.normal[pixel].distance(gpu.normal[pixel]);
            difference.normals += usize::from(apart.is_nan() || apart > Self::NORMAL);
            let (near, far) = (cpu.depth[pixel], gpu.depth[pixel]);
            let is_same_depth = near == far || (near - far).abs() <= Self::RELATIVE_DEPTH * near.abs();
            difference.depths += usize::from(!is_same_depth);
            difference.triangles += usize::from(cpu.triangle[pixel] != gpu.triangle[pixel]);
        }
        difference
    }

    /// Fails if more than one pixel in 10,000 differs, or any has another triangle.
    pub(crate) fn expect_alike(&self, name: &str) {
        let Self { pixels, colors, coverages, normals, depths, triangles, .. } = *self;
        println!("{name}: {self:?}");
        let most = pixels / 10_000;
        let is_alike = triangles == 0 && [colors, coverages, normals, depths].iter().all(|&count| count <= most);
        assert!(is_alike, "{name}: {self:?}");
    }
}
