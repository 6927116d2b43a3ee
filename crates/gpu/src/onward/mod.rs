//! Secondary rays of mirrors, of glass and straight on through transmissive surfaces, generation by generation, traced
//! through a hierarchy. On the CPU: `umbrage/src/cpu/onward.rs`.
//!
//! Shading writes planes beside the film (`way.wgsl`) with the directions and throughputs of each pixel's secondary rays.
//! `count` and a scan number these rays in the order of their pixels; `locate` finds the camera rays' hit points, as exactly
//! as a ray's hit; `send` writes the rays. The tracer of `rays` finds their hits. A ray that starts on a triangle hits
//! neither that nor any triangle whose plane can't be separated from the start. `meet` converts hits for lights and shading.
//! Shading then writes planes for each ray: a colour, which `add` sums for each pixel in the order of the rays, and the next
//! directions and throughputs.
//!
//! Visibility of lights (`lights`) comes from `ask`, the tracer and `lit` of `rays`. With transmissive surfaces, the
//! tracer lists the ones between point and light, shading's `tint` computes their transmittance, and `tinted` stores it. For
//! the camera rays' hits, the engine's structure has found the visibility already; only transmittance is computed.
//!
//! The CPU reads back each generation's number of rays, and reserves memory for these.

mod lights;
mod step;

use glam::DVec2;
use umbrage_rays::{Bvh, LightSource};

use crate::primitives::Scan;
use crate::rays::{Hierarchy, RayRecords, RayTracer, RayTracerOptions, Walk};
use crate::shade::{FilmPlanes, Shade, ShadeScene};
use crate::view::PointView;
use crate::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Kernel, Recorder};
pub use lights::OnwardLight;
pub(crate) use lights::mask_words;
use lights::{Asked, OnwardLights};
use step::{OnwardStep, Step};

/// Follows secondary rays. Each generation is [counted](Onward::record_count), [traced](Onward::record_rays), shaded by
/// [`Shade`] and [added](Onward::record_add) to the film.
#[derive(Debug)]
pub struct Onward {
    hierarchy: Hierarchy,
    /// The hierarchy of transmissive triangles.
    passed: Hierarchy,
    tracer: RayTracer,
    count: Kernel,
    scan: Scan,
    locate: Kernel,
    send: Kernel,
    meet: Kernel,
    add: Kernel,
    point_view: Buffer,
    /// The previous generation, and the one it spawns.
    from: Step,
    rays: Step,
    starts: Buffer,
    lights: OnwardLights,
    meetings: Buffer,
    /// Colours and ways of a generation's rays.
    planes: Buffer,
    total: Fetch,
    light: OnwardLight,
    /// Planes of ways in the film.
    ways: u32,
    flat_plane_of_film: u32,
}

/// Limits on surfaces that a ray passes in a row.
#[derive(Clone, Copy, Debug)]
pub struct OnwardLayers {
    /// Number of surfaces from which rays with a throughput below `least_part` end.
    pub many: u32,
    /// Throughput, 0 to 1.
    pub least_part: f32,
    /// Number of surfaces from which all rays end.
    pub most: u32,
}

impl Onward {
    /// Number of planes for mirrors alone.
    pub const MIRRORS: u32 = 2;
    /// Number of planes with transmissive surfaces.
    pub const ALL_WAYS: u32 = 6;
    /// Number of planes with rough surfaces followed too.
    pub const GLOSSY_WAYS: u32 = 7;
    const MEETING_BYTES: u64 = 80;
    const PLANE_BYTES: u64 = 16;
    const OPTIONS: RayTracerOptions = RayTracerOptions { walk: Walk::HIERARCHY, counts: false, from_triangles: true };

    /// Maximum bytes per pixel in one buffer, for generations of up to four rays per pixel if `ways` has more than mirrors.
    #[must_use]
    pub fn pixel_bytes(ways: u32) -> u64 {
        let rays = if ways > Self::MIRRORS { 4 } else { 1 };
        rays * RayRecords::RAY_BYTES.max(Self::PLANE_BYTES * (2 + u64::from(ways)))
    }

