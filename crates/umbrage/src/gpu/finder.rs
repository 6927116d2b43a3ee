use std::any::Any;
use std::fmt::Debug;
use umbrage_rays::parallel::both;

use glam::DVec2;
use umbrage_gpu::{
    Band, Buffer, CameraGrid, CameraOptions, Done, Fit, Geometry, Gpu, GpuError, Groups, LightGrid, LightOptions,
    Recorder, Sight,
};
use umbrage_rays::LightSource;
use umbrage_scene::Frame;

use crate::{GpuGrids, GpuStructure, LightClamp, Settled, Structure};

/// Finds the triangles that pixels see and the lights that reach them; rebuilt for every frame.
pub trait Finder: Any + Debug + Send + Sync {
    /// Whether it is built from a frame's vertices on the CPU.
    fn needs_vertices(&self) -> bool {
        false
    }

    /// Rebuilds the parts that serve all layers of a frame.
    ///
    /// # Errors
    /// If they need more bytes than one buffer of the device can have.
    fn build(&mut self, _gpu: &Gpu, _frame: &Frame) -> Result<(), GpuError> {
        Ok(())
    }

    /// Prepares a layer: parameters and room.
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    fn prepare(&mut self, gpu: &Gpu, question: &Question<'_>) -> Result<(), GpuError>;

    /// Records all stages.
    fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry);

    /// The results.
    fn found(&self) -> Found<'_>;

    /// As many workgroups as the question has if there was room for everything, else none.
    fn groups(&self) -> Groups<'_>;

    /// Records a copy of the pixels' hits, for a next layer behind it.
    ///
    /// # Errors
    /// If the device has no room for it.
    fn keep(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>) -> Result<(), GpuError>;

    /// Checks a layer that is done. Where there was too little room, makes more and returns false.
    ///
    /// # Errors
    /// If the device is lost, or has no more room.
    fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError>;

    /// Whether any pixel of the last finished layer shows a triangle.
    fn sees_any(&self) -> bool;

    /// Adds the predicate's tests in the last finished layer, for camera rays and for shadow rays.
    fn count_settled(&self, settled: &mut [Settled; 2]);

    /// Bytes on the GPU for triangles, for points and for pixels.
    fn bytes(&self) -> [u64; 3];

    /// Maximum bytes per pixel that any stage holds in one buffer.
    fn pixel_bytes(&self) -> u64 {
        Band::PIXEL_BYTES
    }
}

/// The options of one kind of finder. Kernels take long to compile, so a finder that was made once gets other options.
pub trait MakeFinder: Debug + Send + Sync {
    /// A finder with these options.
    fn make(&self, gpu: &Gpu) -> Box<dyn Finder>;

    /// Sets these options of a finder; `false` if it is of another kind.
    fn set_options(&self, gpu: &Gpu, finder: &mut dyn Finder) -> bool;
}

/// The inputs of a layer.
#[derive(Debug)]
pub struct Question<'a> {
    /// The scene's vertices and triangles.
    pub geometry: &'a Geometry,
    /// Rows of the image.
    pub band: &'a Band,
    /// Offset of the sample from the pixel's centre.
    pub offset_pixels: DVec2,
    /// Whether triangles behind those of the last layer are wanted.
    pub sight: Sight,
    /// `None` for lights that cast no shadow.
    pub lights: &'a [Option<LightSource>],
    /// Workgroups that shade.
    pub groups: u32,
}

/// The results of a layer, in the order of [`TileOrder`](umbrage_rays::TileOrder).
#[derive(Debug)]
pub struct Found<'a> {
    /// Each slot's triangle.
    pub seen: &'a Buffer,
    /// Number of slots.
    pub slots: u64,
    /// For each light a bit for each slot.
    pub lit: &'a Buffer,
    /// Number of words of all lights' bits.
    pub lit_words: u64,
}

/// The finders of a GPU. Kernels take long to compile, so those used once are kept.
#[derive(Debug)]
pub(super) struct Finders {
    grids: Grids,
    others: Vec<Box<dyn Finder>>,
    /// Index of the chosen one of `others`; `None` for the grids.
    other: Option<usize>,
}

