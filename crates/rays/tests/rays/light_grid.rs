//! The light grid against the predicate, pixel by pixel.

use glam::{DVec2, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage_rays::{
    Camera, LightGrid, LightSource, ListedLightGrid, ListedLightOptions, MaskAnswers, MaskPoints, Projection,
    SeenImage, SeenPixels, ShadowMask, SimdLevel, Triangles, Unmasked, View,
};

use crate::support::{Mesh, Random};

/// Whether a triangle can be hit at all, by the definition of what is left out.
fn usable(triangles: Triangles<'_>, id: u32) -> Option<[Vec3; 3]> {
    let corners = triangles.indices[id as usize].map(|vertex| triangles.positions.get(vertex as usize).copied());
    let [Some(a), Some(b), Some(c)] = corners else { return None };
    [a, b, c].iter().all(|corner| corner.is_finite()).then_some([a, b, c])
}

/// A scene with its camera and, by brute force, what the camera sees.
struct Case {
    name: String,
    mesh: Mesh,
    view: View,
    offset: DVec2,
    seen: SeenPixels,
}

impl Case {
    fn new(name: &str, mesh: Mesh, camera: Camera, (width, height): (u32, u32)) -> Self {
        let view = View { camera, width, height };
        let offset = DVec2::new(0.5, 0.4375);
        let mut case = Self { name: name.into(), mesh, view, offset, seen: SeenPixels::default() };
        let triangles = case.mesh.triangles();
        let mut seen = SeenPixels::default();
        seen.resize(width, height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let place = seen.order().place(x, y);
            let ray = case.ray((x, y));
            let hits = (0..triangles.len() as u32).filter_map(|id| {
                let t = crossing(&ray, usable(triangles, id)?)?.t;
                (t > 0.0).then_some((t, id))
            });
            if let Some((t, id)) = hits.min_by(|a, b| a.partial_cmp(b).expect("finite")) {
                // About as wrong as it may be.
                let error = 0.96 * SeenPixels::RELATIVE_ERROR;
                let error = [1.0, 1.0 - error, 1.0 + error][place % 3];
                (seen.triangle[place], seen.inverse_depth[place]) = (id, SeenPixels::inverse_of(t) * error);
            }
        }
        case.seen = seen;
        case
    }

    fn ray(&self, (x, y): (u32, u32)) -> umbrage_rays::Ray {
        self.view.ray(f64::from(x) + self.offset.x, f64::from(y) + self.offset.y)
    }

    fn image(&self) -> SeenImage<'_> {
        SeenImage { triangles: self.mesh.triangles(), view: self.view, offset_pixels: self.offset, seen: &self.seen }
    }

    /// The truth, in the order of `self.seen`.
    fn lit(&self, light: &LightSource, casts: impl Fn(u32, [f32; 2]) -> bool) -> Vec<bool> {
        let triangles = self.mesh.triangles();
        let lit = self.seen.triangle.iter().enumerate().map(|(place, &own)| {
            if own == SeenPixels::NONE {
                return false;
            }
            let ray = self.ray(self.seen.order().column_and_row(place));
            let t = crossing(&ray, triangles.corners(own)).expect("the pixel's triangle is hit").t;
            let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, t));
            !(0..triangles.len() as u32).filter(|&id| id != own).any(|id| {
                let blocks = usable(triangles, id).and_then(|corners| shadow_ray.blocked_by(corners));
                blocks.is_some_and(|barycentric| casts(id, barycentric))
            })
        });
        lit.collect()
    }

    /// Compares both grids with the truth for each light.
    fn check(&self, lights: &[LightSource]) {
        let mut listed = ListedLightGrid::default();
        listed.survey(&self.image());
        let mut grid = LightGrid::default();
        grid.survey(&self.image());
        for (light_place, light) in lights.iter().enumerate() {
            let mut lit = vec![u16::MAX; self.seen.triangle.len() / 16];
            grid.shadow(&self.image(), light, |_| true, &Unmasked, &mut lit);
            let found = bits(&lit);
            let truth = self.lit(light, |_, _| true);
            let wrong: Vec<usize> = (0..found.len()).filter(|&pixel| found[pixel] != truth[pixel]).collect();
            let counts = grid.counts();
            assert!(
                wrong.is_empty(),
                "{}: {light:?}: {} wrong, first {:?}, {counts:?}",
                self.name,
                wrong.len(),
                &wrong[..1]
            );
            grid.validate(&self.image(), light).unwrap_or_else(|broken| panic!("{}: {light:?}: {broken}", self.name));
            // Other cells and blocks for each light.
            let (cells, points, triangles) =
                [(192, 256, 512), (7, 16, 16), (1, 4096, 33), (64, 48, 5)][light_place % 4];
            listed.set_options(ListedLightOptions::new(cells, points, triangles).expect("possible cells"));
            let mut in_listed = vec![u16::MAX; lit.len()];
            listed.shadow(&self.image(), light, |_| true, &Unmasked, &mut in_listed);
            let (name, counts) = (&self.name, listed.counts());
            assert!(in_listed == lit, "{name}: {light:?} through lists: {counts:?}");
            assert_eq!((counts.points, counts.outliers), (grid.counts().points, grid.counts().outliers), "{name}");
            let checked = listed.validate(&self.image(), light);
            checked.unwrap_or_else(|broken| panic!("{name}: {light:?} through lists: {broken}"));
        }
    }
}

