//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod see;
mod shade;
mod shadow;
mod single_rays;

use umbrage_rays::{
    Bvh, GridCounts, Hit, KdTree, LightGrid, LightGridCounts, LightGridSeconds, ListedGrid, ListedLightGrid, Omitted,
    PerspectiveGrid, Ray, SeenPixels, SimdLevel, UniformGrid, UniformOptions, predicate,
};
use umbrage_scene::Frame;

use crate::{Error, Settings, Settled, Structure};
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

    /// Rebuilds what serves all samples of a frame: the uniform grid, the kd-tree, or the hierarchy where anything needs it. Other grids
    /// are made for the rays of one sample, by the stages that trace them.
    pub(crate) fn build(&mut self, frame: &Frame, settings: &Settings) -> Result<(), Error> {
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
        match self.structure {
            Structure::Grid(mut options) => {
                if frame.is_see_through() || settings.bounces > 0 {
                    // Rays that come one at a time need them where triangles crowd: a twelfth of the time for `demo:glass`.
                    options.nested_above = options.nested_above.or(UniformOptions::NESTED.nested_above);
                }
                let set = self.uniform_grid.set_options(options);
                set.map_err(|impossible| Error::Settings(impossible.to_string()))?;
                self.uniform_grid.build(frame.triangles());
            }
            Structure::KdTree(options) => {
                let set = self.kd_tree.set_options(options);
                set.map_err(|impossible| Error::Settings(impossible.to_string()))?;
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

    /// What finds the hits of rays that come one at a time.
    fn single_rays(&self) -> SingleRays<'_> {
        match self.structure {
            Structure::Grid(_) => SingleRays::Grid(&self.uniform_grid),
            Structure::KdTree(_) => SingleRays::KdTree(&self.kd_tree),
            Structure::Perspective | Structure::Listed { .. } | Structure::Bvh => SingleRays::Bvh(&self.bvh),
        }
    }

    /// What each pixel showed at the last sample.
    pub(crate) fn seen(&self) -> &SeenPixels {
        &self.seen
    }

    /// For each light, which pixels it lit at the last sample.
    pub(crate) fn light_masks(&self) -> &[LightMask] {
        &self.lit
    }

    /// What the camera was as work for its grid, at the last sample; zero where there is none.
    pub(crate) fn camera_work(&self) -> GridCounts {
        self.camera_work
    }

    /// What each light was as work for its grid, at the last sample; empty where there is none.
    pub(crate) fn light_work(&self) -> &[LightWork] {
        &self.light_work
    }

    pub(crate) fn omitted(&self) -> &Omitted {
        match self.structure {
            Structure::Perspective => self.camera_grid.omitted(),
            Structure::Listed { .. } => self.listed_grid.omitted(),
            Structure::Grid(_) => self.uniform_grid.omitted(),
            Structure::KdTree(_) => self.kd_tree.omitted(),
            Structure::Bvh => self.bvh.omitted(),
        }
    }

    pub(crate) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// What of the last frame's camera rays and shadow rays was left to the predicate; only the direct grids count that.
    pub(crate) fn settled(&self) -> [Option<Settled>; 2] {
        let is_counted = self.structure == Structure::Perspective;
        self.settled_tests.map(|tests| is_counted.then(|| Settled { tests, ..Settled::default() }))
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        match self.structure {
            Structure::Perspective => self.bvh.bytes() + self.camera_grid.bytes() + self.light_grid.triangle_bytes(),
            Structure::Listed { .. } => self.bvh.bytes() + self.listed_grid.bytes() + self.listed_light_grid.bytes(),
            Structure::Grid(_) => self.uniform_grid.bytes(),
            Structure::KdTree(_) => self.kd_tree.bytes(),
            Structure::Bvh => self.bvh.bytes(),
        }
    }

    pub(crate) fn point_bytes(&self) -> usize {
        match self.structure {
            Structure::Perspective => self.light_grid.bytes() - self.light_grid.triangle_bytes(),
            // The paper's form counts with the triangles: its points and triangles share lists.
            Structure::Listed { .. } | Structure::Grid(_) | Structure::KdTree(_) | Structure::Bvh => 0,
        }
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        let SeenPixels { triangle, inverse_depth, .. } = &self.seen;
        size_of_val(triangle.as_slice())
            + size_of_val(inverse_depth.as_slice())
            + self.lit.iter().map(LightMask::bytes).sum::<usize>()
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
