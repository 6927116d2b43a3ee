use std::fmt::Debug;
use umbrage_rays::parallel::both;

use glam::DVec2;
use umbrage_gpu::kdtree::{KdSight, KdTracerOptions};
use umbrage_gpu::{
    Band, Buffer, CameraGrid, CameraOptions, Done, Fit, Geometry, Gpu, GpuError, Groups, LightGrid, LightOptions,
    Recorder, Sight,
};
use umbrage_rays::{KdPacketOptions, KdPacketWidth, KdTree, KdTreeOptions, LightSource, SimdLevel};
use umbrage_scene::Frame;

use crate::structure::GpuTree;
use crate::{GpuGrids, GpuStructure, LightClamp, Settled, Structure};

/// Finds the triangles that pixels see and the lights that reach them; rebuilt for every frame.
pub(crate) trait Finder: Debug + Send + Sync {
    /// Whether it is built from a frame's vertices on the CPU.
    fn needs_vertices(&self) -> bool {
        false
    }

    /// Rebuilds the parts that serve all layers of a frame.
    fn build(&mut self, _gpu: &Gpu, _frame: &Frame) -> Result<(), GpuError> {
        Ok(())
    }

    /// Prepares a layer: parameters and room.
    fn prepare(&mut self, gpu: &Gpu, question: &Question<'_>) -> Result<(), GpuError>;

    /// Records all stages.
    fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry);

    /// The results.
    fn found(&self) -> Found<'_>;

    /// As many workgroups as the question has if there was room for everything, else none.
    fn groups(&self) -> Groups<'_>;

    /// Records a copy of the pixels' hits, for a next layer behind it.
    fn keep(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>) -> Result<(), GpuError>;

    /// Checks a layer that is done. Where there was too little room, makes more and returns false.
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

    /// Sets the options of a kd-tree; other finders have none.
    fn set_tree_options(&mut self, _gpu: &Gpu, _options: KdTreeOptions) {}
}

/// Makes a finder that goes through a kd-tree with these options.
pub(crate) type MakeFinder = fn(&Gpu, KdTreeOptions) -> Box<dyn Finder>;

/// The inputs of a layer.
pub(crate) struct Question<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) band: &'a Band,
    pub(super) offset_pixels: DVec2,
    pub(super) sight: Sight,
    /// `None` for lights that cast no shadow.
    pub(super) lights: &'a [Option<LightSource>],
    /// Workgroups that shade.
    pub(super) groups: u32,
}

/// The results of a layer, in the order of [`TileOrder`](umbrage_rays::TileOrder).
pub(crate) struct Found<'a> {
    /// Each slot's triangle.
    pub(super) seen: &'a Buffer,
    pub(super) slots: u64,
    /// For each light a bit for each slot.
    pub(super) lit: &'a Buffer,
    pub(super) lit_words: u64,
}

/// The finders of a GPU. Kernels take long to compile, so those used once are kept.
#[derive(Debug)]
pub(super) struct Finders {
    grids: Grids,
    tree: Option<Box<dyn Finder>>,
    takes_tree: bool,
}

