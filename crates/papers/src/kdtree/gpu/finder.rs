use std::any::Any;

use umbrage::Settled;
use umbrage::gpu::{Finder, Found, MakeFinder, Question};
use umbrage::scene::Frame;
use umbrage_gpu::{Done, Geometry, Gpu, GpuError, Groups, Recorder};
use umbrage_rays::SimdLevel;

use super::options::KdTracerOptions;
use super::sight::KdSight;
use crate::{KdPacketOptions, KdPacketWidth, KdTree, KdTreeOptions};

/// A kd-tree that the CPU builds.
#[derive(Debug)]
struct TreeOfFrame {
    tree: KdTree,
    options: KdTreeOptions,
    sight: KdSight,
}

/// Rays go through a kd-tree with these options.
impl MakeFinder for KdTreeOptions {
    fn make(&self, gpu: &Gpu) -> Box<dyn Finder> {
        let tree = KdTree::with_level(SimdLevel::default());
        Box::new(TreeOfFrame { tree, options: *self, sight: KdSight::new(gpu, tracer_options(*self)) })
    }

    fn set_options(&self, gpu: &Gpu, finder: &mut dyn Finder) -> bool {
        let finder: &mut dyn Any = finder;
        let Some(finder) = finder.downcast_mut::<TreeOfFrame>() else { return false };
        finder.options = *self;
        finder.sight.set_options(gpu, tracer_options(*self));
        true
    }
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
}
