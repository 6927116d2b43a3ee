use serde::Serialize;
use umbrage_rays::Omitted;
use umbrage_scene::TextureTraffic;
use web_time::Instant;

use crate::Film;
use crate::engine::{Engine, Staged};

/// Time, work and memory of a frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stats {
    /// Each stage's name and time, in the order in which they first ran.
    pub stages: Vec<Stage>,
    /// Triangles of the frame, counting those left out.
    pub triangles: usize,
    /// Vertices of the frame.
    pub vertices: usize,
    /// Points and lines of the frame.
    pub marks: usize,
    /// Points and lines that are left out of the picture: all of them on a GPU.
    pub omitted_marks: usize,
    /// Lights of the frame.
    pub lights: usize,
    /// Samples that each pixel took.
    pub samples: u32,
    /// Camera rays traced.
    pub camera_rays: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
    /// Camera-ray tests that the exact predicate settled, for surfaces seen first; `None` if the structure doesn't
    /// count them.
    pub settled_camera_rays: Option<Settled>,
    /// The same for shadow rays from these surfaces, over all lights.
    pub settled_shadow_rays: Option<Settled>,
    /// Bytes held by the acceleration structures for triangles.
    pub structure_bytes: usize,
    /// Bytes held by the light grid, which lights use in turn, for the visible points.
    pub point_bytes: usize,
    /// Bytes held by the frame's vertices, triangles and textures.
    pub frame_bytes: usize,
    /// Bytes held for pixels: the film, hits, light masks, and textures.
    pub pixel_bytes: usize,
    /// Bytes uploaded to the GPU for this frame; zero on the CPU.
    pub uploaded_bytes: u64,
    /// Cache statistics of textures on demand since the scene was opened; `None` if all textures are in memory.
    pub textures: Option<TextureTraffic>,
    /// Triangles that no ray can hit, by reason; reasons without triangles are left out.
    pub omitted: Vec<OmittedTriangles>,
}

/// Tests that filters left undecided and the exact predicate settled, over all samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Settled {
    /// Tests of a ray against a triangle; a ray may need several. The count for shadow rays may depend on the threads.
    pub tests: u64,
    /// Rays that needed any; `None` where only tests are counted: everywhere except for a GPU's camera rays.
    pub rays: Option<u64>,
    /// All rays, settled by filter or predicate.
    pub of_rays: u64,
}

/// One stage of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// The stage's one name.
    pub name: &'static str,
    /// Its wall time, over all samples.
    pub milliseconds: f64,
}

/// Triangles left out for one reason.
#[derive(Clone, Debug, Serialize)]
pub struct OmittedTriangles {
    /// Why, in words.
    pub reason: &'static str,
    /// How many.
    pub count: u32,
    /// The first of their ids.
    pub first_ids: Vec<u32>,
}

impl Stats {
    /// Time of all stages together, in milliseconds.
    #[must_use]
    pub fn total_milliseconds(&self) -> f64 {
        self.stages.iter().map(|stage| stage.milliseconds).sum()
    }

    pub(crate) fn start(&mut self) {
        self.stages.clear();
    }

    pub(crate) fn time<T>(&mut self, name: &'static str, stage: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = stage();
        self.add(name, start.elapsed().as_secs_f64() * 1e3);
        result
    }

    /// Adds to a stage's time.
    pub(crate) fn add(&mut self, name: &'static str, milliseconds: f64) {
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.milliseconds += milliseconds,
            None => self.stages.push(Stage { name, milliseconds }),
        }
    }

    /// Counts a frame that is done.
    pub(crate) fn count(&mut self, staged: &Staged<'_>, samples: u32, film: &Film, engine: &dyn Engine) {
        let Staged { frame, lights, view, .. } = staged;
        self.samples = samples;
        self.triangles = frame.mesh.triangles.len() - frame.mesh.ground_triangles;
        self.vertices = frame.positions.len();
        self.marks = frame.mesh.marks.len();
        self.lights = lights.len();
        self.camera_rays = u64::from(view.width) * u64::from(view.height) * u64::from(samples);
        self.frame_bytes = frame.bytes();
        self.textures = frame.materials.texture_traffic();
        self.pixel_bytes = film.bytes();
        engine.count(frame, self);
    }

    /// Stores the predicate's counts of camera rays and of shadow rays. The numbers of these rays must be known.
    pub(crate) fn count_settled(&mut self, [of_camera, of_lights]: [Option<Settled>; 2]) {
        self.settled_camera_rays = of_camera.map(|settled| Settled { of_rays: self.camera_rays, ..settled });
        self.settled_shadow_rays = of_lights.map(|settled| Settled { of_rays: self.shadow_rays, ..settled });
    }

    pub(crate) fn count_omitted(&mut self, omitted: &Omitted) {
        self.omitted.clear();
        self.omitted.extend(OmittedTriangles::of(omitted));
    }
}

impl OmittedTriangles {
    /// One entry for each reason that has triangles.
    pub fn of(omitted: &Omitted) -> impl Iterator<Item = Self> {
        let kinds = [
            ("a coordinate is not finite", &omitted.not_finite),
            ("two corners are in the same place", &omitted.zero_area),
            ("a vertex index is out of range", &omitted.index_out_of_range),
        ];
        kinds.into_iter().filter(|(_, kind)| kind.count > 0).map(|(reason, kind)| Self {
            reason,
            count: kind.count,
            first_ids: kind.first_ids.clone(),
        })
    }
}
