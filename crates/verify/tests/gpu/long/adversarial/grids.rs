//! The GPU's grids, in all their forms, against the truth.

use glam::Vec3;
use umbrage_gpu::{
    CameraGrid, CameraOptions, Geometry, Gpu, GpuError, LightGrid, LightOptions, LightWork, Recorder, Sight,
    TriangleFlags,
};
use umbrage_rays::{DirectGrids, LightMask, LightSource, SeenPixels, Structure as _, TileOrder, View};
use umbrage_verify::lights::point;
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, TestMesh, Truth};

use crate::common::{Pool, Pooled, gpu};

/// Both mappings of the camera's grid, one and many slices, each with a map of lights with one and with several. Each
/// form of the camera's grid has kernels of its own, which take seconds to compile.
const FORMS: [(CameraOptions, [LightOptions; 2]); 2] = [
    (CameraOptions { mapping: 1, slices: 16 }, [FACES, LightOptions { slices: 5, ..FACES }]),
    (CameraOptions { mapping: 2, slices: 1 }, [SPHERICAL, LightOptions { slices: 3, ..SPHERICAL }]),
];

/// Lights that see through faces.
const FACES: LightOptions = LightOptions { is_spherical: false, clamp: None, slices: 1 };
/// Lights that see by angles.
pub(crate) const SPHERICAL: LightOptions = LightOptions { is_spherical: true, ..FACES };

/// Maximum number of questions for the oracle; the CPU's grids, which have been compared with it, answer more.
const MOST_QUESTIONS: usize = 10_000_000;

/// A device and its grids.
pub(crate) struct Grids {
    gpu: Gpu,
    geometry: Geometry,
    cameras: [CameraGrid; FORMS.len()],
    lights: LightGrid,
}

/// Grids on the shared device. `None` without an adapter.
pub(crate) fn grids() -> Option<Pooled<Grids>> {
    static GRIDS: Pool<Grids> = Pool::new();
    let gpu = gpu()?;
    Some(GRIDS.take(|| Grids {
        geometry: Geometry::new(&gpu),
        cameras: FORMS.map(|(camera, _)| CameraGrid::new(&gpu, camera)),
        lights: LightGrid::new(&gpu),
        gpu,
    }))
}

impl Grids {
    /// Compares every form with the truth, from the oracle if that has few enough questions.
    pub(crate) fn check(&mut self, name: &str, case: &Case) {
        let View { width, height, .. } = case.view;
        let questions = (width * height) as usize * case.mesh.indices.len() * (1 + case.lights.len());
        let truth = if questions <= MOST_QUESTIONS { case.truth() } else { truth_of_cpu(case) };
        self.check_against(name, case, &truth);
    }

    /// Compares every form with a known truth.
    pub(crate) fn check_against(&mut self, name: &str, case: &Case, truth: &Truth) {
        for (form, (_, lights)) in FORMS.into_iter().enumerate() {
            for options in lights {
                self.check_form(name, case, truth, form, options);
            }
        }
    }

    /// Compares lights with these options with the truth.
    pub(crate) fn check_lights(&mut self, name: &str, case: &Case, truth: &Truth, options: LightOptions) {
        self.check_form(name, case, truth, 0, options);
    }

    fn check_form(&mut self, name: &str, case: &Case, truth: &Truth, form: usize, options: LightOptions) {
        self.geometry.write(&self.gpu, case.mesh.triangles(), |id| number(case, id)).expect("a small scene");
        let about = || format!("{name}, {:?}, {options:?}", FORMS[form].0);
        let found = self.shown(case, form, options).unwrap_or_else(|error| panic!("{}: {error}", about()));
        let complaint = complaint(case, &found, truth);
        assert!(complaint.is_none(), "{}: {}", about(), complaint.unwrap_or_default());
    }

    /// Work of the last compared case's lights.
    pub(crate) fn work(&self) -> &[LightWork] {
        self.lights.work()
    }

    /// Number of faces of each light.
    pub(crate) fn faces(&mut self, case: &Case) -> Vec<u32> {
        self.shown(case, 0, LightOptions::default()).expect("a small scene");
        self.work().iter().map(|work| work.faces).collect()
    }

    /// Answers of a form of the camera's grid, and of lights with these options.
    fn shown(&mut self, case: &Case, form: usize, options: LightOptions) -> Result<Truth, GpuError> {
        let Self { gpu, geometry, cameras, lights } = self;
        let camera = &mut cameras[form];
        lights.set_options(gpu, options);
        let sources: Vec<_> = case.lights.iter().copied().map(Some).collect();
        // Frames grow buffers that were too small; none needs more than a few.
        for _ in 0..8 {
            camera.prepare(gpu, geometry, &case.view, case.offset_pixels, Sight::default())?;
            lights.prepare(gpu, geometry, &case.view, case.offset_pixels, &sources)?;
            let mut recorder = Recorder::new(gpu);
            camera.record(gpu, &mut recorder, geometry);
            lights.record(gpu, &mut recorder, geometry, camera.seen());
            let done = recorder.submit_and_wait()?;
            if camera.finish(gpu, &done)? && lights.finish(gpu, &done)? {
                return read(gpu, camera, lights, case.view, sources.len());
            }
        }
        panic!("grown eight times: {:?} {:?}", camera.work(), lights.work());
    }
}

