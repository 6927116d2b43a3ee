//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod caught;
mod copies;
mod kept;
mod layers;
mod marks;
mod met;
mod onward;
mod samples;
mod see;
mod shade;
mod shadow;
mod strip;
mod terminator;
mod tint;

use std::mem;
use std::sync::OnceLock;

use umbrage_rays::{
    self as rays, Bvh, Bytes, DirectGrids, Hit, ImageTooLarge, LightMask, LightSource, Opacity as _, Ray, SeenPixels,
    Shot, SimdLevel, SingleRays, Structure as _, TileOrder, Triangles, View, Work, predicate,
};
use umbrage_scene::{Frame, FrameOpacity, Light, Material, Scene};

use copies::Copies;
pub(crate) use kept::Kept;
pub(crate) use layers::SeenAndLit;
use marks::Marks;
use samples::OneSample;
use shadow::Casting;
use terminator::SmoothTerminator;

use crate::engine::{Engine, Outcome, Output, Staged};
use crate::motion::Next;
use crate::sampling::{Sample, Samples};
use crate::shade::SMOOTHEST;
use crate::sides::TriangleSides;
use crate::{Error, Film, Settings, Settled, Sides, Stats, Structure, WorkCounts};

/// The CPU engine: finds each pixel's hit and the lights that reach it, through structures rebuilt for every frame.
#[derive(Debug)]
pub(crate) struct Cpu {
    level: SimdLevel,
    /// The choice that `structure` was made from, and whether single rays go through it.
    made_of: (Structure, bool),
    structure: Box<dyn umbrage_rays::Structure>,
    copies: Copies,
    /// Hierarchy for single rays, if `structure` doesn't answer them.
    bvh: Bvh,
    /// The triangles that `bvh` was built for.
    kept: Kept,
    /// Which sides of the frame's triangles stop rays.
    sides: TriangleSides,
    follows: Follows,
    /// The samples of each pixel that were traced last.
    samples: Samples,
    /// Each pixel's hits at these samples: each of four samples is a pixel here.
    seen: SeenPixels,
    /// For each light, the mask of the hits that it lights.
    masks: Vec<LightMask>,
    /// Both for the last sample alone, made on demand if several were traced together.
    last: OnceLock<(SeenPixels, Vec<LightMask>)>,
    /// Number of sky lights, the last of `masks`.
    sky_lights: usize,
    casting: Casting,
    /// `None` without [`Settings::smooth_terminator`].
    smooth_terminator: Option<SmoothTerminator>,
    shadow_rays: u64,
    /// Tests of camera rays, and of shadow rays, that the predicate settled, over all samples.
    settled_tests: [u64; 2],
    camera_work: Work,
}

/// Limits of secondary rays.
#[derive(Clone, Copy, Debug, Default)]
struct Follows {
    /// Maximum number of bounces on a path.
    bounces: u32,
    /// Minimum throughput in mirrors and glass: without it, panes behind panes would mirror each other endlessly.
    least: f32,
    /// Whether rough surfaces mirror as well.
    gloss: bool,
    /// Ambient-occlusion radius in world units; 0 without occlusion.
    around: f32,
}

impl Follows {
    fn new(settings: &Settings) -> Self {
        let Settings { bounces, least_contribution: least, gloss, ambient_occlusion, samples, .. } = *settings;
        let are_several = samples > 1;
        Self { bounces, least, gloss: gloss && are_several, around: if are_several { ambient_occlusion } else { 0.0 } }
    }

    /// Whether any surface of a frame may spawn secondary rays.
    fn any(self, frame: &Frame) -> bool {
        let is_mirror = |material: &Material| material_mirrors(material, self.gloss);
        frame.is_see_through()
            || self.around > 0.0
            || self.bounces > 0 && frame.materials.materials.iter().any(is_mirror)
    }
}

impl Default for Cpu {
    fn default() -> Self {
        Self::with_level(SimdLevel::default())
    }
}

