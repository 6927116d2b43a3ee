//! What breaks ray tracers, through every form of both grids, against the oracle in every pixel.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};
use umbrage_verify::{Oracle, Random, Sheet, SheetShape, Shot, TestMesh, Truth};

const OFFSET_PIXELS: DVec2 = DVec2::new(0.5, 0.375);

/// Worlds of every size, near the origin and far from it.
const WORLDS: [(f32, Vec3); 5] = [
    (1.0, Vec3::ZERO),
    (1e-6, Vec3::ZERO),
    (1e6, Vec3::ZERO),
    (1.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
    (300.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
];

fn point(position: Vec3) -> LightSource {
    LightSource::Point { position }
}

fn sun(x: f32, y: f32, z: f32) -> LightSource {
    LightSource::Directional { direction: Vec3::new(x, y, z).normalize() }
}

/// A camera above the middle of the world that looks slightly downwards.
fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8)
}

/// The same, with parallel rays.
fn parallel_camera() -> Camera {
    Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera() }
}

fn view(camera: Camera, width: u32, height: u32) -> View {
    View { camera, width, height }
}

fn placed(camera: Camera, scale: f32, offset: Vec3) -> Camera {
    let projection = match camera.projection {
        Projection::Orthographic { half_height } => Projection::Orthographic { half_height: half_height * scale },
        perspective @ Projection::Perspective { .. } => perspective,
    };
    Camera { position: camera.position * scale + offset, projection, ..camera }
}

fn check(name: &str, mesh: &TestMesh, view: View, lights: &[LightSource]) -> Vec<u64> {
    Shot { triangles: mesh.triangles(), view, offset_pixels: OFFSET_PIXELS, lights }.check(name)
}

#[test]
fn lights_on_behind_and_grazing_surfaces() {
    let room = TestMesh::room();
    for (world, (scale, offset)) in WORLDS.into_iter().enumerate() {
        let mesh = room.clone().placed(scale, offset);
        let corners = |id: u32| mesh.triangles().corners(id);
        let mut lights = Vec::new();
        // At vertices, in edges and inside triangles of the floor, the ball and the wall; and just beside.
        for id in [0, 37, 70, 130, 200, 300, mesh.indices.len() as u32 - 1] {
            let [a, b, c] = corners(id);
            let inside = a + ((b - a) + (c - a)) * 0.25;
            lights.extend([a, a.midpoint(b), inside].map(point));
            lights.extend([inside.with_y(inside.y.next_up()), inside.with_y(inside.y.next_down())].map(point));
        }
        let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
        // In the floor's plane far away, barely above and below it, and behind the floor, the wall and the camera.
        lights.extend([at(40.0, -1.0, 3.0), at(40.0, -0.999_99, 3.0), at(3.0, -1.000_01, 0.0)]);
        lights.extend([at(0.5, -3.0, 0.0), at(0.0, 0.0, -1.5), at(0.3, 0.4, -9.0), at(1.0, 3.0, 30.0)]);
        lights.push(point(camera().position * scale + offset));
        // Along the floor, along the wall, and from behind both.
        lights.extend([sun(1.0, 0.0, 0.0), sun(1.0, -1e-6, 0.0), sun(1.0, 1e-6, 0.1), sun(0.0, -1.0, 0.0)]);
        lights.extend([sun(0.0, 1.0, 0.0), sun(0.1, -0.2, 1.0)]);
        // Each camera has half of the lights in this world, and the other half in the next.
        for (number, camera) in [camera(), parallel_camera()].into_iter().enumerate() {
            let half: Vec<_> = lights.iter().copied().skip((world + number) % 2).step_by(2).collect();
            let view = view(placed(camera, scale, offset), 17, 13);
            check(&format!("scale {scale} at {offset}"), &mesh, view, &half);
        }
    }
}

#[test]
fn triangles_of_every_bad_shape() {
    let mut random = Random::new(31);
    let mut room = TestMesh::room();
    for _ in 0..30 {
        // Slivers, needles, and points that still have an area.
        let (a, b) = (random.point() * 1.5, random.point() * 1.5);
        room.push([a, b, a.lerp(b, random.unit()) + random.point() * 1e-6]);
        room.push([a, a + random.point() * 1e-5, b + random.point() * 2.0]);
        room.push([a, Vec3::new(a.x.next_up(), a.y, a.z), Vec3::new(a.x, a.y.next_up(), a.z)]);
        room.push([(); 3].map(|()| b + random.point() * 1e-7));
    }
    // Points and lines without any.
    let (a, b) = (random.point(), random.point());
    [[a, a, a], [a, b, a], [a, a.midpoint(b), b]].into_iter().for_each(|corners| room.push(corners));
    // Triangles that span the whole view and reach around the camera and the lights, and far beyond all else.
    for reach in [6.0, 1e3, 1e6] {
        let plane = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * reach;
        room.push([plane(-1.0, -0.7, -1.0), plane(1.0, -0.8, -1.0), plane(0.1, -0.9, 1.0)]);
        room.push([plane(-1.0, 1.0, -1.0), plane(1.0, 1.0, -1.0), plane(0.1, 0.9, 1.0)]);
    }
    for (scale, offset) in WORLDS {
        let mesh = room.clone().placed(scale, offset);
        let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
        let lights =
            [at(2.0, 3.0, 1.0), at(0.1, 0.5, 0.2), at(-0.5, -0.9, 0.75), at(1.0, 1.5, 4.0), sun(0.3, -1.0, 0.2)];
        for camera in [camera(), parallel_camera()] {
            let view = view(placed(camera, scale, offset), 33, 25);
            check(&format!("scale {scale} at {offset}"), &mesh, view, &lights);
        }
    }
}

