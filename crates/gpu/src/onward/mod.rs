//! Rays that go on from mirrors, through glass and straight on behind what is seen through, generation by generation:
//! `umbrage/src/cpu/onward.rs`, through a kd-tree.
//!
//! Shading leaves planes beside the film (`way.wgsl`), which say where light comes to each pixel from. `count` and a scan give the
//! rays that follow from these their numbers, in the order of their pixels; `locate` finds where the camera's rays have met
//! their triangles, as exactly as a ray's hit; `send` writes them. The tracer of `kdtree` finds what they hit: where they start
//! on a triangle, neither that nor any whose plane their start can't be told from. `meet` has that ready for lights and for
//! shading, whose rays have planes of their own: a colour, which `add` sums up for each pixel in the order of the rays, and
//! where light comes from.
//!
//! Lights (`lights`) are asked about by `ask`, the tracer again and the kd-tree's `lit`. Where something is seen through, the
//! tracer lists what their light passes through, shading's `tint` says what is left of it, and `tinted` keeps that. Of what the
//! camera sees, the engine's structure has found which lights reach it; so only colours are asked for.
//!
//! The CPU asks how many rays a generation has, and so makes room for that many.

mod lights;
mod step;

use glam::DVec2;
use umbrage_rays::{KdTree, LightSource};

use crate::kdtree::{KdNodes, KdSight, KdTracer, KdTracerOptions};
use crate::primitives::Scan;
use crate::shade::{FilmPlanes, Shade, ShadeScene};
use crate::view::PointView;
use crate::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Kernel, Recorder};
pub use lights::OnwardLight;
pub(crate) use lights::mask_words;
use lights::{Asked, OnwardLights};
use step::{OnwardStep, Step};

/// Follows rays that go on: a generation at a time, which is [counted](Onward::record_count), [traced](Onward::record_rays),
/// shaded by [`Shade`] and [added](Onward::record_add) to the film.
#[derive(Debug)]
pub struct Onward {
    nodes: KdNodes,
    /// Of what lets light through.
    passed: KdNodes,
    tracer: KdTracer,
    count: Kernel,
    scan: Scan,
    locate: Kernel,
    send: Kernel,
    meet: Kernel,
    add: Kernel,
    point_view: Buffer,
    /// The generation from which rays go on, and that of these rays.
    from: Step,
    rays: Step,
    starts: Buffer,
    lights: OnwardLights,
    meetings: Buffer,
    /// What the rays of a generation show.
    planes: Buffer,
    total: Fetch,
    light: OnwardLight,
    /// Of the film.
    ways: u32,
    flat_plane_of_film: u32,
}

impl Onward {
    /// How many planes say where mirrors lead.
    pub const MIRRORS: u32 = 2;
    /// How many planes say where light comes from where something is seen through.
    pub const ALL_WAYS: u32 = 6;
    /// How many planes say where light comes from where rough surfaces are followed too.
    pub const GLOSSY_WAYS: u32 = 7;
    const MEETING_BYTES: u64 = 80;
    const PLANE_BYTES: u64 = 16;
    const OPTIONS: KdTracerOptions = KdTracerOptions { from_triangles: true, ..KdTracerOptions::DEFAULT };

    /// The most that it holds for a pixel in one buffer: of generations of up to four rays a pixel where light comes by several
    /// ways.
    #[must_use]
    pub fn pixel_bytes(ways: u32) -> u64 {
        let rays = if ways > Self::MIRRORS { 4 } else { 1 };
        rays * KdSight::PIXEL_BYTES.max(Self::PLANE_BYTES * (2 + u64::from(ways)))
    }