    /// Makes the kernels and empty buffers.
    #[must_use]
    pub fn new(gpu: &Gpu, layers: OnwardLayers) -> Self {
        let kernel = |path, entry| Kernel::new(gpu, path, entry, &[]);
        let OnwardLayers { many, least_part, most } = layers;
        let layers = [("MANY_LAYERS", many.into()), ("LEAST_PART", least_part.into()), ("MOST_LAYERS", most.into())];
        Self {
            hierarchy: Hierarchy::new(gpu),
            passed: Hierarchy::new(gpu),
            tracer: RayTracer::new(gpu, Self::OPTIONS),
            count: kernel("onward::count", "count"),
            scan: Scan::new(gpu),
            locate: kernel("onward::locate", "locate"),
            send: Kernel::new(gpu, "onward::send", "send", &layers),
            meet: kernel("onward::meet", "meet"),
            add: kernel("onward::add", "add"),
            point_view: Buffer::uniform(gpu, "view of points"),
            from: Step::new(gpu),
            rays: Step::new(gpu),
            starts: Buffer::storage(gpu, "starts of rays"),
            lights: OnwardLights::new(gpu),
            meetings: Buffer::storage(gpu, "meetings"),
            planes: Buffer::storage(gpu, "film of rays"),
            total: Fetch::default(),
            light: OnwardLight::default(),
            ways: 0,
            flat_plane_of_film: ShadeScene::NO_WORD,
        }
    }

