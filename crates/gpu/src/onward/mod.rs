//! Rays that go on from mirrors, generation by generation: `umbrage/src/cpu/onward.rs`, through a kd-tree.
//!
//! Shading leaves two planes beside the film, which say where each pixel's mirror leads. `count` and a scan give the rays that
//! follow from these their places, in the order of their pixels; `locate` finds where on their triangles those of the camera's
//! rays start, as exactly as a ray's hit; `send` writes them. The tracer of `kdtree` finds what they hit: not their own
//! triangle, nor any whose plane their start can't be told from. `meet` has that ready for lights (`ask`, the tracer again, and
//! the kd-tree's `lit`) and for shading, whose rays have planes of their own: a colour, which `add` sums up for each pixel in
//! the order of the rays, and where the next mirror leads.
//!
//! The CPU asks how many rays a generation has, and so makes room for that many.

use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use umbrage_rays::{KdTree, LightSource};

use crate::kdtree::{KdLight, KdNodes, KdRecords, KdTracer, KdTracerOptions};
use crate::primitives::Scan;
use crate::view::PointView;
use crate::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// Follows rays that go on from mirrors: a generation at a time, which is [counted](Onward::record_count),
/// [traced](Onward::record_rays), shaded by [`Shade`](crate::shade::Shade) and [added](Onward::record_add) to the film.
#[derive(Debug)]
pub struct Onward {
    nodes: KdNodes,
    tracer: KdTracer,
    count: Kernel,
    scan: Scan,
    locate: Kernel,
    send: Kernel,
    meet: Kernel,
    ask: Kernel,
    light: Kernel,
    add: Kernel,
    point_view: Buffer,
    /// The generation from which rays go on, and that of these rays.
    from: Step,
    rays: Step,
    starts: Buffer,
    paths: Buffer,
    records: KdRecords,
    questions: KdRecords,
    /// One for each light: all are in use in one submission.
    lights: Vec<Buffer>,
    /// For each light whether anything keeps it away.
    casts_shadow: Vec<bool>,
    meetings: Buffer,
    lit: Buffer,
    /// What the rays of a generation show.
    planes: Buffer,
    total: Fetch,
}

/// A generation of rays.
#[derive(Debug)]
struct Step {
    parameters: Buffer,
    /// Where they have met something.
    points: Buffer,
    count: u32,
    is_first: bool,
}

/// As in `step.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct OnwardStep {
    count: u32,
    is_first: u32,
    size: [u32; 2],
    ways_plane: u32,
    unused: u32,
}

impl Step {
    const POINT_BYTES: u64 = 40;

    fn new(gpu: &Gpu) -> Self {
        let (parameters, points) = (Buffer::uniform(gpu, "generation"), Buffer::storage(gpu, "points of rays"));
        Self { parameters, points, count: 0, is_first: false }
    }

    fn write(&mut self, gpu: &Gpu, parameters: OnwardStep) -> Result<(), GpuError> {
        (self.count, self.is_first) = (parameters.count, parameters.is_first != 0);
        self.parameters.write(gpu, &[parameters])?;
        self.points.reserve(gpu, Self::POINT_BYTES * u64::from(self.count))
    }

    fn groups(&self) -> Groups<'_> {
        Groups::Flat(self.count.div_ceil(64))
    }
}

impl Onward {
    const PATH_BYTES: u64 = 32;
    const MEETING_BYTES: u64 = 44;
    const PLANE_BYTES: u64 = 16;
    const OPTIONS: KdTracerOptions = KdTracerOptions { from_triangles: true, ..KdTracerOptions::DEFAULT };