    /// Ready to take over a tree.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let kernel = |path, entry| Kernel::new(gpu, path, entry, &[]);
        Self {
            nodes: KdNodes::new(gpu),
            passed: KdNodes::new(gpu),
            tracer: KdTracer::new(gpu, Self::OPTIONS),
            count: kernel("onward::count", "count"),
            scan: Scan::new(gpu),
            locate: kernel("onward::locate", "locate"),
            send: kernel("onward::send", "send"),
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

    /// Takes over the tree of a frame.
    ///
    /// # Errors
    /// Where it needs more than one buffer of the device has room for.
    pub fn build(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        self.nodes.write(gpu, tree)
    }

    /// Takes over the tree of those of a frame's triangles that let light through, which have these ids in the whole frame.
    ///
    /// # Errors
    /// Where it needs more than one buffer of the device has room for.
    pub fn build_passed(&mut self, gpu: &Gpu, tree: &KdTree, ids: &[u32]) -> Result<(), GpuError> {
        self.passed.write_some(gpu, tree, ids)
    }

    /// Makes ready to go on from the camera's rays through some rows of an image, as a film with planes of ways says.
    ///
    /// # Errors
    /// Where something needs more than one buffer of the device has room for.
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

    /// Some rays and their planes.
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

    /// Makes ready for what is [asked first](OnwardLight::is_asked_first) of what the camera sees.
    ///
    /// # Errors
    /// Where something needs more than one buffer of the device has room for.
    pub fn prepare_first(&mut self, gpu: &Gpu, lights: &[Option<LightSource>]) -> Result<(), GpuError> {
        let Self { from, lights: of_lights, tracer, light, .. } = self;
        of_lights.prepare(gpu, from.count, lights, *light, Self::OPTIONS.lanes())?;
        tracer.prepare(gpu, from.count, of_lights.uses(*light, true))
    }

    /// Records what the camera's rays have met, and what is asked about that; `seen` and `lit` are what it sees and which lights
    /// reach that.
    pub fn record_first(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        [film, seen, lit]: [&Buffer; 3],
        shade: &Shade,
    ) {
        recorder.stage("locate", |pass| self.record_locate(gpu, pass, geometry, [film, seen]));
        let Self { nodes, passed, tracer, from, light, .. } = self;
        let asked = Asked { geometry, nodes, passed, shade, light: *light, seen };
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

    /// Where [`Onward::lit`] has colours, behind the bits of all lights; [`ShadeScene::NO_WORD`] for nowhere.
    #[must_use]
    pub fn tints_word(&self) -> u32 {
        if self.light.takes_colors { self.lights.tints_word() } else { ShadeScene::NO_WORD }
    }

    /// Looks at what was asked first and is done. Where there was too little room, it makes more and answers false: then all has
    /// to be [recorded](Onward::record_first) again.
    ///
    /// # Errors
    /// Where the device is lost, or something needs more than one buffer of it has room for.
    pub fn finish_first(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        let fits = self.tracer.finish(gpu, done)?;
        if !fits {
            self.tracer.prepare(gpu, self.from.count, self.lights.uses(self.light, true))?;
        }
        Ok(fits)
    }

    /// Records how many rays go on from a generation, whose planes these are: the film's, or its own.
    pub fn record_count(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, film: &Buffer) {
        let Self { from, starts, .. } = self;
        let planes = if from.is_first { film } else { &self.planes };
        recorder.stage("count", |pass| {
            self.count.dispatch(gpu, pass, &[&from.parameters, planes, starts], from.groups());
            self.scan.record(gpu, pass, starts);
        });
        self.total = recorder.fetch_from(self.scan.totals(), self.scan.total_word().into(), 1);
    }

    /// How many rays were counted.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn counted(&self, done: &Done) -> Result<u32, GpuError> {
        Ok(done.read::<u32>(self.total)?[0])
    }

    /// Makes room for so many rays, and for lights; `None` stands for a light that nothing keeps away.
    ///
    /// # Errors
    /// Where something needs more than one buffer of the device has room for.
    pub fn prepare(&mut self, gpu: &Gpu, rays: u32, lights: &[Option<LightSource>]) -> Result<(), GpuError> {
        let (step, packet, light) = (self.step(rays), Self::OPTIONS.lanes(), self.light);
        self.rays.write(gpu, step)?;
        self.rays.records.write_count(gpu, rays, packet)?;
        self.meetings.reserve(gpu, Self::MEETING_BYTES * u64::from(rays))?;
        self.lights.prepare(gpu, rays, lights, light, packet)?;
        self.tracer.prepare(gpu, rays, 1 + self.lights.uses(light, false))
    }

    /// Records the rays, what they hit, and which lights reach it. `film` and `seen` are what the camera's rays have shown.
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
        let Self { from, rays, starts, tracer, nodes, passed, meetings, light, .. } = self;
        let planes = if from.is_first { film } else { &self.planes };
        recorder.stage("send", |pass| {
            let [of_rays, before] = [&*rays, &*from].map(|step| [step.records.buffer(), &step.paths]);
            let buffers =
                [&from.parameters, planes, starts, &from.points, of_rays[0], of_rays[1], before[0], before[1]];
            self.send.dispatch(gpu, pass, &buffers, from.groups());
        });
        tracer.record_nearest(gpu, recorder, geometry, nodes, &rays.records);
        let buffers = [rays.records.buffer(), tracer.hits(), &rays.paths, &rays.points, meetings];
        recorder.stage("meet", |pass| self.meet.dispatch(gpu, pass, &buffers, rays.groups()));
        let asked = Asked { geometry, nodes, passed, shade, light: *light, seen: meetings };
        self.lights.record(gpu, recorder, tracer, rays, &asked, None);
    }

