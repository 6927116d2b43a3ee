use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use umbrage_gpu::internals::{PointView, ShadowLight};
use umbrage_gpu::rays::{RayRecords, RayTracer, RayTracerWork};
use umbrage_gpu::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Kernel, Recorder, Sight};
use umbrage_rays::LightSource;

use super::options::KdTracerOptions;
use super::tree::KdNodes;
use crate::KdTree;

/// The triangle that each pixel of a camera sees, and the lights that reach it, found through a kd-tree: the answers of
/// a [`CameraGrid`](umbrage_gpu::CameraGrid) and a [`LightGrid`](umbrage_gpu::LightGrid).
#[derive(Debug)]
pub struct KdSight {
    tracer: RayTracer,
    nodes: KdNodes,
    make_rays: Kernel,
    see: Kernel,
    ask: Kernel,
    light: Kernel,
    fit: Kernel,
    point_view: Buffer,
    ray_parameters: Buffer,
    /// A buffer for each light: all are in use in one submission.
    lights: Vec<Buffer>,
    /// For each light whether triangles shadow it.
    casts_shadow: Vec<bool>,
    /// The camera's rays, then the shadow questions of one light after the other.
    records: RayRecords,
    seen: Buffer,
    /// The triangles that pixels showed before, kept for [`Sight::is_behind`].
    front: Buffer,
    lit: Buffer,
    sees_any: Buffer,
    fetch: Fetch,
    room: Buffer,
    sizes_if_all_fits: Buffer,
    sizes: Buffer,
    slots: u32,
    has_seen_any: bool,
}

/// Uniform of `rays.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdRays {
    packet: u32,
    sees_behind: u32,
}

/// Uniform of `fit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdFit {
    room: u32,
    uses: u32,
    groups: u32,
}

impl KdSight {
    /// The most bytes per pixel in one buffer.
    pub const PIXEL_BYTES: u64 = RayRecords::RAY_BYTES;

    /// Compiles the stages; there is no tree yet.
    #[must_use]
    pub fn new(gpu: &Gpu, options: KdTracerOptions) -> Self {
        let kernel = |path, entry| Kernel::of_modules(gpu, super::MODULES, path, entry, &[]);
        Self {
            tracer: RayTracer::new(gpu, options),
            nodes: KdNodes::new(gpu),
            make_rays: kernel("kdtree::rays", "rays"),
            see: kernel("kdtree::seen", "see"),
            ask: kernel("kdtree::ask", "ask"),
            light: kernel("rays::lit", "lit"),
            fit: kernel("kdtree::fit", "fit"),
            point_view: Buffer::uniform(gpu, "view of points"),
            ray_parameters: Buffer::uniform(gpu, "rays"),
            lights: Vec::new(),
            casts_shadow: Vec::new(),
            records: RayRecords::new(gpu),
            seen: Buffer::storage(gpu, "seen"),
            front: Buffer::storage(gpu, "seen before"),
            lit: Buffer::storage(gpu, "lit"),
            sees_any: Buffer::storage(gpu, "whether any is seen"),
            fetch: Fetch::default(),
            room: Buffer::uniform(gpu, "room"),
            sizes_if_all_fits: Buffer::storage(gpu, "whether all fits"),
            sizes: Buffer::sizes(gpu, "dispatch sizes of what fits"),
            slots: 0,
            has_seen_any: false,
        }
    }

    /// Sets the traversal for the next frames.
    pub fn set_options(&mut self, gpu: &Gpu, options: KdTracerOptions) {
        self.tracer.set_options(gpu, options);
    }

    /// Uploads a frame's tree.
    ///
    /// # Errors
    /// If it needs more bytes than one buffer of the device can have.
    pub fn build(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        self.nodes.write(gpu, tree)
    }