impl Cpu {
    /// An engine that uses the instructions of `level`.
    pub(crate) fn with_level(level: SimdLevel) -> Self {
        Self {
            level,
            made_of: (Structure::default(), false),
            structure: Box::new(DirectGrids::with_level(level)),
            copies: Copies::default(),
            bvh: Bvh::default(),
            kept: Kept::default(),
            sides: TriangleSides::default(),
            follows: Follows::default(),
            samples: Samples::one(Sample::MIDDLE),
            seen: SeenPixels::default(),
            masks: Vec::new(),
            sky_lights: 0,
            last: OnceLock::new(),
            casting: Casting::default(),
            smooth_terminator: None,
            shadow_rays: 0,
            settled_tests: [0; 2],
            camera_work: Work::default(),
        }
    }

    /// Applies the settings. With `sends_rays_onward`, single rays go through the structure as well.
    fn choose(&mut self, settings: &Settings, sends_rays_onward: bool) -> Result<(), Error> {
        let Settings { structure, .. } = settings;
        if self.made_of.0 != *structure || self.made_of.1 != sends_rays_onward {
            self.structure = structure.make(self.level, sends_rays_onward)?;
            self.made_of = (structure.clone(), sends_rays_onward);
        }
        self.follows = Follows::new(settings);
        if settings.smooth_terminator {
            self.smooth_terminator.get_or_insert_with(|| SmoothTerminator::with_level(self.level));
        } else {
            self.smooth_terminator = None;
        }
        Ok(())
    }

    fn forget_counts(&mut self) {
        self.shadow_rays = 0;
        self.settled_tests = [0; 2];
        self.camera_work = Work::default();
    }

    /// Builds the structures that serve all samples of a moment.
    fn prepare(&mut self, frame: &Frame, sides: Sides) {
        self.sides.find(frame, sides);
        self.copies.find(frame, self.sides.get());
        let triangles = self.copies.triangles(frame);
        self.structure.build_parts(triangles, frame.parts());
    }

    /// Finds the triangles seen through the middles of pixels; the last frame's hits stay.
    pub(crate) fn seen_alone(&mut self, frame: &Frame, view: &View) -> Result<SeenPixels, Error> {
        self.forget_counts();
        self.choose(&Settings::default(), false)?;
        self.prepare(frame, Sides::default());
        let last = mem::take(&mut self.seen);
        let result = self.see_pixels(frame, view, &Samples::one(Sample::MIDDLE));
        let seen = mem::replace(&mut self.seen, last);
        Ok(result.map(|()| seen)?)
    }

    /// Finds the points in `seen` that each light reaches; the last frame's hits and masks stay.
    pub(crate) fn lit_alone(
        &mut self,
        frame: &Frame,
        lights: &[Light],
        view: &View,
        seen: &SeenPixels,
    ) -> Result<Vec<LightMask>, Error> {
        self.forget_counts();
        self.choose(&Settings::default(), false)?;
        self.prepare(frame, Sides::default());
        let last = (mem::replace(&mut self.seen, seen.clone()), mem::take(&mut self.masks));
        self.shadow_points(frame, lights, view, &Samples::one(Sample::MIDDLE));
        let masks = mem::take(&mut self.masks);
        (self.seen, self.masks) = last;
        Ok(masks)
    }

    /// Counts the work of rays through the middles of pixels, and locates their hits in the grid of `light`; the last
    /// frame's hits stay.
    pub(crate) fn count_alone(
        &mut self,
        frame: &Frame,
        view: &View,
        settings: &Settings,
        light: Option<&LightSource>,
        counts: &mut WorkCounts,
    ) -> Result<(), Error> {
        self.forget_counts();
        self.choose(settings, false)?;
        self.prepare(frame, settings.sides);
        let opacities = opacities(frame);
        let middle = Samples::one(Sample::MIDDLE);
        let shot = shot(self.copies.triangles(frame), &opacities, view, &middle, self.sides.get());
        let specialised = self.structure.specialised().ok_or(Error::CountsOfStructure)?;
        let mut seen = SeenPixels::default();
        self.camera_work = specialised.see_counting(&shot, &mut seen, &mut counts.pixels)?;
        if let Some(light) = light {
            specialised.locate(&shot, &seen, light, &mut counts.cells);
        }
        Ok(())
    }

