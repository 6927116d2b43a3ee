//! Too much in one place.

use glam::Vec3;
use umbrage_rays::Camera;
use umbrage_verify::{Oracle, Random, TestMesh};

use crate::grids::{OFFSET_PIXELS, camera, grids, parallel_camera, point, shot, sun, truth_of_cpu, view};

#[test]
fn ten_thousand_identical_triangles() {
    let Some(mut grids) = grids() else { return };
    let mut mesh = TestMesh::room();
    let copy = [Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, -0.5, 1.0), Vec3::new(-1.0, 0.5, 1.0)];
    (0..10_000).for_each(|_| mesh.push(copy));
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), sun(0.3, -1.0, 0.2)];
    grids.check("copies", &shot(&mesh, view(camera(), 21, 16), &lights));
    grids.check("copies", &shot(&mesh, view(parallel_camera(), 9, 7), &lights));
    // A light in their edge leaves all of them to exact arithmetic.
    grids.check("copies", &shot(&mesh, view(camera(), 6, 4), &[point(copy[0].midpoint(copy[1]))]));
}

#[test]
fn a_crowd_in_one_plane() {
    // No filter can tell which is nearer: every pixel leaves hundreds of hits to exact arithmetic.
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(54);
    let mut mesh = TestMesh::default();
    for _ in 0..500 {
        let corners = [(); 3].map(|()| random.point() * 2.0).map(|corner| corner.with_y(corner.x * 0.5));
        mesh.push(corners);
    }
    let camera = Camera::look_at(Vec3::new(-1.0, 3.0, 0.2), Vec3::ZERO, Vec3::Z, 0.8);
    let lights = [point(Vec3::new(-1.0, 2.0, 0.0)), point(Vec3::new(0.5, 0.25, 0.0))];
    grids.check("one plane", &shot(&mesh, view(camera, 40, 30), &lights));
}

#[test]
fn hundreds_of_thousands_of_triangles_in_one_tile() {
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(55);
    let mut mesh = TestMesh::floor(8);
    // All of them are seen through four pixels on each axis; some are far larger than their pixels.
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    for number in 0..200_000 {
        let size = if number % 64 == 0 { 0.04 } else { 0.003 };
        let middle = random.point() * Vec3::new(0.06, 0.06, 1.0);
        mesh.push([(); 3].map(|()| middle + random.point() * size));
    }
    let lights = [point(Vec3::new(0.5, 2.0, 1.0)), sun(0.0, -1.0, 0.0)];
    grids.check("one tile", &shot(&mesh, view(camera, 100, 80), &lights));
}

#[test]
fn hundreds_of_thousands_of_triangles_in_one_light_cell() {
    let Some(mut grids) = grids() else { return };
    let mut mesh = TestMesh::floor(8);
    let camera = Camera::look_at(Vec3::new(0.2, 0.9, 1.5), Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 0.7);
    let view = view(camera, 40, 30);
    // Plates above what one pixel shows, and above the camera.
    let ray = view.ray(20.0 + OFFSET_PIXELS.x, 15.0 + OFFSET_PIXELS.y);
    let shaded = Oracle::new(mesh.triangles()).nearest(&ray, |_| true).expect("the floor").t;
    let middle = (ray.origin + ray.direction * shaded).as_vec3();
    let plate = |height: f32| {
        [(-0.004, -0.003), (0.005, -0.004), (0.001, 0.005)].map(|(x, z)| Vec3::new(middle.x + x, height, middle.z + z))
    };
    // Straight from above, all plates have the shadow of one; of a lamp above their middle, the highest has the largest.
    let lights = [sun(0.0, -1.0, 0.0), point(middle.with_y(4000.0))];
    mesh.push(plate(2.0));
    let truth = shot(&mesh, view, &lights).truth();
    for lit in &truth.lit {
        assert!(!lit[15 * 40 + 20] && lit.iter().filter(|&&lit| lit).count() > 1000);
    }
    (1..400_000).for_each(|number| mesh.push(plate(2.0 - 2e-6 * number as f32)));
    grids.check_against("plates", &shot(&mesh, view, &lights), &truth);
}

#[test]
fn a_million_points_in_one_light_cell() {
    let Some(mut grids) = grids() else { return };
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
    let shot = shot(&mesh, view(camera, 1024, 1024), &lights);
    let truth = truth_of_cpu(&shot);
    for lit in &truth.lit {
        let lit = lit.iter().filter(|&&lit| lit).count();
        assert!((100_000..1_040_000).contains(&lit), "{lit}");
    }
    grids.check_against("card", &shot, &truth);
}
