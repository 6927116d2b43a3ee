use glam::Vec3;
use umbrage_rays::LightSource;

use super::step::Step;
use crate::rays::{Hierarchy, RayRecords, RayTracer, ShadowLight};
use crate::shade::Shade;
use crate::{Buffer, Geometry, Gpu, GpuError, Kernel, Recorder};

/// Visibility of lights from the hits of a generation's rays, and transmittance of the surfaces between.
#[derive(Debug)]
pub(super) struct OnwardLights {
    ask: Kernel,
    ask_around: Kernel,
    light: Kernel,
    tinted: Kernel,
    questions: RayRecords,
    /// One buffer per light, since all are used in one submission.
    lights: Vec<Buffer>,
    /// For each light, whether triangles block it.
    casts_shadow: Vec<bool>,
    /// Each point's direction for ambient occlusion: three f32 and padding.
    directions: Buffer,
    /// For each light a bit per ray; then, with `takes_colors`, for each light two words per ray. Ambient occlusion is the
    /// last light.
    pub(super) lit: Buffer,
    words: u32,
    /// Number of lights, without ambient occlusion.
    count: usize,
}

/// Effects on light besides opaque shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnwardLight {
    /// Whether transmissive surfaces tint light on its way.
    pub takes_colors: bool,
    /// Radius of ambient occlusion in world units; 0 for none.
    pub around: f32,
}

impl OnwardLight {
    /// Whether queries about the camera rays' hits are traced before shading.
    #[must_use]
    pub fn is_asked_first(self) -> bool {
        self.takes_colors || self.around > 0.0
    }

    fn looks_around(self) -> bool {
        self.around > 0.0
    }
}

/// Inputs of the queries about lights.
pub(super) struct Asked<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) hierarchy: &'a Hierarchy,
    /// The hierarchy of transmissive triangles.
    pub(super) passed: &'a Hierarchy,
    pub(super) shade: &'a Shade,
    pub(super) light: OnwardLight,
    /// Shading's input about the points: the triangles of slots, or meetings.
    pub(super) seen: &'a Buffer,
}

impl OnwardLights {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let kernel = |path, entry| Kernel::new(gpu, path, entry, &[]);
        Self {
            ask: kernel("onward::ask", "ask"),
            ask_around: kernel("onward::ask_around", "ask_around"),
            light: kernel("rays::lit", "lit"),
            tinted: kernel("onward::tinted", "tinted"),
            questions: RayRecords::new(gpu),
            lights: Vec::new(),
            casts_shadow: Vec::new(),
            directions: Buffer::storage(gpu, "directions around points"),
            lit: Buffer::storage(gpu, "lit in mirrors"),
            words: 0,
            count: 0,
        }
    }

    /// Reserves memory for `points`. `None` stands for a light without shadows.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        points: u32,
        lights: &[Option<LightSource>],
        light: OnwardLight,
        packet: u32,
    ) -> Result<(), GpuError> {
        let all = lights.len() + usize::from(light.looks_around());
        (self.words, self.count) = (mask_words(points), lights.len());
        self.questions.reserve(gpu, points)?;
        self.questions.write_count(gpu, points, packet)?;
        let tints = mask_words(points) * all as u32;
        let of_tints = if light.takes_colors { 64 * u64::from(tints) } else { 0 };
        self.lit.reserve(gpu, 4 * (u64::from(tints) + of_tints))?;
        while self.lights.len() < all {
            self.lights.push(Buffer::uniform(gpu, "light"));
        }
        self.casts_shadow.clear();
        self.casts_shadow.extend(lights.iter().map(Option::is_some));
        // The occlusion radius takes the place of the light's position.
        let around = LightSource::Point { position: Vec3::new(light.around, 0.0, 0.0) };
        if light.looks_around() {
            self.casts_shadow.push(true);
            self.directions.reserve(gpu, 16 * u64::from(points))?;
        }
        let sources = lights.iter().map(Option::as_ref).chain([Some(&around)]);
        for ((buffer, light), number) in self.lights[..all].iter_mut().zip(sources).zip(0..) {
            buffer.write(gpu, &[ShadowLight::new(light, packet, number * self.words, tints)])?;
        }
        Ok(())
    }

    /// Number of traces for a generation's hits; fewer with `is_lit_known`.
    pub(super) fn uses(&self, light: OnwardLight, is_lit_known: bool) -> u32 {
        let (lights, around) = self.casts_shadow.split_at(self.count);
        let casting = lights.iter().filter(|casts| **casts).count() as u32;
        let around = around.len() as u32;
        casting * u32::from(!is_lit_known) + around + (casting + around) * u32::from(light.takes_colors)
    }

    /// Records the visibility of lights and their transmittance. `known` may have the visibility already, in its
    /// first words.
    pub(super) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        tracer: &mut RayTracer,
        step: &Step,
        asked: &Asked<'_>,
        known: Option<&Buffer>,
    ) {
        let Self { questions, lit, directions, .. } = self;
        let Asked { geometry, hierarchy, passed, shade, light: how, seen } = *asked;
        if let Some(known) = known {
            recorder.copy_words(known, lit, u64::from(self.words) * self.count as u64);
        }
        if how.looks_around() {
            let of_points = [seen, lit, directions];
            recorder.stage("look", |pass| shade.record_look(gpu, pass, geometry, of_points, step.count, step.is_first));
        }
        for (number, (light, &casts_shadow)) in self.lights.iter().zip(&self.casts_shadow).enumerate() {
            let is_around = number == self.count;
            recorder.stage("ask", |pass| {
                if is_around {
                    let buffers = [light, &step.points, directions, questions.buffer()];
                    self.ask_around.dispatch(gpu, pass, &buffers, step.groups());
                } else {
                    let buffers = [light, &step.points, questions.buffer()];
                    self.ask.dispatch(gpu, pass, &buffers, step.groups());
                }
            });
            if known.is_none() || is_around {
                if casts_shadow {
                    tracer.record_blocked(gpu, recorder, geometry, hierarchy, questions);
                }
                let buffers = [light, questions.buffer(), tracer.shadows(), lit];
                recorder.stage("lit", |pass| self.light.dispatch(gpu, pass, &buffers, step.groups()));
            }
            if !how.takes_colors {
                continue;
            }
            if casts_shadow {
                tracer.record_passed(gpu, recorder, geometry, passed, questions);
                let of_points = [tracer.passed(), tracer.shadows()];
                recorder.stage("tint", |pass| shade.record_tint(gpu, pass, geometry, of_points, step.count));
            }
            let buffers = [light, questions.buffer(), tracer.shadows(), tracer.passed(), lit];
            recorder.stage("tint", |pass| self.tinted.dispatch(gpu, pass, &buffers, step.groups()));
        }
    }

    /// The first word of transmittances, behind the bits of all lights.
    pub(super) fn tints_word(&self) -> u32 {
        self.words * self.casts_shadow.len() as u32
    }

    pub(super) fn bytes(&self) -> u64 {
        [self.questions.buffer(), &self.lit, &self.directions].into_iter().map(Buffer::bytes).sum()
    }
}

/// Words of a light's bits, for whole workgroups of rays.
pub(crate) fn mask_words(rays: u32) -> u32 {
    2 * rays.div_ceil(64)
}