impl Finders {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { grids: Grids::new(gpu), tree: None, takes_tree: false }
    }

    /// Chooses the finder for [`Settings::structure`](crate::Settings::structure) from now on: its counterpart on a GPU, or
    /// the grids.
    pub(super) fn choose(&mut self, gpu: &Gpu, structure: &Structure) {
        // Settings are checked before anything is rendered.
        let GpuStructure { grids, tree } = structure.on_gpu().ok().flatten().unwrap_or_else(GpuStructure::grids);
        let (camera, lights) = grids.map(options_of).unzip();
        self.grids.camera.set_options(gpu, camera.unwrap_or_default());
        self.grids.lights.set_options(gpu, lights.unwrap_or_default());
        self.takes_tree = tree.is_some();
        if let Some(GpuTree { options, make }) = tree {
            self.tree.get_or_insert_with(|| make(gpu, options)).set_tree_options(gpu, options);
        }
    }

    pub(super) fn chosen(&self) -> &dyn Finder {
        match &self.tree {
            Some(tree) if self.takes_tree => &**tree,
            _ => &self.grids,
        }
    }

    pub(super) fn chosen_mut(&mut self) -> &mut dyn Finder {
        match &mut self.tree {
            Some(tree) if self.takes_tree => &mut **tree,
            _ => &mut self.grids,
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

/// A kd-tree that the CPU builds.
#[derive(Debug)]
struct TreeOfFrame {
    tree: KdTree,
    options: KdTreeOptions,
    sight: KdSight,
}

impl TreeOfFrame {
    fn new(gpu: &Gpu, options: KdTreeOptions) -> Self {
        let tree = KdTree::with_level(SimdLevel::default());
        Self { tree, options, sight: KdSight::new(gpu, tracer_options(options)) }
    }
}

/// Makes a finder with a kd-tree that the CPU builds.
pub(crate) fn kd_tree_finder(gpu: &Gpu, options: KdTreeOptions) -> Box<dyn Finder> {
    Box::new(TreeOfFrame::new(gpu, options))
}

/// The same traversal and packet width as on the CPU.
fn tracer_options(KdTreeOptions { traversal, packets, .. }: KdTreeOptions) -> KdTracerOptions {
    let KdPacketOptions { width, .. } = packets;
    let lanes = match width {
        KdPacketWidth::Four => 4,
        KdPacketWidth::Eight => 8,
        KdPacketWidth::Sixteen => 16,
    };
    KdTracerOptions { traversal, packet: Some(lanes), ..KdTracerOptions::DEFAULT }
}

impl Finder for TreeOfFrame {
    fn needs_vertices(&self) -> bool {
        true
    }

    fn build(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        // Settings are checked before anything is rendered.
        self.tree.set_options(self.options).ok();
        self.tree.build(frame.triangles());
        self.sight.build(gpu, &self.tree)
    }

    fn prepare(&mut self, gpu: &Gpu, question: &Question<'_>) -> Result<(), GpuError> {
        let Question { band, offset_pixels, sight, lights, groups, .. } = *question;
        self.sight.prepare(gpu, band, offset_pixels, sight, lights, groups)
    }

    fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        self.sight.record(gpu, recorder, geometry);
    }

    fn found(&self) -> Found<'_> {
        let Self { sight, .. } = self;
        let lit_words = u64::from(sight.light_count()) * sight.slots() / 32;
        Found { seen: sight.seen(), slots: sight.slots(), lit: sight.lit(), lit_words }
    }

    fn groups(&self) -> Groups<'_> {
        self.sight.groups()
    }

    fn keep(&mut self, _gpu: &Gpu, recorder: &mut Recorder<'_>) -> Result<(), GpuError> {
        self.sight.keep(recorder);
        Ok(())
    }

    fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        self.sight.finish(gpu, done)
    }

    fn sees_any(&self) -> bool {
        self.sight.sees_any()
    }

    /// The number of these camera rays isn't counted.
    fn count_settled(&self, [of_camera, of_lights]: &mut [Settled; 2]) {
        of_camera.rays = None;
        for work in self.sight.work() {
            let settled = if work.is_shadow { &mut *of_lights } else { &mut *of_camera };
            settled.tests += u64::from(work.undecided_hits);
        }
    }

    fn bytes(&self) -> [u64; 3] {
        [self.sight.structure_bytes(), 0, self.sight.pixel_bytes()]
    }

    fn pixel_bytes(&self) -> u64 {
        KdSight::PIXEL_BYTES
    }

    fn set_tree_options(&mut self, gpu: &Gpu, options: KdTreeOptions) {
        self.options = options;
        self.sight.set_options(gpu, tracer_options(options));
    }
}