    /// Hits and masks of the last sample, if it wasn't traced alone.
    fn last_sample(&self) -> Option<&(SeenPixels, Vec<LightMask>)> {
        let Self { samples, seen, masks, last, .. } = self;
        let side = samples.side();
        (side > 1).then(|| {
            last.get_or_init(|| {
                let (width, height) = seen.order().size();
                let pixels = TileOrder::new(width / side, height / side);
                OneSample::new(seen.order(), samples, samples.as_slice().len() - 1).alone(pixels, seen, masks)
            })
        })
    }

    /// The structure that answers single rays.
    fn single_rays(&self) -> &dyn SingleRays {
        self.structure.single_rays().unwrap_or(&self.bvh)
    }

    /// The predicate's counts for the last frame's camera rays and shadow rays, if the structure counts them.
    fn settled(&self) -> [Option<Settled>; 2] {
        let is_counted = self.made_of.0.is_specialised();
        self.settled_tests.map(|tests| is_counted.then(|| Settled { tests, ..Settled::default() }))
    }
}

impl Engine for Cpu {
    fn check(&self, _settings: &Settings, output: Output) -> Result<(), Error> {
        match output {
            Output::Film => Ok(()),
            #[cfg(feature = "gpu")]
            Output::Texture => Err(Error::TextureOnCpu),
        }
    }

    fn begin(&mut self, _settings: &Settings) {
        self.forget_counts();
    }

    fn animate(&mut self, scene: &Scene, seconds: f64, _settings: &Settings, frame: &mut Frame) -> Result<(), Error> {
        Ok(scene.pose(seconds, frame)?)
    }

    /// Structures that are made for the rays of one sample are rebuilt by the stages that trace them.
    fn build(&mut self, staged: &Staged<'_>, _output: Output) -> Result<(), Error> {
        let Staged { frame, settings, .. } = *staged;
        let sends_rays_onward = Follows::new(settings).any(frame);
        self.choose(settings, sends_rays_onward)?;
        self.prepare(frame, settings.sides);
        if sends_rays_onward && self.structure.single_rays().is_none() {
            let triangles = self.copies.triangles(frame);
            if !self.kept.are_still(triangles) {
                self.bvh.build(triangles);
            }
        }
        Ok(())
    }

    /// In images of up to eight million pixels, a 4K screen: the hits of four samples take 32 bytes for each pixel.
    fn traces_four(&self, view: &View) -> bool {
        const MOST_PIXELS: u64 = 1 << 23;
        let pixels = u64::from(view.width) * u64::from(view.height);
        pixels <= MOST_PIXELS && view.width.max(view.height) <= ImageTooLarge::LARGEST_SIDE / 2
    }

    fn see(&mut self, staged: &Staged<'_>, samples: &Samples, stats: &mut Stats) -> Result<(), Error> {
        self.samples = *samples;
        self.last = OnceLock::new();
        Ok(stats.time("see", || self.see_pixels(staged.frame, &staged.view, samples))?)
    }