fn bits(words: &[u16]) -> Vec<bool> {
    words.iter().flat_map(|word| (0..16).map(move |place| word >> place & 1 == 1)).collect()
}

fn point(x: f32, y: f32, z: f32) -> LightSource {
    LightSource::Point { position: Vec3::new(x, y, z) }
}

/// Lights in front of, above, inside, on and behind everything, near and far.
fn lights(scale: f32, offset: Vec3) -> Vec<LightSource> {
    let at = |x: f32, y: f32, z: f32| LightSource::Point { position: Vec3::new(x, y, z) * scale + offset };
    let spot = LightSource::Spot {
        position: Vec3::new(2.0, 3.0, 1.0) * scale + offset,
        direction: Vec3::new(-2.0, -3.0, -1.0).normalize(),
        inner_radians: 0.2,
        outer_radians: 0.4,
    };
    let sun = |x: f32, y: f32, z: f32| LightSource::Directional { direction: Vec3::new(x, y, z).normalize() };
    vec![
        at(3.0, 5.0, 2.0),
        at(0.3, 0.2, 0.1),
        at(0.0, -1.0, 0.0),
        at(-0.6, -0.999, 0.7),
        at(500.0, 900.0, 300.0),
        at(0.0, 1.7, -6.0),
        spot,
        sun(0.3, -1.0, 0.2),
        sun(0.0, -1.0, 0.0),
        sun(1.0, -0.01, 0.0),
    ]
}

/// A bumpy ball above a floor.
fn room() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::new(0.0, 0.1, 0.0), 0.8, 9, 0.1);
    let corner = |x: f32, z: f32| Vec3::new(4.0 * x, -1.0, 4.0 * z);
    mesh.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    mesh
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8)
}

#[test]
fn a_ball_above_a_floor() {
    for size in [(1, 1), (2, 1), (37, 29), (64, 3), (17, 40)] {
        Case::new("room", room(), camera(), size).check(&lights(1.0, Vec3::ZERO));
    }
}

#[test]
fn scales_and_offsets() {
    let far = Vec3::new(148_376.0, 1_234.0, -223_423.0);
    for (scale, offset) in [(1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, far), (300.0, far)] {
        let mut camera = camera();
        camera.position = camera.position * scale + offset;
        let case = Case::new(&format!("room × {scale}"), room().moved(scale, offset), camera, (31, 23));
        case.check(&lights(scale, offset));
    }
}

#[test]
fn an_orthographic_camera() {
    let projection = Projection::Orthographic { half_height: 1.8 };
    Case::new("orthographic", room(), Camera { projection, ..camera() }, (33, 31)).check(&lights(1.0, Vec3::ZERO));
}

#[test]
fn soups_of_every_size() {
    let mut random = Random(5);
    for size in [0, 1, 2, 3, 15, 16, 17, 63, 64, 65, 200] {
        let mut mesh = Mesh::default();
        for _ in 0..size {
            let stretch = 10.0_f32.powf(random.unit() * 3.0 - 2.0);
            let center = random.point();
            mesh.push([(); 3].map(|()| center + random.point() * stretch));
        }
        let case = Case::new(&format!("{size} triangles"), mesh, camera(), (23, 19));
        let mut all = lights(1.0, Vec3::ZERO);
        all.extend((0..6).map(|_| LightSource::Point { position: random.point() * 1.5 }));
        all.extend((0..2).map(|_| LightSource::Directional { direction: random.point().normalize() }));
        case.check(&all);
    }
}