    /// Prepares a frame of some or all rows of an image: parameters and room. `None` stands for a light without
    /// shadows. `groups` is the size of the dispatch that follows if everything fits.
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        band: &Band,
        offset_pixels: DVec2,
        sight: Sight,
        lights: &[Option<LightSource>],
        groups: u32,
    ) -> Result<(), GpuError> {
        self.slots = band.order().slots() as u32;
        let (slots, packet) = (self.slots, self.tracer.options().lanes());
        self.point_view.write(gpu, &[PointView::new(band, offset_pixels)])?;
        let sees_behind = u32::from(sight.is_behind);
        self.ray_parameters.write(gpu, &[KdRays { packet, sees_behind }])?;
        self.lights.truncate(lights.len());
        while self.lights.len() < lights.len() {
            self.lights.push(Buffer::uniform(gpu, "light"));
        }
        self.casts_shadow.clear();
        self.casts_shadow.extend(lights.iter().map(Option::is_some));
        for ((buffer, light), number) in self.lights.iter_mut().zip(lights).zip(0..) {
            let parameters = ShadowLight::new(light.as_ref(), packet, number * (slots / 32), 0);
            buffer.write(gpu, &[parameters])?;
        }
        self.records.reserve(gpu, slots)?;
        self.seen.reserve(gpu, 4 * u64::from(slots))?;
        self.front.reserve(gpu, 4 * u64::from(slots))?;
        self.lit.reserve(gpu, (u64::from(slots) / 8 * lights.len() as u64).max(16))?;
        self.sees_any.reserve(gpu, 16)?;
        self.sizes_if_all_fits.reserve(gpu, 16)?;
        self.sizes.reserve(gpu, 16)?;
        let uses = 1 + self.casts_shadow.iter().filter(|casts| **casts).count() as u32;
        self.tracer.prepare(gpu, slots, uses)?;
        self.room.write(gpu, &[KdFit { room: self.tracer.room(), uses, groups }])
    }

    /// Records all stages.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let Self { tracer, nodes, records, seen, front, point_view, .. } = self;
        let slots = Groups::Flat(self.slots.div_ceil(64));
        recorder.clear(&self.sees_any);
        let buffers =
            [point_view, &self.ray_parameters, geometry.triangles(), geometry.positions(), front, records.buffer()];
        recorder.stage("rays", |pass| self.make_rays.dispatch(gpu, pass, &buffers, slots));
        tracer.record_nearest(gpu, recorder, geometry, nodes, records);
        let buffers = [records.buffer(), tracer.hits(), seen, &self.sees_any];
        recorder.stage("seen", |pass| self.see.dispatch(gpu, pass, &buffers, slots));
        for (light, casts_shadow) in self.lights.iter().zip(&self.casts_shadow) {
            let buffers = [light, point_view, tracer.hits(), records.buffer()];
            recorder.stage("ask", |pass| self.ask.dispatch(gpu, pass, &buffers, slots));
            if *casts_shadow {
                tracer.record_blocked(gpu, recorder, geometry, nodes, records);
            }
            let buffers = [light, records.buffer(), tracer.shadows(), &self.lit];
            recorder.stage("lit", |pass| self.light.dispatch(gpu, pass, &buffers, slots));
        }
        let buffers = [&self.room, tracer.needs(), &self.sizes_if_all_fits];
        recorder.stage("fit", |pass| self.fit.dispatch(gpu, pass, &buffers, Groups::Flat(1)));
        recorder.copy_words(&self.sizes_if_all_fits, &self.sizes, 3);
        self.fetch = recorder.fetch(&self.sees_any, 1);
    }

    /// The prepared number of workgroups if everything fits, else none.
    #[must_use]
    pub fn groups(&self) -> Groups<'_> {
        Groups::Indirect(&self.sizes, 0)
    }

    /// Keeps the triangles that pixels show, for a next frame that looks [behind](Sight::is_behind) them.
    pub fn keep(&self, recorder: &mut Recorder<'_>) {
        recorder.copy_words(&self.seen, &self.front, u64::from(self.slots));
    }

    /// Reads the needs of a frame that is done. If they exceed the room there was, makes more and returns `false`: the
    /// frame has to be rendered again.
    ///
    /// # Errors
    /// If the device is lost, or a buffer would need more bytes than the device allows.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        self.has_seen_any = done.read::<u32>(self.fetch)? != [0];
        self.tracer.finish(gpu, done)
    }

    /// Whether any pixel of the last finished frame saw a triangle.
    #[must_use]
    pub fn sees_any(&self) -> bool {
        self.has_seen_any
    }

    /// Work of the last finished frame: its camera's rays, then each light that casts shadows.
    #[must_use]
    pub fn work(&self) -> &[RayTracerWork] {
        self.tracer.work()
    }

    /// As [`CameraGrid::seen`](umbrage_gpu::CameraGrid::seen).
    #[must_use]
    pub fn seen(&self) -> &Buffer {
        &self.seen
    }

    /// As [`LightGrid::lit`](umbrage_gpu::LightGrid::lit).
    #[must_use]
    pub fn lit(&self) -> &Buffer {
        &self.lit
    }

    /// Number of slots of [`KdSight::seen`].
    #[must_use]
    pub fn slots(&self) -> u64 {
        self.slots.into()
    }

    /// Number of lights of the last prepared frame.
    #[must_use]
    pub fn light_count(&self) -> u32 {
        self.lights.len() as u32
    }

    /// Bytes on the GPU for triangles.
    #[must_use]
    pub fn structure_bytes(&self) -> u64 {
        self.nodes.bytes()
    }

    /// Bytes on the GPU for pixels and rays.
    #[must_use]
    pub fn pixel_bytes(&self) -> u64 {
        [self.records.buffer(), &self.seen, &self.front, &self.lit].into_iter().map(Buffer::bytes).sum::<u64>()
            + self.tracer.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kdtree::gpu::link;
    use crate::layout::{differences, layout, module};

    #[test]
    fn parameters_are_those_of_the_shaders() {
        for (path, layout) in [
            ("kdtree::rays", layout!(KdRays { packet, sees_behind })),
            ("kdtree::fit", layout!(KdFit { room, uses, groups })),
        ] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }
}