    fn shadow(&mut self, staged: &Staged<'_>, samples: &Samples, stats: &mut Stats) -> Result<(), Error> {
        self.sky_lights = staged.sky_lights;
        stats.time("shadow", || self.shadow_points(staged.frame, staged.lights, &staged.view, samples));
        Ok(())
    }

    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        _band: usize,
        samples: &'a Samples,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a> {
        let has_marks = !staged.frame.mesh.marks.is_empty();
        let marks = if has_marks { stats.time("marks", || Marks::new(staged, samples)) } else { None };
        stats.time("shade", || self.shade_pixels(staged, samples, marks.as_ref(), film));
        Outcome::Known(Ok(()))
    }

    fn layers(
        &mut self,
        staged: &Staged<'_>,
        samples: &Samples,
        next: Option<&Next<'_>>,
        film: &mut Film,
        stats: &mut Stats,
    ) {
        if !staged.settings.layers.is_empty() {
            let all = SeenAndLit { seen: &self.seen, masks: &self.masks, samples };
            stats.time("layers", || all.add_layers(staged, next, film));
        }
    }

    fn cpu(&mut self) -> Option<&mut Cpu> {
        Some(self)
    }

    fn seen(&self) -> &SeenPixels {
        self.last_sample().map_or(&self.seen, |(seen, _)| seen)
    }

    fn draws_marks(&self) -> bool {
        true
    }

    fn light_masks(&self) -> &[LightMask] {
        let masks = self.last_sample().map_or(&self.masks, |(_, masks)| masks);
        &masks[..masks.len() - self.sky_lights]
    }

    fn camera_work(&self) -> Work {
        self.camera_work
    }

    fn light_work(&self) -> &[Work] {
        self.structure.work_of_lights()
    }

    fn count(&self, frame: &Frame, stats: &mut Stats) {
        let Bytes { triangles, points } = self.structure.bytes();
        stats.shadow_rays = self.shadow_rays;
        stats.count_settled(self.settled());
        stats.structure_bytes = triangles + self.bvh.bytes().triangles + self.kept.bytes() + self.sides.bytes();
        stats.point_bytes = points;
        stats.pixel_bytes += self.seen.bytes() + self.masks.iter().map(LightMask::bytes).sum::<usize>();
        stats.pixel_bytes += self.smooth_terminator.as_ref().map_or(0, SmoothTerminator::bytes);
        stats.uploaded_bytes = 0;
        self.copies.count_omitted(frame, self.structure.omitted(), stats);
    }
}

/// Whether rays mirrored by a material may be followed.
pub(crate) fn material_mirrors(material: &Material, gloss: bool) -> bool {
    let Material { roughness, metallic_roughness_texture, unlit, layers, .. } = material;
    let coat_is_smooth = layers.as_ref().is_some_and(|layers| {
        let coat = &layers.clearcoat;
        coat.factor > 0.0 && (coat.roughness <= SMOOTHEST || coat.roughness_texture.is_some())
    });
    !unlit && (gloss || *roughness <= SMOOTHEST || metallic_roughness_texture.is_some() || coat_is_smooth)
}

/// Opacities for camera rays and for shadow rays.
fn opacities(frame: &Frame) -> [FrameOpacity<'_>; 2] {
    [frame.camera_opacity(), frame.shadow_opacity()]
}

/// Samples of each pixel, as a question to a structure.
fn shot<'a>(
    triangles: Triangles<'a>,
    [opacity, shadow_opacity]: &'a [FrameOpacity<'a>; 2],
    view: &View,
    samples: &Samples,
    sides: rays::Sides<'a>,
) -> Shot<'a> {
    samples.question(Shot { opacity, shadow_opacity, sides, ..Shot::new(triangles, *view) })
}

/// Whether a hit stops its ray: the side does, and the point isn't cut away.
pub(crate) fn stops(frame: &Frame, ray: &Ray, hit: &Hit, sides: rays::Sides<'_>) -> bool {
    sides.stop(ray, hit.triangle, frame.triangles().corners(hit.triangle))
        && frame.camera_opacity().stops(hit.triangle, hit.barycentric)
}

/// The hit of `ray` on the triangle that it is known to see; `None` without one.
fn hit_of(frame: &Frame, ray: &Ray, seen: u32) -> Option<Hit> {
    if seen == SeenPixels::NONE { None } else { predicate::hit(ray, frame.triangles(), seen) }
}