/// A triangle's flags.
fn number(case: &Case, id: u32) -> u32 {
    TriangleFlags { is_one_sided: !case.sides.has_back(id), ..TriangleFlags::default() }.with_material(0)
}

fn read(gpu: &Gpu, camera: &CameraGrid, lights: &LightGrid, view: View, count: usize) -> Result<Truth, GpuError> {
    let order = TileOrder::new(view.width, view.height);
    let seen: Vec<u32> = camera.seen().read(gpu, order.slots())?;
    let words = lights.mask_words() as usize;
    let lit: Vec<u32> = lights.lit().read(gpu, words * count)?;
    let is_lit = |light: usize, place: usize| lit[light * words + place / 32] >> (place % 32) & 1 == 1;
    let places: Vec<_> = pixels(view).map(|(x, y)| order.index(x, y)).collect();
    Ok(Truth {
        triangle: places.iter().map(|&place| seen[place]).collect(),
        lit: (0..count).map(|light| places.iter().map(|&place| is_lit(light, place)).collect()).collect(),
    })
}

/// The first difference between a GPU's answers and the truth, and the number of differences; `None` if there are none.
fn complaint(case: &Case, found: &Truth, truth: &Truth) -> Option<String> {
    let at = |place: usize| (place as u32 % case.view.width, place as u32 / case.view.width);
    let others = |found: &[u32], truth: &[u32]| -> Vec<usize> {
        assert_eq!(found.len(), truth.len());
        (0..truth.len()).filter(|&place| found[place] != truth[place]).collect()
    };
    let triangles = others(&found.triangle, &truth.triangle);
    if let Some(&place) = triangles.first() {
        let (found, truth) = (found.triangle[place], truth.triangle[place]);
        return Some(format!("{} triangles, at {:?} {found} for {truth}", triangles.len(), at(place)));
    }
    for ((light, found), truth) in case.lights.iter().zip(&found.lit).zip(&truth.lit) {
        let [found, truth] = [found, truth].map(|lit| lit.iter().map(|&lit| u32::from(lit)).collect::<Vec<_>>());
        let shadows = others(&found, &truth);
        if let Some(&place) = shadows.first() {
            let found = found[place];
            return Some(format!("{} shadows of {light:?}, at {:?} {found}", shadows.len(), at(place)));
        }
    }
    None
}

/// Columns and rows, row by row.
fn pixels(view: View) -> impl Iterator<Item = (u32, u32)> {
    (0..view.height).flat_map(move |y| (0..view.width).map(move |x| (x, y)))
}

/// The answers of the CPU's grids.
pub(crate) fn truth_of_cpu(case: &Case) -> Truth {
    let (shot, mut grids, mut seen) = (case.shot(), DirectGrids::default(), SeenPixels::default());
    grids.build(shot.triangles);
    grids.see(&shot, &mut seen).expect("a small image");
    let mut masks = vec![LightMask::default(); case.lights.len()];
    grids.shadow(&shot, &seen, &case.lights, &mut masks);
    let lit = masks.iter().map(|mask| case.pixels().map(|(x, y)| mask.is_lit(x, y)).collect()).collect();
    Truth { triangle: case.pixels().map(|(x, y)| seen.triangle_at(x, y)).collect(), lit }
}

/// A case of a mesh, a view and lights.
pub(crate) fn case(mesh: &TestMesh, view: View, lights: &[LightSource]) -> Case {
    Case::new("", mesh.clone(), view, lights)
}

/// Worlds of every size, near the origin and far from it.
pub(crate) const WORLDS: [(f32, Vec3); 5] = [
    (1.0, Vec3::ZERO),
    (1.0 / (1 << 20) as f32, Vec3::ZERO),
    ((1 << 20) as f32, Vec3::ZERO),
    (1.0, Vec3::new(65_536.0, -65_536.0, 65_536.0)),
    (300.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
];

#[test]
fn comparisons_fail_where_they_should() {
    let mesh = TestMesh::room();
    let lights = [point(Vec3::new(0.5, 3.0, 1.0))];
    let case = case(&mesh, view(camera(), 20, 10), &lights);
    let truth = case.truth();
    assert_eq!(complaint(&case, &truth, &truth), None);
    assert_eq!(truth_of_cpu(&case), truth);
    let mut other = truth.clone();
    other.lit[0][47] ^= true;
    assert!(
        complaint(&case, &other, &truth).is_some_and(|text| text.starts_with("1 shadows") && text.contains("(7, 2)"))
    );
    other.triangle[31] ^= 1;
    assert!(complaint(&case, &other, &truth).is_some_and(|text| text.starts_with("1 triangles, at (11, 1)")));
    let nothing = Case { mesh: TestMesh::default(), ..case };
    assert!(nothing.truth().triangle.iter().all(|&id| id == SeenPixels::NONE));
}
