use umbrage_rays::LightSource;

use super::step::Step;
use crate::kdtree::{KdLight, KdNodes, KdRecords, KdTracer};
use crate::shade::Shade;
use crate::{Buffer, Geometry, Gpu, GpuError, Kernel, Recorder};

/// Which lights reach what a generation's rays have met, and how much of each comes through what is before it.
#[derive(Debug)]
pub(super) struct OnwardLights {
    ask: Kernel,
    light: Kernel,
    tinted: Kernel,
    questions: KdRecords,
    /// One for each light: all are in use in one submission.
    lights: Vec<Buffer>,
    /// For each light whether anything keeps it away.
    casts_shadow: Vec<bool>,
    /// For each light a bit a ray; then, where light takes colours, for each light two words a ray.
    pub(super) lit: Buffer,
    words: u32,
}

/// What lights are asked with.
pub(super) struct Asked<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) nodes: &'a KdNodes,
    /// What says what colours are left of light that passes through something, and the tree of that.
    pub(super) tints: Option<(&'a Shade, &'a KdNodes)>,
}

impl OnwardLights {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let kernel = |path, entry| Kernel::new(gpu, path, entry, &[]);
        Self {
            ask: kernel("onward::ask", "ask"),
            light: kernel("kdtree::lit", "lit"),
            tinted: kernel("onward::tinted", "tinted"),
            questions: KdRecords::new(gpu),
            lights: Vec::new(),
            casts_shadow: Vec::new(),
            lit: Buffer::storage(gpu, "lit in mirrors"),
            words: 0,
        }
    }

    /// Makes room for so many points. `None` stands for a light that nothing keeps away.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        points: u32,
        lights: &[Option<LightSource>],
        has_tints: bool,
        packet: u32,
    ) -> Result<(), GpuError> {
        self.words = mask_words(points);
        self.questions.reserve(gpu, points)?;
        self.questions.write_count(gpu, points, packet)?;
        let tints = tints_word(points, lights.len());
        let of_tints = if has_tints { 64 * u64::from(tints) } else { 0 };
        self.lit.reserve(gpu, 4 * (u64::from(tints) + of_tints))?;
        while self.lights.len() < lights.len() {
            self.lights.push(Buffer::uniform(gpu, "light"));
        }
        for ((buffer, light), number) in self.lights.iter_mut().zip(lights).zip(0..) {
            buffer.write(gpu, &[KdLight::new(light.as_ref(), packet, number * self.words, tints)])?;
        }
        self.casts_shadow.clear();
        self.casts_shadow.extend(lights.iter().map(Option::is_some));
        Ok(())
    }

    /// How often the tracer is asked about what a generation has met, or about what is known to be lit.
    pub(super) fn uses(&self, has_tints: bool, is_lit_known: bool) -> u32 {
        let each = u32::from(!is_lit_known) + u32::from(has_tints);
        each * self.casts_shadow.iter().filter(|casts| **casts).count() as u32
    }

    /// Records which lights reach the points, unless `known` has that in the first words of this buffer, and the colours.
    pub(super) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        tracer: &mut KdTracer,
        step: &Step,
        asked: &Asked<'_>,
        known: Option<&Buffer>,
    ) {
        let Self { questions, lit, .. } = self;
        let Asked { geometry, nodes, tints } = *asked;
        if let Some(known) = known {
            recorder.copy_words(known, lit, u64::from(self.words) * self.casts_shadow.len() as u64);
        }
        for (light, &casts_shadow) in self.lights.iter().zip(&self.casts_shadow) {
            let buffers = [light, &step.points, questions.buffer()];
            recorder.stage("ask", |pass| self.ask.dispatch(gpu, pass, &buffers, step.groups()));
            if known.is_none() {
                if casts_shadow {
                    tracer.record_blocked(gpu, recorder, geometry, nodes, questions);
                }
                let buffers = [light, questions.buffer(), tracer.shadows(), lit];
                recorder.stage("lit", |pass| self.light.dispatch(gpu, pass, &buffers, step.groups()));
            }
            let Some((shade, passed)) = tints else { continue };
            if casts_shadow {
                tracer.record_passed(gpu, recorder, geometry, passed, questions);
                let of_points = [tracer.passed(), tracer.shadows()];
                recorder.stage("tint", |pass| shade.record_tint(gpu, pass, geometry, of_points, step.count));
            }
            let buffers = [light, questions.buffer(), tracer.shadows(), tracer.passed(), lit];
            recorder.stage("tint", |pass| self.tinted.dispatch(gpu, pass, &buffers, step.groups()));
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.questions.buffer().bytes() + self.lit.bytes()
    }
}

/// Words of a light's bits, whole workgroups of rays.
pub(crate) fn mask_words(rays: u32) -> u32 {
    2 * rays.div_ceil(64)
}

/// Where colours begin, behind the bits of all lights.
pub(crate) fn tints_word(rays: u32, lights: usize) -> u32 {
    mask_words(rays) * lights as u32
}