#[test]
fn ten_thousand_identical_triangles() {
    let mut mesh = TestMesh::room();
    let copy = [Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, -0.5, 1.0), Vec3::new(-1.0, 0.5, 1.0)];
    (0..10_000).for_each(|_| mesh.push(copy));
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), sun(0.3, -1.0, 0.2)];
    check("copies", &mesh, view(camera(), 21, 16), &lights);
    check("copies", &mesh, view(parallel_camera(), 9, 7), &lights);
    // A light in their edge leaves all of them to exact arithmetic.
    check("copies", &mesh, view(camera(), 6, 4), &[point(copy[0].midpoint(copy[1]))]);
}

#[test]
fn a_million_triangles_in_one_light_cell() {
    let mut mesh = TestMesh::floor(8);
    let camera = Camera::look_at(Vec3::new(0.2, 0.9, 1.5), Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 0.7);
    let view = view(camera, 40, 30);
    // Plates above what one pixel shows, and above the camera: each is within one of 192² cells of what is seen.
    let ray = view.ray(20.0 + OFFSET_PIXELS.x, 15.0 + OFFSET_PIXELS.y);
    let shaded = Oracle::new(mesh.triangles()).nearest(&ray, |_| true).expect("the floor").t;
    let middle = (ray.origin + ray.direction * shaded).as_vec3();
    let plate = |height: f32| {
        [(-0.004, -0.003), (0.005, -0.004), (0.001, 0.005)].map(|(x, z)| Vec3::new(middle.x + x, height, middle.z + z))
    };
    // Straight from above, all plates have the shadow of one; of a lamp above their middle, the highest has the largest.
    let lights = [sun(0.0, -1.0, 0.0), point(middle.with_y(4000.0))];
    let shot = |mesh: &TestMesh, check: &mut dyn FnMut(Shot<'_>)| {
        check(Shot { triangles: mesh.triangles(), view, offset_pixels: OFFSET_PIXELS, lights: &lights });
    };
    let mut truth = Truth::default();
    mesh.push(plate(2.0));
    shot(&mesh, &mut |shot| truth = shot.truth());
    for lit in &truth.lit {
        assert!(!lit[15 * 40 + 20] && lit.iter().filter(|&&lit| lit).count() > 1000);
    }
    (1..1_000_000).for_each(|number| mesh.push(plate(2.0 - 1e-6 * number as f32)));
    shot(&mesh, &mut |shot| {
        shot.compare(&truth, 1, "plates");
    });
}

#[test]
fn a_million_points_in_one_light_cell() {
    // A card of a thousandth of what else is seen fills nearly all of the image; a ball half shadows it.
    let mut mesh = TestMesh::ball(2).placed(2.5e-4, Vec3::new(1e-4, 3e-4, 3e-4));
    let card = |x: f32, y: f32| Vec3::new(x, y, -0.3 * y - 1e-3) * 1e-3;
    mesh.push([card(-1.0, -1.0), card(0.9, -1.0), card(0.9, 1.0)]);
    mesh.push([card(-1.0, -1.0), card(0.9, 1.0), card(-1.0, 1.0)]);
    for (a, b, c) in [((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0)), ((-2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))] {
        mesh.push([a, b, c].map(|(x, y)| Vec3::new(x, y, -2.0)));
    }
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2e-3), Vec3::ZERO, Vec3::Y, 0.9);
    let lights = [point(Vec3::new(0.3, 2.0, 3.0)), point(Vec3::new(4.0, 1.0, 8.0)), sun(0.0, -0.3, -1.0)];
    let shot = |width: u32, height: u32, offset_pixels: DVec2, check: &mut dyn FnMut(Shot<'_>)| {
        check(Shot { triangles: mesh.triangles(), view: view(camera, width, height), offset_pixels, lights: &lights });
    };
    shot(1024, 1024, OFFSET_PIXELS, &mut |shot| {
        let in_one_cell = mesh.indices.len() as u32 - 4..mesh.indices.len() as u32 - 2;
        // Every pixel asks too much of the oracle: one in so many, and the grids of each other.
        const EVERY: u32 = 1009;
        let truth = shot.truth_of_some(EVERY);
        let on_card = truth.triangle.iter().filter(|id| in_one_cell.contains(id)).count();
        let elsewhere = truth.triangle.iter().filter(|&&id| id >= in_one_cell.end).count();
        assert!(on_card * 100 > truth.triangle.len() * 75 && elsewhere > 5, "{on_card} {elsewhere}");
        for lit in &truth.lit {
            let lit = lit.iter().filter(|&&lit| lit).count();
            assert!((100..truth.triangle.len() - 10).contains(&lit), "{lit}");
        }
        shot.compare(&truth, EVERY, "card");
    });
}

