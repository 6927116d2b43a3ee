//! Many triangles in one place.

use glam::Vec3;
use umbrage_rays::Camera;
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, parallel_camera, view};
use umbrage_verify::{Plates, Random, TestMesh};

use super::grids::{case, grids, truth_of_cpu};

#[test]
fn ten_thousand_identical_triangles() {
    let Some(mut grids) = grids() else { return };
    let mesh = TestMesh::copies(10_000);
    let [a, b, _] = TestMesh::COPY;
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), sun(0.3, -1.0, 0.2)];
    grids.check("copies", &case(&mesh, view(camera(), 21, 16), &lights));
    grids.check("copies", &case(&mesh, view(parallel_camera(), 9, 7), &lights));
    // A light on their edge leaves all of them to exact arithmetic.
    grids.check("copies", &case(&mesh, view(camera(), 6, 4), &[point(a.midpoint(b))]));
}

#[test]
fn a_crowd_in_one_plane() {
    // No filter can tell the nearest: every pixel leaves hundreds of hits to exact arithmetic.
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(54);
    let mut mesh = TestMesh::default();
    for _ in 0..500 {
        let corners = [(); 3].map(|()| random.point() * 2.0).map(|corner| corner.with_y(corner.x * 0.5));
        mesh.push(corners);
    }
    let camera = Camera::look_at(Vec3::new(-1.0, 3.0, 0.2), Vec3::ZERO, Vec3::Z, 0.8);
    let lights = [point(Vec3::new(-1.0, 2.0, 0.0)), point(Vec3::new(0.5, 0.25, 0.0))];
    grids.check("one plane", &case(&mesh, view(camera, 40, 30), &lights));
}

#[test]
fn hundreds_of_thousands_of_triangles_in_one_tile() {
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(55);
    let mut mesh = TestMesh::floor(8);
    // All of them are within four pixels on each axis; some are far larger than their pixels.
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    for number in 0..200_000 {
        let size = if number % 64 == 0 { 0.04 } else { 0.003 };
        let middle = random.point() * Vec3::new(0.06, 0.06, 1.0);
        mesh.push([(); 3].map(|()| middle + random.point() * size));
    }
    let lights = [point(Vec3::new(0.5, 2.0, 1.0)), sun(0.0, -1.0, 0.0)];
    grids.check("one tile", &case(&mesh, view(camera, 100, 80), &lights));
}

#[test]
fn hundreds_of_thousands_of_triangles_in_one_light_cell() {
    let Some(mut grids) = grids() else { return };
    let mut plates = Plates::one();
    let truth = plates.truth();
    plates.pile(400_000, 2e-6);
    grids.check_against("plates", &plates.case(), &truth);
}

#[test]
fn a_million_points_in_one_light_cell() {
    let Some(mut grids) = grids() else { return };
    // A card a thousandth the size of the scene fills nearly all of the image; a ball half shadows it.
    let mesh = TestMesh::card();
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2e-3), Vec3::ZERO, Vec3::Y, 0.9);
    let lights = [point(Vec3::new(0.3, 2.0, 3.0)), point(Vec3::new(4.0, 1.0, 8.0)), sun(0.0, -0.3, -1.0)];
    grids.check("small card", &case(&mesh, view(camera, 100, 100), &lights));
    let case = case(&mesh, view(camera, 1024, 1024), &lights[..1]);
    let truth = truth_of_cpu(&case);
    for lit in &truth.lit {
        let lit = lit.iter().filter(|&&lit| lit).count();
        assert!((100_000..1_040_000).contains(&lit), "{lit}");
    }
    grids.check_against("card", &case, &truth);
}