#[test]
fn needles_slivers_shells_and_copies() {
    let mut random = Random(9);
    let mut mesh = room();
    for _ in 0..40 {
        let place = random.point();
        mesh.push([place, place + random.point() * 1e-4, place + random.point() * 3.0]);
        let (a, b) = (random.point(), random.point());
        mesh.push([a, b, a.lerp(b, random.unit()) + random.point() * 1e-6]);
    }
    // A shell that touches the floor's plane, one just above it, and copies of one triangle.
    for height in [-1.0, -1.0 + 4e-5, -1.0 + 1e-7] {
        mesh.push([Vec3::new(-1.0, height, 0.5), Vec3::new(1.5, height, 0.7), Vec3::new(0.2, height, 2.0)]);
    }
    for _ in 0..100 {
        mesh.push([Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, -0.5, 1.0), Vec3::new(-1.0, 0.5, 1.0)]);
    }
    Case::new("needles", mesh, camera(), (37, 29)).check(&lights(1.0, Vec3::ZERO));
}

#[test]
fn triangles_around_the_light_and_beyond_every_bound() {
    let mut random = Random(3);
    let mut mesh = room();
    for reach in [3.0, 50.0, 1e4, 1e9, 1e18] {
        for _ in 0..4 {
            mesh.push([(); 3].map(|()| random.point() * reach));
        }
    }
    let light = Vec3::new(0.0, 1.7, 0.5);
    // One in the plane of the light, one with the light in a corner, one through it.
    mesh.push([light + Vec3::X, light - Vec3::Z * 0.5, light + Vec3::new(-2.0, 0.0, 1.0)]);
    mesh.push([light, light + Vec3::NEG_Y * 0.5, light + Vec3::new(0.3, -0.5, 0.0)]);
    mesh.push([light + Vec3::NEG_Y, light + Vec3::new(1.0, 0.5, 0.0), light + Vec3::new(-1.0, 0.5, 0.0)]);
    let mut all = lights(1.0, Vec3::ZERO);
    all.push(LightSource::Point { position: light });
    Case::new("around", mesh, camera(), (37, 29)).check(&all);
}

#[test]
fn broken_triangles_are_passed_over() {
    let mut mesh = room();
    let wrong = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for value in wrong {
        for axis in 0..3 {
            let mut corner = Vec3::ZERO;
            corner[axis] = value;
            mesh.push([corner, Vec3::X, Vec3::Y]);
            mesh.push([Vec3::X, Vec3::Y, corner]);
        }
    }
    mesh.push([Vec3::X; 3]);
    mesh.push([Vec3::X, Vec3::Y, Vec3::X]);
    let count = mesh.positions.len() as u32;
    mesh.indices.push([0, 1, count]);
    mesh.indices.push([u32::MAX, 1, 2]);
    // Two rings of the ball end in a point.
    assert_eq!(mesh.triangles().omitted().total(), 22 + 2 * 9);
    Case::new("broken", mesh, camera(), (37, 29)).check(&lights(1.0, Vec3::ZERO));
}

#[test]
fn lights_that_are_none_reach_everything() {
    let case = Case::new("room", room(), camera(), (20, 10));
    case.check(&[
        point(f32::NAN, 0.0, 0.0),
        point(0.0, f32::INFINITY, 0.0),
        LightSource::Directional { direction: Vec3::ZERO },
        LightSource::Directional { direction: Vec3::NAN },
    ]);
}

/// A mask of squares on every third triangle, which knows how far their borders are.
struct Squares;

impl Squares {
    fn is_opaque(id: u32) -> bool {
        !id.is_multiple_of(3)
    }

    fn square([b, c]: [f32; 2]) -> [u32; 2] {
        [(b * 7.0) as u32, (c * 7.0) as u32]
    }
}

impl ShadowMask for Squares {
    fn casts(&self, id: u32, barycentric: [f32; 2]) -> bool {
        let [b, c] = Self::square(barycentric);
        Self::is_opaque(id) || b % 2 == c % 2
    }