    /// Ready to take over a tree.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let kernel = |path, entry| Kernel::new(gpu, path, entry, &[]);
        Self {
            nodes: KdNodes::new(gpu),
            tracer: KdTracer::new(gpu, Self::OPTIONS),
            count: kernel("onward::count", "count"),
            scan: Scan::new(gpu),
            locate: kernel("onward::locate", "locate"),
            send: kernel("onward::send", "send"),
            meet: kernel("onward::meet", "meet"),
            ask: kernel("onward::ask", "ask"),
            light: kernel("kdtree::lit", "lit"),
            add: kernel("onward::add", "add"),
            point_view: Buffer::uniform(gpu, "view of points"),
            from: Step::new(gpu),
            rays: Step::new(gpu),
            starts: Buffer::storage(gpu, "starts of rays"),
            paths: Buffer::storage(gpu, "paths"),
            records: KdRecords::new(gpu),
            questions: KdRecords::new(gpu),
            lights: Vec::new(),
            casts_shadow: Vec::new(),
            meetings: Buffer::storage(gpu, "meetings"),
            lit: Buffer::storage(gpu, "lit in mirrors"),
            planes: Buffer::storage(gpu, "film of rays"),
            total: Fetch::default(),
        }
    }

    /// Takes over the tree of a frame.
    ///
    /// # Errors
    /// Where it needs more than one buffer of the device has room for.
    pub fn build(&mut self, gpu: &Gpu, tree: &KdTree) -> Result<(), GpuError> {
        self.nodes.write(gpu, tree)
    }

    /// Makes ready to go on from the camera's rays through some rows of an image, whose mirrors are in two planes of the film
    /// from the pixel `ways_plane` on.
    ///
    /// # Errors
    /// Where something needs more than one buffer of the device has room for.
    pub fn start(&mut self, gpu: &Gpu, band: &Band, offset_pixels: DVec2, ways_plane: u32) -> Result<(), GpuError> {
        let count = band.order().slots() as u32;
        self.point_view.write(gpu, &[PointView::new(band, offset_pixels)])?;
        let step = OnwardStep { count, is_first: 1, size: band.size(), ways_plane, unused: 0 };
        self.from.write(gpu, step)?;
        self.prepare_count(gpu)
    }

    fn prepare_count(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        self.starts.reserve(gpu, 4 * u64::from(self.from.count))?;
        self.scan.prepare(gpu, self.from.count)
    }

    /// Records how many rays go on from a generation, whose planes these are: the film's, or [its own](Onward::planes).
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
        let step = OnwardStep { count: rays, is_first: 0, size: [rays, 1], ways_plane: rays, unused: 0 };
        self.rays.write(gpu, step)?;
        let (packet, words) = (Self::OPTIONS.lanes(), Self::mask_words(rays));
        for records in [&mut self.records, &mut self.questions] {
            records.reserve(gpu, rays)?;
            records.write_count(gpu, rays, packet)?;
        }
        self.paths.reserve(gpu, Self::PATH_BYTES * u64::from(rays))?;
        self.meetings.reserve(gpu, Self::MEETING_BYTES * u64::from(rays))?;
        self.lit.reserve(gpu, 4 * u64::from(words) * lights.len() as u64)?;
        while self.lights.len() < lights.len() {
            self.lights.push(Buffer::uniform(gpu, "light"));
        }
        for ((buffer, light), number) in self.lights.iter_mut().zip(lights).zip(0..) {
            buffer.write(gpu, &[KdLight::new(light.as_ref(), packet, number * words)])?;
        }
        self.casts_shadow.clear();
        self.casts_shadow.extend(lights.iter().map(Option::is_some));
        let uses = 1 + self.casts_shadow.iter().filter(|casts| **casts).count() as u32;
        self.tracer.prepare(gpu, rays, uses)
    }

    /// Words of a light's mask, whole workgroups of rays.
    pub(crate) fn mask_words(rays: u32) -> u32 {
        2 * rays.div_ceil(64)
    }

    /// Records the rays, what they hit, and which lights reach it. `film` and `seen` are what the camera's rays have shown.
    pub fn record_rays(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        [film, seen]: [&Buffer; 2],
    ) {
        let Self { from, rays, starts, paths, records, questions, tracer, nodes, meetings, .. } = self;
        let planes = if from.is_first { film } else { &self.planes };
        let (triangles, positions) = (geometry.triangles(), geometry.positions());
        recorder.stage("send", |pass| {
            if from.is_first {
                let buffers = [&from.parameters, &self.point_view, planes, seen, triangles, positions, &from.points];
                self.locate.dispatch(gpu, pass, &buffers, from.groups());
            }
            let buffers = [&from.parameters, planes, starts, &from.points, records.buffer(), paths];
            self.send.dispatch(gpu, pass, &buffers, from.groups());
        });
        tracer.record_nearest(gpu, recorder, geometry, nodes, records);
        let buffers = [records.buffer(), tracer.hits(), paths, &rays.points, meetings];
        recorder.stage("meet", |pass| self.meet.dispatch(gpu, pass, &buffers, rays.groups()));
        for (light, casts_shadow) in self.lights.iter().zip(&self.casts_shadow) {
            let buffers = [light, &rays.points, questions.buffer()];
            recorder.stage("ask", |pass| self.ask.dispatch(gpu, pass, &buffers, rays.groups()));
            if *casts_shadow {
                tracer.record_blocked(gpu, recorder, geometry, nodes, questions);
            }
            let buffers = [light, questions.buffer(), tracer.shadows(), &self.lit];
            recorder.stage("lit", |pass| self.light.dispatch(gpu, pass, &buffers, rays.groups()));
        }
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
            self.planes.reserve(gpu, 3 * Self::PLANE_BYTES * u64::from(self.rays.count))?;
        } else {
            let uses = 1 + self.casts_shadow.iter().filter(|casts| **casts).count() as u32;
            self.tracer.prepare(gpu, self.rays.count, uses)?;
        }
        Ok(fits)
    }

    /// Records that the film's pixels get what the rays show.
    pub fn record_add(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, film: &Buffer) {
        let Self { rays, planes, paths, .. } = self;
        let buffers = [&rays.parameters, planes, paths, film];
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

    /// How many rays there are.
    pub(crate) fn rays(&self) -> u32 {
        self.rays.count
    }

    /// What they have met, as shading reads it.
    pub(crate) fn meetings(&self) -> &Buffer {
        &self.meetings
    }

    /// For each light a bit a ray.
    pub(crate) fn lit(&self) -> &Buffer {
        &self.lit
    }

    /// Where shading says what they show, and where they go on: three planes of four f32 a ray.
    pub(crate) fn planes(&self) -> &Buffer {
        &self.planes
    }

    /// Bytes on the GPU for triangles, and for rays under way.
    #[must_use]
    pub fn bytes(&self) -> [u64; 2] {
        let Self { from, rays, starts, paths, records, questions, meetings, lit, planes, .. } = self;
        let (records, questions) = (records.buffer(), questions.buffer());
        let buffers = [&from.points, &rays.points, starts, paths, records, questions, meetings, lit, planes];
        [self.nodes.bytes(), self.tracer.bytes() + buffers.into_iter().map(Buffer::bytes).sum::<u64>()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn parameters_are_those_of_the_shaders() {
        let layout = layout!(OnwardStep { count, is_first, size, ways_plane });
        for path in ["onward::count", "onward::locate", "onward::send", "onward::add"] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }
}