    /// Uploads the hierarchy of a frame.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn build(&mut self, gpu: &Gpu, bvh: &Bvh) -> Result<(), GpuError> {
        self.hierarchy.write(gpu, bvh)
    }

    /// Uploads the hierarchy of a frame's transmissive triangles; `ids` are their ids in the whole frame.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn build_passed(&mut self, gpu: &Gpu, bvh: &Bvh, ids: &[u32]) -> Result<(), GpuError> {
        self.passed.write_some(gpu, bvh, ids)
    }

    /// Prepares to follow the camera rays of a band of rows, by the film's planes of ways.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn start(
        &mut self,
        gpu: &Gpu,
        band: &Band,
        offset_pixels: DVec2,
        film: &FilmPlanes,
        light: OnwardLight,
    ) -> Result<(), GpuError> {
        let count = band.order().slots() as u32;
        self.point_view.write(gpu, &[PointView::new(band, offset_pixels)])?;
        (self.ways, self.light) = (film.ways(), light);
        self.flat_plane_of_film = film.flat_plane().unwrap_or(ShadeScene::NO_WORD);
        let ways_plane = film.ways_plane().unwrap_or(ShadeScene::NO_WORD);
        let step = OnwardStep { is_first: 1, size: band.size(), ways_plane, ..self.step(count) };
        self.from.write(gpu, step)?;
        self.prepare_count(gpu)
    }

    /// Parameters of a generation of `count` rays with planes of their own.
    fn step(&self, count: u32) -> OnwardStep {
        let has_flat = self.flat_plane_of_film != ShadeScene::NO_WORD;
        OnwardStep {
            count,
            is_first: 0,
            size: [count, 1],
            ways_plane: count * (1 + u32::from(has_flat)),
            ways: self.ways,
            is_asked_first: u32::from(self.light.is_asked_first()),
            flat_plane: if has_flat { count } else { ShadeScene::NO_WORD },
            flat_plane_of_film: self.flat_plane_of_film,
            unused: 0,
        }
    }

    fn prepare_count(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        self.starts.reserve(gpu, 4 * u64::from(self.from.count))?;
        self.scan.prepare(gpu, self.from.count)
    }

    /// Prepares for the queries that are [traced first](OnwardLight::is_asked_first), about the camera rays' hits.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn prepare_first(&mut self, gpu: &Gpu, lights: &[Option<LightSource>]) -> Result<(), GpuError> {
        let Self { from, lights: of_lights, tracer, light, .. } = self;
        of_lights.prepare(gpu, from.count, lights, *light, Self::OPTIONS.lanes())?;
        tracer.prepare(gpu, from.count, of_lights.uses(*light, true))
    }

    /// Records the camera rays' hit points and the queries about them. `seen` are the visible triangles, `lit` the
    /// visibility of lights.
    pub fn record_first(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        [film, seen, lit]: [&Buffer; 3],
        shade: &Shade,
    ) {
        recorder.stage("locate", |pass| self.record_locate(gpu, pass, geometry, [film, seen]));
        let Self { hierarchy, passed, tracer, from, light, .. } = self;
        let asked = Asked { geometry, hierarchy, passed, shade, light: *light, seen };
        self.lights.record(gpu, recorder, tracer, from, &asked, Some(lit));
    }

    fn record_locate(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        geometry: &Geometry,
        [film, seen]: [&Buffer; 2],
    ) {
        let Self { from, point_view, .. } = self;
        let (triangles, positions) = (geometry.triangles(), geometry.positions());
        let records = from.records.buffer();
        let buffers = [&from.parameters, point_view, film, seen, triangles, positions, &from.points, records];
        self.locate.dispatch(gpu, pass, &buffers, from.groups());
    }

    /// The first word of transmittances in [`Onward::lit`], behind the bits of all lights; [`ShadeScene::NO_WORD`]
    /// without any.
    #[must_use]
    pub fn tints_word(&self) -> u32 {
        if self.light.takes_colors { self.lights.tints_word() } else { ShadeScene::NO_WORD }
    }

    /// Checks the finished first queries. Where memory was too small, reserves more and returns false: all has to be
    /// [recorded](Onward::record_first) again.
    ///
    /// # Errors
    /// Where the device is lost, or a buffer would exceed its limit.
    pub fn finish_first(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        let fits = self.tracer.finish(gpu, done)?;
        if !fits {
            self.tracer.prepare(gpu, self.from.count, self.lights.uses(self.light, true))?;
        }
        Ok(fits)
    }

    /// Records the count of rays spawned by a generation, from `film` for the camera's rays, else from its own planes.
    pub fn record_count(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, film: &Buffer) {
        let Self { from, starts, .. } = self;
        let planes = if from.is_first { film } else { &self.planes };
        recorder.stage("count", |pass| {
            self.count.dispatch(gpu, pass, &[&from.parameters, planes, starts], from.groups());
            self.scan.record(gpu, pass, starts);
        });
        self.total = recorder.fetch_from(self.scan.totals(), self.scan.total_word().into(), 1);
    }

    /// The number of rays counted.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn counted(&self, done: &Done) -> Result<u32, GpuError> {
        Ok(done.read::<u32>(self.total)?[0])
    }

    /// Reserves memory for `rays` and lights; `None` stands for a light without shadows.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn prepare(&mut self, gpu: &Gpu, rays: u32, lights: &[Option<LightSource>]) -> Result<(), GpuError> {
        let (step, packet, light) = (self.step(rays), Self::OPTIONS.lanes(), self.light);
        self.rays.write(gpu, step)?;
        self.rays.records.write_count(gpu, rays, packet)?;
        self.meetings.reserve(gpu, Self::MEETING_BYTES * u64::from(rays))?;
        self.lights.prepare(gpu, rays, lights, light, packet)?;
        self.tracer.prepare(gpu, rays, 1 + self.lights.uses(light, false))
    }

    /// Records the rays, their hits, and the visibility of lights there. `film` and `seen` belong to the camera's rays.
    pub fn record_rays(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        [film, seen]: [&Buffer; 2],
        shade: &Shade,
    ) {
        if self.from.is_first && !self.light.is_asked_first() {
            recorder.stage("locate", |pass| self.record_locate(gpu, pass, geometry, [film, seen]));
        }
        let Self { from, rays, starts, tracer, hierarchy, passed, meetings, light, .. } = self;
        let planes = if from.is_first { film } else { &self.planes };
        recorder.stage("send", |pass| {
            let [of_rays, before] = [&*rays, &*from].map(|step| [step.records.buffer(), &step.paths]);
            let buffers =
                [&from.parameters, planes, starts, &from.points, of_rays[0], of_rays[1], before[0], before[1]];
            self.send.dispatch(gpu, pass, &buffers, from.groups());
        });
        tracer.record_nearest(gpu, recorder, geometry, hierarchy, &rays.records);
        let buffers = [rays.records.buffer(), tracer.hits(), &rays.paths, &rays.points, meetings];
        recorder.stage("meet", |pass| self.meet.dispatch(gpu, pass, &buffers, rays.groups()));
        let asked = Asked { geometry, hierarchy, passed, shade, light: *light, seen: meetings };
        self.lights.record(gpu, recorder, tracer, rays, &asked, None);
    }

    /// Checks the finished rays, and reserves memory for their planes. Where the tracer's memory was too small, reserves
    /// more and returns false: the rays have to be [recorded](Onward::record_rays) again.
    ///
    /// # Errors
    /// Where the device is lost, or a buffer would exceed its limit.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        let fits = self.tracer.finish(gpu, done)?;
        if fits {
            // Only now, since the planes of the previous generation were read to send these rays.
            let planes = 1 + u64::from(self.flat_plane_of_film != ShadeScene::NO_WORD) + u64::from(self.ways);
            self.planes.reserve(gpu, planes * Self::PLANE_BYTES * u64::from(self.rays.count))?;
        } else {
            let uses = 1 + self.lights.uses(self.light, false);
            self.tracer.prepare(gpu, self.rays.count, uses)?;
        }
        Ok(fits)
    }

    /// Records the addition of the rays' colours to the film.
    pub fn record_add(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, film: &Buffer) {
        let Self { rays, planes, .. } = self;
        let buffers = [&rays.parameters, planes, &rays.paths, film];
        recorder.stage("add", |pass| self.add.dispatch(gpu, pass, &buffers, rays.groups()));
    }

    /// Makes these rays the previous generation.
    ///
    /// # Errors
    /// Where a buffer would exceed the device's limit.
    pub fn advance(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        std::mem::swap(&mut self.from, &mut self.rays);
        self.prepare_count(gpu)
    }

    /// The number of rays and the offsets of their planes.
    pub(crate) fn shaded(&self) -> OnwardPlanes {
        let Self { rays, .. } = self;
        let OnwardStep { ways_plane, flat_plane, .. } = self.step(rays.count);
        OnwardPlanes { rays: rays.count, ways_plane, ways: self.ways, flat_plane }
    }

    /// Effects on light besides opaque shadows.
    pub(crate) fn light(&self) -> OnwardLight {
        self.light
    }

    /// The rays' hits, as shading reads them.
    pub(crate) fn meetings(&self) -> &Buffer {
        &self.meetings
    }

    /// Visibility of lights from the last points: for each light a bit per ray, then transmittances.
    #[must_use]
    pub fn lit(&self) -> &Buffer {
        &self.lights.lit
    }

    /// Shading's output: the rays' colours and ways.
    pub(crate) fn planes(&self) -> &Buffer {
        &self.planes
    }

    /// Bytes on the GPU for hierarchies and for rays.
    #[must_use]
    pub fn bytes(&self) -> [u64; 2] {
        let Self { from, rays, starts, meetings, planes, lights, .. } = self;
        let buffers = [starts, meetings, planes].into_iter().map(Buffer::bytes).sum::<u64>();
        [
            self.hierarchy.bytes() + self.passed.bytes(),
            self.tracer.bytes() + from.bytes() + rays.bytes() + lights.bytes() + buffers,
        ]
    }
}

/// Layout of the planes of secondary rays, for shading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnwardPlanes {
    pub(crate) rays: u32,
    pub(crate) ways_plane: u32,
    pub(crate) ways: u32,
    pub(crate) flat_plane: u32,
}