    fn which_cast(&self, id: u32, points: &MaskPoints) -> MaskAnswers {
        assert!(!Self::is_opaque(id), "nobody needs to ask");
        let MaskPoints { barycentric: [b, c], error, asked } = points;
        let mut answers = MaskAnswers::default();
        for point in (0..16).filter(|point| asked >> point & 1 == 1) {
            let error = error[point] + 1e-6;
            let at = |error: f32| Self::square([b[point] + error, c[point] + error]);
            if error >= 0.0 && at(-error) == at(error) {
                let casts = self.casts(id, [b[point], c[point]]);
                *if casts { &mut answers.solid } else { &mut answers.cut } |= 1 << point;
            }
        }
        answers
    }
}

#[test]
fn masked_triangles_let_light_through() {
    let far = Vec3::new(148_376.0, 1_234.0, -223_423.0);
    for (scale, offset) in [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (300.0, far)] {
        let mut camera = camera();
        camera.position = camera.position * scale + offset;
        let case = Case::new("masked", room().moved(scale, offset), camera, (37, 29));
        let mut grid = LightGrid::default();
        grid.survey(&case.image());
        let mut listed = ListedLightGrid::default();
        listed.survey(&case.image());
        let (mut masked, mut asked, mut asked_without) = (0, 0, 0);
        for light in lights(scale, offset) {
            let truth = case.lit(&light, |id, barycentric| Squares.casts(id, barycentric));
            let mut lit = vec![0; case.seen.triangle.len() / 16];
            grid.shadow(&case.image(), &light, Squares::is_opaque, &Squares, &mut lit);
            let mut in_listed = vec![0; lit.len()];
            listed.shadow(&case.image(), &light, Squares::is_opaque, &Squares, &mut in_listed);
            assert_eq!(in_listed, lit, "{light:?} through lists");
            assert_eq!(bits(&lit), truth, "{light:?}");
            (masked, asked) = (masked + grid.counts().masked, asked + grid.counts().asked);
            // Lights in corners and edges ask the predicate whatever the masks.
            grid.shadow(&case.image(), &light, |_| true, &Unmasked, &mut in_listed);
            asked_without += grid.counts().asked;
            // A function knows nothing of the points around.
            let casts = |id: u32, barycentric: [f32; 2]| Squares.casts(id, barycentric);
            grid.shadow(&case.image(), &light, Squares::is_opaque, &casts, &mut lit);
            assert_eq!(bits(&lit), truth, "{light:?}");
        }
        let for_masks = asked.saturating_sub(asked_without);
        assert!(masked > 100 && for_masks * 2 < masked, "{masked} masked pairs, {for_masks} for the predicate");
    }
}

#[test]
fn ten_thousand_identical_triangles() {
    let copy = [Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, -0.5, 1.0), Vec3::new(-1.0, 0.5, 1.0)];
    let mut mesh = room();
    mesh.push(copy);
    let mut case = Case::new("copies", mesh, camera(), (37, 29));
    let lights = [point(3.0, 5.0, 2.0), LightSource::Directional { direction: Vec3::new(0.3, -1.0, 0.2) }];
    // What one of them shadows, all do, and none another.
    let truth = lights.map(|light| case.lit(&light, |_, _| true));
    (1..10_000).for_each(|_| case.mesh.push(copy));
    let mut grid = LightGrid::default();
    grid.survey(&case.image());
    for (light, truth) in lights.iter().zip(truth) {
        let mut lit = vec![0; case.seen.triangle.len() / 16];
        grid.shadow(&case.image(), light, |_| true, &Unmasked, &mut lit);
        assert_eq!(bits(&lit), truth, "{light:?}");
    }
}

