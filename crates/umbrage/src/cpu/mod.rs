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
mod strip;
mod terminator;
mod tint;

use std::mem;

use umbrage_rays::{
    self as rays, Bvh, Bytes, DirectGrids, Hit, ImageTooLarge, LightMask, LightSource, Opacity as _, Ray, SeenPixels,
    Shot, SimdLevel, SingleRays, Structure as _, Triangles, View, Work, predicate,
};
use umbrage_scene::{Frame, FrameOpacity, Light};

use copies::Copies;
pub(crate) use kept::Kept;
pub(crate) use layers::SeenAndLit;
use marks::Marks;
pub(crate) use samples::last_alone;
use see::Casting;
use terminator::SmoothTerminator;

use crate::engine::{Engine, Last, Outcome, Output, Passes, Staged, done};
use crate::frame::Subject;
use crate::motion::Next;
use crate::plan::Plan;
use crate::sampling::{Sample, Samples};
use crate::shade::Emitter;
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
    plan: Plan,
    /// For each material, whether paths [end](Plan::ends_at) at it.
    is_plain: Vec<bool>,
    /// The current sample's lights, for shading.
    emitters: Vec<Emitter>,
    /// Whether this frame is developed as it is shaded.
    is_to_rows: bool,
    /// The last such frame.
    rows: Vec<u8>,
    /// The samples of each pixel that were traced last.
    samples: Samples,
    /// Each pixel's hits at these samples: each of four samples is a pixel here.
    seen: SeenPixels,
    /// For each light, the mask of the hits that it lights.
    masks: Vec<LightMask>,
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
            plan: Plan::default(),
            is_plain: Vec::new(),
            emitters: Vec::new(),
            is_to_rows: false,
            rows: Vec::new(),
            samples: Samples::one(Sample::MIDDLE),
            seen: SeenPixels::default(),
            masks: Vec::new(),
            sky_lights: 0,
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
        if settings.smooth_terminator {
            self.smooth_terminator.get_or_insert_with(|| SmoothTerminator::with_level(self.level));
        } else {
            self.smooth_terminator = None;
        }
        Ok(())
    }

    /// Builds the structures that serve all samples of a moment.
    fn prepare(&mut self, frame: &Frame, sides: Sides) {
        self.sides.find(frame, sides);
        self.copies.find(frame, self.sides.get());
        let triangles = self.copies.triangles(frame);
        self.structure.build_parts(triangles, frame.parts());
    }

    /// Chooses and builds the structures that answer without a picture.
    fn prepare_alone(&mut self, frame: &Frame, settings: &Settings) -> Result<(), Error> {
        self.choose(settings, false)?;
        self.prepare(frame, settings.sides);
        Ok(())
    }

    /// Finds the triangles seen through the middles of pixels.
    pub(crate) fn seen_alone(&mut self, frame: &Frame, view: &View) -> Result<SeenPixels, Error> {
        self.prepare_alone(frame, &Settings::default())?;
        self.see_pixels(frame, view, &Samples::one(Sample::MIDDLE))?;
        Ok(mem::take(&mut self.seen))
    }

    /// Finds the points in `seen` that each light reaches.
    pub(crate) fn lit_alone(
        &mut self,
        frame: &Frame,
        lights: &[Light],
        view: &View,
        seen: &SeenPixels,
    ) -> Result<Vec<LightMask>, Error> {
        self.prepare_alone(frame, &Settings::default())?;
        self.seen.clone_from(seen);
        self.shadow_points(frame, lights, view, &Samples::one(Sample::MIDDLE));
        Ok(mem::take(&mut self.masks))
    }

    /// Counts the work of rays through the middles of pixels, and locates their hits in the grid of `light`.
    pub(crate) fn count_alone(
        &mut self,
        frame: &Frame,
        view: &View,
        settings: &Settings,
        light: Option<&LightSource>,
        counts: &mut WorkCounts,
    ) -> Result<(), Error> {
        self.prepare_alone(frame, settings)?;
        let opacities = opacities(frame);
        let middle = Samples::one(Sample::MIDDLE);
        let shot = shot(self.copies.triangles(frame), &opacities, view, &middle, self.sides.get());
        let specialised = self.structure.specialised().ok_or(Error::CountsOfStructure)?;
        specialised.see_counting(&shot, &mut self.seen, &mut counts.pixels)?;
        if let Some(light) = light {
            specialised.locate(&shot, &self.seen, light, &mut counts.cells);
        }
        Ok(())
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
    fn begin(&mut self, _settings: &Settings, output: Output) -> Result<(), Error> {
        match output {
            Output::Film | Output::Rows => {}
            #[cfg(feature = "gpu")]
            Output::Texture => return Err(Error::TextureOnCpu),
        }
        self.is_to_rows = output == Output::Rows;
        self.shadow_rays = 0;
        self.settled_tests = [0; 2];
        self.camera_work = Work::default();
        Ok(())
    }

    fn animate(&mut self, subject: Subject<'_>, _settings: &Settings, frame: &mut Frame) -> Result<(), Error> {
        let Subject::Moment(scene, seconds) = subject else { return Ok(()) };
        Ok(scene.pose(seconds, frame)?)
    }

    /// Structures that are made for the rays of one sample are rebuilt by the stages that trace them. Four samples are
    /// traced together in images of up to eight million pixels, a 4K screen: their hits take 32 bytes for each pixel.
    fn build(&mut self, staged: &Staged<'_>, _output: Output) -> Result<Passes, Error> {
        const MOST_PIXELS: u64 = 1 << 23;
        let Staged { frame, settings, view: View { width, height, .. }, .. } = *staged;
        self.plan = Plan::new(settings, frame);
        self.is_plain.clear();
        self.is_plain.extend(frame.materials.materials.iter().map(|material| self.plan.ends_at(material)));
        self.choose(settings, self.plan.goes_on())?;
        self.prepare(frame, settings.sides);
        if self.plan.goes_on() && self.structure.single_rays().is_none() {
            let triangles = self.copies.triangles(frame);
            if !self.kept.are_still(triangles) {
                self.bvh.build(triangles);
            }
        }
        let is_small = u64::from(width) * u64::from(height) <= MOST_PIXELS;
        Ok(Passes { bands: 1, by_four: is_small && width.max(height) <= ImageTooLarge::LARGEST_SIDE / 2 })
    }

    fn see(&mut self, staged: &Staged<'_>, stats: &mut Stats) -> Result<(), Error> {
        let Staged { frame, ref view, samples, .. } = *staged;
        self.samples = samples;
        Ok(stats.time("see", || self.see_pixels(frame, view, &samples))?)
    }

    fn shadow(&mut self, staged: &Staged<'_>, stats: &mut Stats) -> Result<(), Error> {
        let Staged { frame, lights, sky_lights, ref view, samples, .. } = *staged;
        self.sky_lights = sky_lights;
        stats.time("shadow", || self.shadow_points(frame, lights, view, &samples));
        Ok(())
    }

    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        next: Option<&'a Next<'a>>,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a> {
        let has_marks = !staged.frame.mesh.marks.is_empty();
        let marks = if has_marks { stats.time("marks", || Marks::new(staged)) } else { None };
        stats.time("shade", || self.shade_pixels(staged, marks.as_ref(), film));
        if !staged.settings.layers.is_empty() {
            let all = SeenAndLit { seen: &self.seen, masks: &self.masks };
            stats.time("layers", || all.add_layers(staged, next, film));
        }
        done()
    }

    /// The film has all of it already.
    fn develop<'a>(&'a mut self, _staged: &'a Staged<'a>, _film: &'a mut Film, _stats: &'a mut Stats) -> Outcome<'a> {
        done()
    }

    fn rows(&mut self) -> Option<&mut Vec<u8>> {
        Some(&mut self.rows)
    }

    fn last(&self) -> Last<'_> {
        Last {
            samples: self.samples,
            seen: &self.seen,
            light_masks: &self.masks[..self.masks.len() - self.sky_lights],
            camera_work: self.camera_work,
            light_work: self.structure.work_of_lights(),
            #[cfg(feature = "gpu")]
            texture: None,
        }
    }

    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        frame
    }

    fn count(&self, frame: &Frame, stats: &mut Stats) {
        let Bytes { triangles, points } = self.structure.bytes();
        stats.omitted_marks = 0;
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
