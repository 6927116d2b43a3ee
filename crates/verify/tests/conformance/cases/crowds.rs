//! Many triangles in one place. `frames` has larger crowds, for structures that must be fast there.

use glam::Vec3;
use umbrage_rays::{Camera, SeenPixels};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, parallel_camera, view};
use umbrage_verify::{Case, Plates, Random, TestMesh, Truth};

use crate::check::{Known, known};

pub(super) fn all() -> Vec<Known> {
    let [a, b, _] = TestMesh::COPY;
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), sun(0.3, -1.0, 0.2)];
    let mut all = vec![
        copies(Case::new("copies", TestMesh::copies(10_000), view(camera(), 21, 16), &lights)),
        copies(Case::new("copies", TestMesh::copies(3_000), view(parallel_camera(), 9, 7), &lights)),
        // A light on their edge leaves all of them to exact arithmetic.
        copies(Case::new("copies", TestMesh::copies(1_000), view(camera(), 6, 4), &[point(a.midpoint(b))])),
        plates(10_000, 1e-4),
    ];
    all.extend(known(vec![in_one_plane(), card()]));
    all.push(in_one_pixel());
    all
}

/// A [room](TestMesh::copies) whose first copy hides all others: each copy has the same shadow.
fn copies(case: Case) -> Known {
    // Two copies, because a single one wouldn't shadow its own points.
    let truth = Case::new("two copies", TestMesh::copies(2), case.view, &case.lights).truth();
    Known::with_truth(case, truth)
}

/// Plates above one pixel of a floor, within one of 192² cells of the lights' views of it.
fn plates(count: u32, step: f32) -> Known {
    let mut plates = Plates::one();
    let truth = plates.truth();
    plates.pile(count, step);
    Known::with_truth(plates.case(), truth)
}

/// No filter can tell the nearest: every pixel leaves many hits to exact arithmetic.
fn in_one_plane() -> Case {
    let mut random = Random::new(54);
    let mut mesh = TestMesh::default();
    for _ in 0..150 {
        mesh.push([(); 3].map(|()| random.point() * 2.0).map(|corner| corner.with_y(corner.x * 0.5)));
    }
    let camera = Camera::look_at(Vec3::new(-1.0, 3.0, 0.2), Vec3::ZERO, Vec3::Z, 0.8);
    let lights = [point(Vec3::new(-1.0, 2.0, 0.0)), point(Vec3::new(0.5, 0.25, 0.0))];
    Case::new("one plane", mesh, view(camera, 24, 18), &lights)
}

/// A card a thousandth the size of the scene fills nearly all of the image; a ball half shadows it.
fn card() -> Case {
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2e-3), Vec3::ZERO, Vec3::Y, 0.9);
    let lights = [point(Vec3::new(0.3, 2.0, 3.0)), point(Vec3::new(4.0, 1.0, 8.0)), sun(0.0, -0.3, -1.0)];
    Case::new("card", TestMesh::card(), view(camera, 40, 40), &lights)
}

/// The same triangle again and again, seen alone.
fn in_one_pixel() -> Known {
    let mut mesh = TestMesh::default();
    mesh.push([Vec3::new(-1.0, -1.0, 0.1), Vec3::new(1.0, -1.0, -0.2), Vec3::new(0.0, 1.0, 0.3)]);
    let view = view(camera(), 12, 9);
    let lights = [point(Vec3::new(0.0, 1.0, 2.0))];
    let truth = Case::new("one", mesh.clone(), view, &lights).truth();
    assert!(truth.triangle.iter().all(|&id| id == 0 || id == SeenPixels::NONE) && truth != Truth::default());
    mesh.indices = vec![[0, 1, 2]; 10_000];
    Known::with_truth(Case::new("one again and again", mesh, view, &lights), truth)
}