#[test]
fn points_that_no_face_of_a_light_can_hold() {
    // Lights in vertices of a sheet that rays go through exactly: those points are on their light.
    let mut random = Random::new(32);
    for (position, scale) in [(Vec3::ZERO, 1.0), (Vec3::new(148_376.0, 1_234.0, -223_423.0), 4.0)] {
        for is_orthographic in [false, true] {
            let shape = SheetShape { side: 16, step: 1, position, scale, is_orthographic, has_shell: false };
            let sheet = Sheet::new(shape, &mut random);
            let inside = [60, 130, 200, 244].map(|vertex: usize| point(sheet.mesh.positions[vertex]));
            let (triangles, offset_pixels) = (sheet.mesh.triangles(), sheet.offset_pixels);
            let shot = Shot { triangles, view: sheet.view, offset_pixels, lights: &inside };
            let outliers = shot.check(&format!("{shape:?}"));
            assert!(outliers.iter().all(|&count| count > 0), "{outliers:?} {shape:?}");
        }
    }
    // Depths beyond what an inverse depth can be.
    let room = TestMesh::room();
    let (scale, offset) = (1e32, Vec3::ZERO);
    let mesh = room.clone().placed(scale, offset);
    let lights = [point(Vec3::new(1.0, 3.0, 1.0) * scale), sun(0.2, -1.0, 0.1)];
    let outliers = check("huge", &mesh, view(placed(camera(), scale, offset), 23, 17), &lights);
    assert!(outliers.iter().all(|&count| count > 200), "{outliers:?}");
    // A telescope that is so far away that its points are about as wrong as they are far from their light.
    let forward = Vec3::new(-0.25, -0.5, -1.0).normalize();
    let (right, far) = (forward.cross(Vec3::Y).normalize(), 2e12_f32);
    let projection = Projection::Perspective { tan_half_height: 1.5 / far };
    let telescope = Camera { position: -forward * far, right, up: right.cross(forward), forward, projection };
    let lights = [point(Vec3::new(0.5, -0.9999, 0.5)), point(Vec3::new(0.3, 0.4, 0.2))];
    let outliers = check("telescope", &room, view(telescope, 23, 17), &lights);
    assert!(outliers[0] > 0, "{outliers:?}");
}

#[test]
fn seams_in_views_of_parallel_rays_that_are_turned() {
    let mut random = Random::new(33);
    for (scale, height) in
        [(1.0, 0.0), (1.0 / 1_048_576.0, 0.0), (1_048_576.0, 0.0), (4.0, 148_376.0), (0.125, -1_234.0)]
    {
        for _ in 0..8 {
            let (sin, cos) = (random.unit() * 6.0).sin_cos();
            let (forward, right) = (Vec3::new(sin, 0.0, cos), Vec3::new(cos, 0.0, -sin));
            // The rays of column 8 are in a plane through the world's upward axis. Two triangles share an edge in it, and
            // their corners there have coordinates without roundings.
            let position = Vec3::Y * height;
            let at = |away: f32, up: f32| forward * (away * scale) + Vec3::Y * (height + up * scale);
            let beside = |side: f32| right * (side * scale) + at(5.0, 0.5);
            let mut mesh = TestMesh::default();
            mesh.push([at(4.0, 1.5), at(8.0, -1.5), beside(3.0)]);
            mesh.push([at(8.0, -1.5), at(4.0, 1.5), beside(-3.0)]);
            mesh.push([at(9.0, -9.0), at(9.0, 9.0), right * (-9.0 * scale) + at(9.0, 0.0)]);
            mesh.push([at(9.0, 9.0), at(9.0, -9.0), right * (9.0 * scale) + at(9.0, 0.0)]);
            let projection = Projection::Orthographic { half_height: 2.0 * scale };
            let camera = Camera { position, right, up: Vec3::Y, forward, projection };
            let lights = [LightSource::Directional { direction: forward }, point(at(2.0, 0.0))];
            for ids in [[0, 1, 2, 3], [1, 0, 3, 2]] {
                let mesh = TestMesh { indices: ids.map(|id: usize| mesh.indices[id]).into(), ..mesh.clone() };
                let offset_pixels = DVec2::new(0.0, 0.5);
                let view = view(camera, 16, 16);
                let shot = Shot { triangles: mesh.triangles(), view, offset_pixels, lights: &lights };
                shot.check(&format!("scale {scale}, height {height}, {forward}"));
            }
        }
    }
}