impl Finders {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { grids: Grids::new(gpu), others: Vec::new(), other: None }
    }

    /// Chooses the finder for [`Settings::structure`](crate::Settings::structure) from now on: its counterpart on a GPU, or
    /// the grids.
    pub(super) fn choose(&mut self, gpu: &Gpu, structure: &Structure) {
        // Settings are checked before anything is rendered.
        let GpuStructure { grids, finder } = structure.on_gpu().ok().flatten().unwrap_or_else(GpuStructure::grids);
        let (camera, lights) = grids.map(options_of).unzip();
        self.grids.camera.set_options(gpu, camera.unwrap_or_default());
        self.grids.lights.set_options(gpu, lights.unwrap_or_default());
        self.other = finder.map(|options| {
            let known = self.others.iter_mut().position(|other| options.set_options(gpu, &mut **other));
            known.unwrap_or_else(|| {
                self.others.push(options.make(gpu));
                self.others.len() - 1
            })
        });
    }

    pub(super) fn chosen(&self) -> &dyn Finder {
        match self.other {
            Some(index) => &*self.others[index],
            None => &self.grids,
        }
    }

    pub(super) fn chosen_mut(&mut self) -> &mut dyn Finder {
        match self.other {
            Some(index) => &mut *self.others[index],
            None => &mut self.grids,
        }
    }
}

fn options_of(grids: GpuGrids) -> (CameraOptions, LightOptions) {
    let GpuGrids { sorting_tile, slices, lights_are_spherical: is_spherical, light_clamp, light_slices } = grids;
    let camera = CameraOptions { mapping: (16 / sorting_tile).clamp(1, 2), slices };
    (camera, LightOptions { is_spherical, clamp: light_clamp.map(LightClamp::degrees), slices: light_slices })
}

/// Grids for the camera and for each light.
#[derive(Debug)]
struct Grids {
    camera: CameraGrid,
    lights: LightGrid,
    fit: Fit,
}

impl Grids {
    fn new(gpu: &Gpu) -> Self {
        let (camera, lights) = both(|| CameraGrid::new(gpu, CameraOptions::default()), || LightGrid::new(gpu));
        Self { camera, lights, fit: Fit::new(gpu) }
    }
}

impl Finder for Grids {
    fn prepare(&mut self, gpu: &Gpu, question: &Question<'_>) -> Result<(), GpuError> {
        let Question { geometry, band, offset_pixels, sight, lights, groups } = *question;
        self.camera.prepare(gpu, geometry, band.clone(), offset_pixels, sight)?;
        self.lights.prepare(gpu, geometry, band.clone(), offset_pixels, lights)?;
        self.fit.prepare(gpu, &self.camera, &self.lights, groups)
    }

    fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let Self { camera, lights, fit } = self;
        camera.record(gpu, recorder, geometry);
        lights.record(gpu, recorder, geometry, camera.seen());
        fit.record(gpu, recorder, camera, lights);
    }

    fn found(&self) -> Found<'_> {
        let Self { camera, lights, .. } = self;
        let lit_words = u64::from(lights.light_count()) * u64::from(lights.mask_words());
        Found { seen: camera.seen(), slots: camera.slots(), lit: lights.lit(), lit_words }
    }

    fn groups(&self) -> Groups<'_> {
        self.fit.groups()
    }

    fn keep(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>) -> Result<(), GpuError> {
        self.camera.keep(gpu, recorder)
    }

    fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        // Points of a picture that didn't fit are incomplete, and so is the room that lights needed for them.
        Ok(self.camera.finish(gpu, done)? && self.lights.finish(gpu, done)?)
    }

    fn sees_any(&self) -> bool {
        self.camera.sees_any()
    }

    fn count_settled(&self, [of_camera, of_lights]: &mut [Settled; 2]) {
        let work = self.camera.work();
        of_camera.tests += u64::from(work.undecided_hits);
        of_camera.rays = of_camera.rays.map(|rays| rays + u64::from(work.undecided_pixels));
        of_lights.tests += self.lights.work().iter().map(|work| u64::from(work.undecided)).sum::<u64>();
    }

    fn bytes(&self) -> [u64; 3] {
        let triangles = self.camera.structure_bytes() + self.lights.structure_bytes();
        [triangles, self.lights.point_bytes(), self.camera.pixel_bytes()]
    }
}
