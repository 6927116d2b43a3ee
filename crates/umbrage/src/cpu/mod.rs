//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod see;
mod shade;
mod shadow;
mod single_rays;

use std::mem;

use umbrage_rays::{
    Bvh, GridCounts, Hit, ImageTooLarge, KdTree, LightGrid, LightGridCounts, LightGridSeconds, LightSource, ListedGrid,
    ListedLightGrid, Omitted, PerspectiveGrid, Ray, SeenPixels, SimdLevel, UniformGrid, UniformOptions, View,
    predicate,
};
use umbrage_scene::{Frame, Light, Scene};

use crate::engine::{Engine, Output, Staged};
use crate::sampling::Sample;
use crate::{Error, Film, Settings, Settled, Stats, Structure, WorkCounts};
pub use shadow::LightMask;
use single_rays::SingleRays;

/// Finds what each pixel sees and which lights reach it, through structures rebuilt for every frame.
#[derive(Debug, Default)]
pub(crate) struct Cpu {
    structure: Structure,
    level: SimdLevel,
    /// Whether camera rays go through back faces.
    culls_back_faces: bool,
    /// How many mirrors light may come by.
    bounces: u32,
    /// For single rays of structures that don't serve them, and for all rays where the structure is the hierarchy.
    bvh: Bvh,
    kd_tree: KdTree,
    uniform_grid: UniformGrid,
    camera_grid: PerspectiveGrid,
    listed_grid: ListedGrid,
    light_grid: LightGrid,
    listed_light_grid: ListedLightGrid,
    /// What each pixel sees at the current sample.
    seen: SeenPixels,
    /// For each light, which pixels it lights at the current sample.
    lit: Vec<LightMask>,
    shadow_rays: u64,
    /// Tests of camera rays, and of shadow rays, that the grids left to the predicate, over all samples.
    settled_tests: [u64; 2],
    camera_work: GridCounts,
    light_work: Vec<LightWork>,
}

/// What a light was as work for its grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightWork {
    /// How much there was to do.
    pub counts: LightGridCounts,
    /// How long each stage took; what serves all lights is counted for each.
    pub seconds: LightGridSeconds,
}

impl Cpu {
    /// An engine that uses the instructions of `level`.
    pub(crate) fn with_level(level: SimdLevel) -> Self {
        Self {
            level,
            kd_tree: KdTree::with_level(level),
            uniform_grid: UniformGrid::with_level(level),
            camera_grid: PerspectiveGrid::with_level(level),
            listed_grid: ListedGrid::with_level(level),
            light_grid: LightGrid::with_level(level),
            listed_light_grid: ListedLightGrid::with_level(level),
            ..Self::default()
        }
    }

    /// Takes over what the settings say, and forgets the last frame's counts.
    fn choose(&mut self, settings: &Settings) {
        self.structure = settings.structure;
        if let Structure::Listed { camera, .. } = &mut self.structure {
            camera.culls_back_faces |= settings.culls_back_faces;
        }
        self.culls_back_faces = settings.culls_back_faces;
        self.bounces = settings.bounces;
        self.camera_grid.set_culls_back_faces(settings.culls_back_faces);
        self.shadow_rays = 0;
        self.settled_tests = [0; 2];
        self.camera_work = GridCounts::default();
        self.light_work.clear();
    }

    /// Rebuilds what serves all samples of a frame: the uniform grid, the kd-tree, or the hierarchy where anything needs it. Other grids
    /// are made for the rays of one sample, by the stages that trace them.
    fn build_structures(&mut self, frame: &Frame, settings: &Settings) -> Result<(), Error> {
        self.choose(settings);
        match self.structure {
            Structure::Grid(mut options) => {
                if frame.is_see_through() || settings.bounces > 0 {
                    // Rays that come one at a time need them where triangles crowd: a twelfth of the time for `demo:glass`.
                    options.nested_above = options.nested_above.or(UniformOptions::NESTED.nested_above);
                }
                self.uniform_grid.set_options(options)?;
                self.uniform_grid.build(frame.triangles());
            }
            Structure::KdTree(options) => {
                self.kd_tree.set_options(options)?;
                self.kd_tree.build(frame.triangles());
            }
            Structure::Bvh => self.bvh.build(frame.triangles()),
            Structure::Perspective | Structure::Listed { .. } => {
                if frame.is_see_through() || settings.bounces > 0 {
                    self.bvh.build(frame.triangles());
                }
            }
        }
        Ok(())
    }

    /// Finds what pixels show through their middles; what is known of the last frame's pixels stays.
    pub(crate) fn seen_alone(&mut self, frame: &Frame, view: &View) -> Result<SeenPixels, ImageTooLarge> {
        self.choose(&Settings::default());
        let last = mem::take(&mut self.seen);
        let result = self.see_pixels(frame, view, &Sample::MIDDLE);
        let seen = mem::replace(&mut self.seen, last);
        result.map(|()| seen)
    }

    /// Finds which lights reach what pixels show through their middles; what is known of the last frame's pixels stays.
    pub(crate) fn lit_alone(
        &mut self,
        frame: &Frame,
        lights: &[Light],
        view: &View,
        seen: &SeenPixels,
    ) -> Vec<LightMask> {
        self.choose(&Settings::default());
        let last = (mem::replace(&mut self.seen, seen.clone()), mem::take(&mut self.lit));
        self.shadow_points(frame, lights, view, &Sample::MIDDLE);
        let lit = mem::take(&mut self.lit);
        (self.seen, self.lit) = last;
        lit
    }

