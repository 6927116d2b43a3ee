//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod make;
mod see;
mod shade;
mod shadow;

use umbrage_rays::{
    Bvh, DirectGrids, Hit, LightMask, Omitted, Ray, SeenPixels, Shot, Sides, SimdLevel, SingleRays, Structure as _,
    View, Work, predicate,
};
use umbrage_scene::{Frame, FrameOpacity};

use crate::sampling::Sample;
use crate::{Error, Settings, Settled, Structure};
use make::make;

/// Finds what each pixel sees and which lights reach it, through structures rebuilt for every frame.
#[derive(Debug)]
pub(crate) struct Cpu {
    level: SimdLevel,
    /// What `structure` was made of, and whether rays come to it one at a time.
    made_of: (Structure, bool),
    structure: Box<dyn umbrage_rays::Structure>,
    /// For single rays, where the structure doesn't answer them.
    bvh: Bvh,
    /// Which sides of triangles stop camera rays.
    sides: Sides,
    /// How many mirrors light may come by.
    bounces: u32,
    /// What each pixel sees at the current sample.
    seen: SeenPixels,
    /// For each light, which pixels it lights at the current sample.
    masks: Vec<LightMask>,
    shadow_rays: u64,
    /// Tests of camera rays, and of shadow rays, that the filters left to the predicate, over all samples.
    settled_tests: [u64; 2],
    camera_work: Work,
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
            made_of: (Structure::Perspective, false),
            structure: Box::new(DirectGrids::with_level(level)),
            bvh: Bvh::default(),
            sides: Sides::Both,
            bounces: 0,
            seen: SeenPixels::default(),
            masks: Vec::new(),
            shadow_rays: 0,
            settled_tests: [0; 2],
            camera_work: Work::default(),
        }
    }

    /// Rebuilds what serves all samples of a frame. Structures that are made for the rays of one sample are rebuilt by the
    /// stages that trace them.
    pub(crate) fn build(&mut self, frame: &Frame, settings: &Settings) -> Result<(), Error> {
        let sends_rays_onward = frame.is_see_through() || settings.bounces > 0;
        let made_of = (settings.structure, sends_rays_onward);
        if self.made_of != made_of {
            self.structure = make(settings.structure, self.level, sends_rays_onward)?;
            self.made_of = made_of;
        }
        self.sides = settings.sides;
        self.bounces = settings.bounces;
        self.shadow_rays = 0;
        self.settled_tests = [0; 2];
        self.camera_work = Work::default();
        self.structure.build(frame.triangles());
        if sends_rays_onward && self.structure.single_rays().is_none() {
            self.bvh.build(frame.triangles());
        }
        Ok(())
    }

    /// What finds the hits of rays that come one at a time.
    fn single_rays(&self) -> &dyn SingleRays {
        self.structure.single_rays().unwrap_or(&self.bvh)
    }

    /// What each pixel showed at the last sample.
    pub(crate) fn seen(&self) -> &SeenPixels {
        &self.seen
    }

    /// For each light, which pixels it lit at the last sample.
    pub(crate) fn light_masks(&self) -> &[LightMask] {
        &self.masks
    }

    /// What the camera was as work for its structure, at the last sample; zero where that isn't counted.
    pub(crate) fn camera_work(&self) -> Work {
        self.camera_work
    }

    /// What each light that casts shadows was as work for its grid, at the last sample; empty where that isn't counted.
    pub(crate) fn light_work(&self) -> &[Work] {
        self.structure.work_of_lights()
    }

    pub(crate) fn omitted(&self) -> &Omitted {
        self.structure.omitted()
    }

    pub(crate) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// What of the last frame's camera rays and shadow rays was left to the predicate, where the structure counts that.
    pub(crate) fn settled(&self) -> [Option<Settled>; 2] {
        let is_counted = self.made_of.0.is_specialised();
        self.settled_tests.map(|tests| is_counted.then(|| Settled { tests, ..Settled::default() }))
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        self.structure.bytes().triangles + self.bvh.bytes().triangles
    }

    pub(crate) fn point_bytes(&self) -> usize {
        self.structure.bytes().points
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        self.seen.bytes() + self.masks.iter().map(LightMask::bytes).sum::<usize>()
    }
}

/// What stops camera rays, and what stops shadow rays.
fn opacities(frame: &Frame) -> [FrameOpacity<'_>; 2] {
    [frame.camera_opacity(), frame.shadow_opacity()]
}

/// A sample of each pixel, as a question to a structure.
fn shot<'a>(
    frame: &'a Frame,
    [opacity, shadow_opacity]: &'a [FrameOpacity<'a>; 2],
    view: &View,
    sample: &Sample,
    sides: Sides,
) -> Shot<'a> {
    let offset_pixels = sample.offset_pixels;
    Shot { triangles: frame.triangles(), view: *view, offset_pixels, opacity, shadow_opacity, sides }
}

/// Whether a camera ray that meets a triangle there is stopped by it: by its side, and where it isn't cut away.
pub(crate) fn stops(frame: &Frame, ray: &Ray, hit: &Hit, sides: Sides) -> bool {
    use umbrage_rays::Opacity as _;
    sides.stop(ray, frame.triangles().corners(hit.triangle))
        && frame.camera_opacity().stops(hit.triangle, hit.barycentric)
}

/// Where `ray` meets the triangle that it is known to show.
fn hit_of(frame: &Frame, ray: &Ray, seen: u32) -> Option<Hit> {
    if seen == SeenPixels::NONE { None } else { predicate::hit(ray, frame.triangles(), seen) }
}