    /// Looks at what the rays needed that are done, and makes room for what they show. Where the tracer had too little room, it
    /// makes more and answers false: then they have to be [recorded](Onward::record_rays) again.
    ///
    /// # Errors
    /// Where the device is lost, or something needs more than one buffer of it has room for.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        let fits = self.tracer.finish(gpu, done)?;
        if fits {
            // Only now: the last generation's planes said where these rays go.
            let planes = 1 + u64::from(self.flat_plane_of_film != ShadeScene::NO_WORD) + u64::from(self.ways);
            self.planes.reserve(gpu, planes * Self::PLANE_BYTES * u64::from(self.rays.count))?;
        } else {
            let uses = 1 + self.lights.uses(self.light, false);
            self.tracer.prepare(gpu, self.rays.count, uses)?;
        }
        Ok(fits)
    }

    /// Records that the film's pixels get what the rays show.
    pub fn record_add(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, film: &Buffer) {
        let Self { rays, planes, .. } = self;
        let buffers = [&rays.parameters, planes, &rays.paths, film];
        recorder.stage("add", |pass| self.add.dispatch(gpu, pass, &buffers, rays.groups()));
    }

    /// Makes ready to go on from these rays.
    ///
    /// # Errors
    /// Where something needs more than one buffer of the device has room for.
    pub fn advance(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        std::mem::swap(&mut self.from, &mut self.rays);
        self.prepare_count(gpu)
    }

    /// How many rays there are, and where their planes are.
    pub(crate) fn shaded(&self) -> OnwardPlanes {
        let Self { rays, .. } = self;
        let OnwardStep { ways_plane, flat_plane, .. } = self.step(rays.count);
        OnwardPlanes { rays: rays.count, ways_plane, ways: self.ways, flat_plane }
    }

    /// What else than lights keep away matters.
    pub(crate) fn light(&self) -> OnwardLight {
        self.light
    }

    /// What the rays have met, as shading reads it.
    pub(crate) fn meetings(&self) -> &Buffer {
        &self.meetings
    }

    /// Which lights reach what was asked about last: for each a bit a ray, then colours.
    #[must_use]
    pub fn lit(&self) -> &Buffer {
        &self.lights.lit
    }

    /// Where shading says what the rays show, and where they go on.
    pub(crate) fn planes(&self) -> &Buffer {
        &self.planes
    }

    /// Bytes on the GPU for triangles, and for rays under way.
    #[must_use]
    pub fn bytes(&self) -> [u64; 2] {
        let Self { from, rays, starts, meetings, planes, lights, .. } = self;
        let buffers = [starts, meetings, planes].into_iter().map(Buffer::bytes).sum::<u64>();
        [
            self.nodes.bytes() + self.passed.bytes(),
            self.tracer.bytes() + from.bytes() + rays.bytes() + lights.bytes() + buffers,
        ]
    }
}

/// What shading has to know of rays that go on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnwardPlanes {
    pub(crate) rays: u32,
    pub(crate) ways_plane: u32,
    pub(crate) ways: u32,
    pub(crate) flat_plane: u32,
}