    /// Counts the work of seeing through the middles of pixels, and locates what is seen in a light's grid.
    pub(crate) fn count_alone(
        &mut self,
        frame: &Frame,
        view: &View,
        settings: &Settings,
        light: Option<&LightSource>,
        counts: &mut WorkCounts,
    ) -> Result<(), ImageTooLarge> {
        self.choose(settings);
        self.see_counting(frame, view, &Sample::MIDDLE, &mut counts.pixels)?;
        if let Some(light) = light {
            self.locate(frame, view, &Sample::MIDDLE, light, &mut counts.cells);
        }
        Ok(())
    }

    /// What finds the hits of rays that come one at a time.
    fn single_rays(&self) -> SingleRays<'_> {
        match self.structure {
            Structure::Grid(_) => SingleRays::Grid(&self.uniform_grid),
            Structure::KdTree(_) => SingleRays::KdTree(&self.kd_tree),
            Structure::Perspective | Structure::Listed { .. } | Structure::Bvh => SingleRays::Bvh(&self.bvh),
        }
    }

    fn omitted(&self) -> &Omitted {
        match self.structure {
            Structure::Perspective => self.camera_grid.omitted(),
            Structure::Listed { .. } => self.listed_grid.omitted(),
            Structure::Grid(_) => self.uniform_grid.omitted(),
            Structure::KdTree(_) => self.kd_tree.omitted(),
            Structure::Bvh => self.bvh.omitted(),
        }
    }

    /// What of the last frame's camera rays and shadow rays was left to the predicate; only the direct grids count that.
    fn settled(&self) -> [Option<Settled>; 2] {
        let is_counted = self.structure == Structure::Perspective;
        self.settled_tests.map(|tests| is_counted.then(|| Settled { tests, ..Settled::default() }))
    }

    fn structure_bytes(&self) -> usize {
        match self.structure {
            Structure::Perspective => self.bvh.bytes() + self.camera_grid.bytes() + self.light_grid.triangle_bytes(),
            Structure::Listed { .. } => self.bvh.bytes() + self.listed_grid.bytes() + self.listed_light_grid.bytes(),
            Structure::Grid(_) => self.uniform_grid.bytes(),
            Structure::KdTree(_) => self.kd_tree.bytes(),
            Structure::Bvh => self.bvh.bytes(),
        }
    }

    fn point_bytes(&self) -> usize {
        match self.structure {
            Structure::Perspective => self.light_grid.bytes() - self.light_grid.triangle_bytes(),
            // The paper's form counts with the triangles: its points and triangles share lists.
            Structure::Listed { .. } | Structure::Grid(_) | Structure::KdTree(_) | Structure::Bvh => 0,
        }
    }

    fn pixel_bytes(&self) -> usize {
        let SeenPixels { triangle, inverse_depth, .. } = &self.seen;
        size_of_val(triangle.as_slice())
            + size_of_val(inverse_depth.as_slice())
            + self.lit.iter().map(LightMask::bytes).sum::<usize>()
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

    fn animate(&mut self, scene: &Scene, seconds: f64, _settings: &Settings, frame: &mut Frame) -> Result<(), Error> {
        Ok(scene.pose(seconds, frame)?)
    }

    fn build(&mut self, staged: &Staged<'_>, _output: Output) -> Result<(), Error> {
        self.build_structures(staged.frame, staged.settings)
    }

    fn see(&mut self, staged: &Staged<'_>, sample: &Sample, stats: &mut Stats) -> Result<(), Error> {
        Ok(stats.time("see", || self.see_pixels(staged.frame, &staged.view, sample))?)
    }

    fn shadow(&mut self, staged: &Staged<'_>, sample: &Sample, stats: &mut Stats) -> Result<(), Error> {
        stats.time("shadow", || self.shadow_points(staged.frame, staged.lights, &staged.view, sample));
        Ok(())
    }

    fn shade(
        &mut self,
        staged: &Staged<'_>,
        _band: usize,
        sample: &Sample,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Error> {
        stats.time("shade", || self.shade_pixels(staged, sample, film));
        Ok(())
    }

    fn cpu(&mut self) -> Option<&mut Cpu> {
        Some(self)
    }

    fn seen(&self) -> &SeenPixels {
        &self.seen
    }

    fn light_masks(&self) -> &[LightMask] {
        &self.lit
    }

    fn camera_work(&self) -> GridCounts {
        self.camera_work
    }

    fn light_work(&self) -> &[LightWork] {
        &self.light_work
    }

    fn count(&self, _frame: &Frame, stats: &mut Stats) -> Result<(), Error> {
        stats.shadow_rays = self.shadow_rays;
        stats.count_settled(self.settled());
        stats.structure_bytes = self.structure_bytes();
        stats.point_bytes = self.point_bytes();
        stats.pixel_bytes += self.pixel_bytes();
        stats.uploaded_bytes = 0;
        stats.count_omitted(self.omitted());
        Ok(())
    }
}

/// Whether a camera ray that meets a triangle there is stopped by it, or seen by it to be of some colour.
pub(crate) fn counts(frame: &Frame, ray: &Ray, hit: &Hit, culls_back_faces: bool) -> bool {
    let is_there =
        !culls_back_faces || predicate::is_front_along(ray.direction, frame.triangles().corners(hit.triangle));
    is_there && frame.is_solid(hit.triangle, hit.barycentric)
}

/// Where `ray` meets the triangle that it is known to show.
fn hit_of(frame: &Frame, ray: &Ray, seen: u32) -> Option<Hit> {
    if seen == SeenPixels::NONE { None } else { predicate::hit(ray, frame.triangles(), seen) }
}
