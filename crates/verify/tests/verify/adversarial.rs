//! What breaks ray tracers, through every form of both grids, against the oracle in every pixel.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};
use umbrage_verify::lights::{among_bad_shapes, in_bad_places, point, sun};
use umbrage_verify::views::{OFFSET_PIXELS, camera, parallel_camera, placed, telescope, view};
use umbrage_verify::{Plates, Random, Sheet, SheetShape, Shot, TestMesh};

/// Worlds of every size, near the origin and far from it.
const WORLDS: [(f32, Vec3); 5] = [
    (1.0, Vec3::ZERO),
    (1e-6, Vec3::ZERO),
    (1e6, Vec3::ZERO),
    (1.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
    (300.0, Vec3::new(148_376.0, 1_234.0, -223_423.0)),
];

fn check(name: &str, mesh: &TestMesh, view: View, lights: &[LightSource]) -> Vec<u64> {
    Shot { triangles: mesh.triangles(), view, offset_pixels: OFFSET_PIXELS, lights }.check(name)
}

#[test]
fn lights_on_behind_and_grazing_surfaces() {
    let room = TestMesh::room();
    for (world, (scale, offset)) in WORLDS.into_iter().enumerate() {
        let mesh = room.clone().placed(scale, offset);
        let lights = in_bad_places(&[0, 37, 70, 130, 200, 300], scale, offset);
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
    let room = TestMesh::bad_shapes(&mut Random::new(31));
    for (scale, offset) in WORLDS {
        let mesh = room.clone().placed(scale, offset);
        let lights = among_bad_shapes(scale, offset);
        for camera in [camera(), parallel_camera()] {
            let view = view(placed(camera, scale, offset), 33, 25);
            check(&format!("scale {scale} at {offset}"), &mesh, view, &lights);
        }
    }
}

#[test]
fn ten_thousand_identical_triangles() {
    let mesh = TestMesh::copies(10_000);
    let [a, b, _] = TestMesh::COPY;
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), sun(0.3, -1.0, 0.2)];
    check("copies", &mesh, view(camera(), 21, 16), &lights);
    check("copies", &mesh, view(parallel_camera(), 9, 7), &lights);
    // A light in their edge leaves all of them to exact arithmetic.
    check("copies", &mesh, view(camera(), 6, 4), &[point(a.midpoint(b))]);
}

#[test]
fn a_million_triangles_in_one_light_cell() {
    let mut plates = Plates::one();
    let truth = plates.truth();
    plates.pile(1_000_000, 1e-6);
    plates.shot().compare(&truth, 1, "plates");
}

#[test]
fn a_million_points_in_one_light_cell() {
    // A card of a thousandth of what else is seen fills nearly all of the image; a ball half shadows it.
    let mesh = TestMesh::card();
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
    let lights = [point(Vec3::new(0.5, -0.9999, 0.5)), point(Vec3::new(0.3, 0.4, 0.2))];
    let outliers = check("telescope", &room, view(telescope(2e12), 23, 17), &lights);
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