#[test]
fn triangles_barely_in_front_of_what_is_seen() {
    // A floor of small triangles, and others a little above and below it: the light has to tell their nearness apart.
    // From below the floor, the camera sees what they shadow.
    let mut random = Random(11);
    let mut mesh = Mesh::default();
    let at = |x: i32, z: i32| Vec3::new(0.12 * x as f32, -0.5, 0.12 * z as f32);
    for (x, z) in (-12..12).flat_map(|x| (-12..12).map(move |z| (x, z))) {
        mesh.quad([at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)]);
    }
    for height in [1e-2, 1e-4, 1e-5, 3e-6, -1e-5, -1e-2] {
        for _ in 0..60 {
            let center = Vec3::new(random.unit() * 2.4 - 1.2, -0.5 + height, random.unit() * 2.4 - 1.2);
            mesh.push([(); 3].map(|()| center + random.point() * 0.06 * Vec3::new(1.0, 0.0, 1.0)));
        }
    }
    let sun = |x: f32, y: f32, z: f32| LightSource::Directional { direction: Vec3::new(x, y, z) };
    let lights = [point(0.2, 4.0, 0.1), point(0.0, -0.2, 0.0), sun(0.0, -1.0, 0.0), sun(1.0, -0.2, 0.1)];
    let below = Camera::look_at(Vec3::new(0.3, -3.5, 1.0), Vec3::new(0.0, -0.5, 0.0), Vec3::X, 0.8);
    Case::new("barely", mesh, below, (37, 29)).check(&lights);
}

#[test]
fn scenes_on_a_lattice_with_lights_in_their_corners() {
    // Corners, cameras and lights that meet exactly; the seeds are some at which bounds of zero fail.
    for seed in 1030..1038 {
        let mut random = Random(seed);
        let mut mesh = Mesh::default();
        let quantum = [0.0, 0.25, 0.5, 0.01][(random.bits() % 4) as usize];
        let snap = |point: Vec3| if quantum > 0.0 { (point / quantum).round() * quantum } else { point };
        for _ in 0..1 + random.bits() % 150 {
            let stretch = 10.0_f32.powf(random.unit() * 4.0 - 3.0);
            let center = random.point();
            let corners = [(); 3].map(|()| snap(center + random.point() * stretch));
            mesh.push(corners);
        }
        if random.bits().is_multiple_of(2) {
            mesh.ball(random.point(), random.unit(), 2 + (random.bits() % 8) as u32, 0.1);
        }
        if random.bits().is_multiple_of(2) {
            mesh.quad([(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, z)| Vec3::new(x, -1.0, z)));
        }
        let (from, to) = (snap(random.point() * 3.0), snap(random.point()));
        let mut camera = Camera::look_at(from, to, Vec3::Y, 0.3 + random.unit());
        let scale = [1.0, 1.0, 1e-6, 1e6, 77.0][(random.bits() % 5) as usize];
        let far = Vec3::new(148_376.0, 1_234.0, -223_423.0);
        let offset = if random.bits().is_multiple_of(4) { far } else { Vec3::ZERO };
        let mut lights = Vec::new();
        for kind in 0..6 {
            let position = match kind % 3 {
                0 => snap(random.point() * 2.0),
                1 => mesh.positions[random.bits() as usize % mesh.positions.len()],
                _ => random.point() * 10.0_f32.powf(random.unit() * 6.0 - 2.0),
            };
            lights.push(LightSource::Point { position: position * scale + offset });
            let direction = snap(random.point() * 2.0).try_normalize().unwrap_or(Vec3::X);
            lights.push(LightSource::Directional { direction });
        }
        camera.position = camera.position * scale + offset;
        let size = (1 + (random.bits() % 40) as u32, 1 + (random.bits() % 30) as u32);
        Case::new(&format!("seed {seed}"), mesh.moved(scale, offset), camera, size).check(&lights);
    }
}

#[test]
fn every_thread_count_and_instruction_set_gives_the_same_bits() {
    let mut mesh = room();
    let mut random = Random(1);
    (0..300).for_each(|_| {
        let center = random.point();
        mesh.push([(); 3].map(|()| center + random.point() * 0.2));
    });
    let case = Case::new("threads", mesh, camera(), (61, 47));
    let mut all = Vec::new();
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        for level in SimdLevel::available() {
            let mut words = Vec::new();
            pool.install(|| {
                let mut grid = LightGrid::with_level(level);
                grid.survey(&case.image());
                let mut listed = ListedLightGrid::with_level(level);
                listed.survey(&case.image());
                for light in lights(1.0, Vec3::ZERO) {
                    let mut lit = vec![0; case.seen.triangle.len() / 16];
                    grid.shadow(&case.image(), &light, |_| true, &Unmasked, &mut lit);
                    words.push(lit);
                }
            });
            all.push(words);
        }
    }
    assert!(all.iter().all(|words| *words == all[0]));
}
