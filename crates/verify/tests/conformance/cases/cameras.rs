//! Cameras of every kind, images of every size, and worlds near and far, huge and tiny.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};
use umbrage_verify::lights::{around, point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, telescope, view};
use umbrage_verify::{Case, Random, TestMesh};

use super::{FAR, room};

fn look() -> Camera {
    Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9)
}

pub(super) fn of_all_kinds() -> Vec<Case> {
    let mut random = Random::new(3);
    let lights = [point(Vec3::new(0.3, 2.0, 0.1)), sun(0.3, -1.0, 0.2)];
    let mut cases = Vec::new();
    let mut ask = |name: &str, mesh: &TestMesh, view: View| cases.push(Case::new(name, mesh.clone(), view, &lights));
    for number in 0..6 {
        let mesh = TestMesh::soup(&mut random, 120, 0.3);
        let camera = Camera::look_at(random.point() * 0.5, random.point(), Vec3::Y, 0.5 + 0.5 * number as f32);
        ask("inside", &mesh, view(camera, 34, 21));
    }
    let mut mesh = TestMesh::plane(5, 2.0);
    mesh.append(&TestMesh::bumpy_ball(1.0, 8));
    for axis in [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z] {
        let camera = Camera::look_at(-axis * 4.0, Vec3::ZERO, Vec3::new(0.1, 1.0, 0.3), 0.8);
        ask("along an axis, with planes edge-on", &mesh, view(camera, 24, 20));
    }

    let mut mesh = TestMesh::soup(&mut random, 100, 0.1);
    mesh.append(&TestMesh::plane(4, 3.0));
    for half_height in [0.5, 2.0, 30.0] {
        for position in [Vec3::ZERO, random.point() * 0.2, random.point() * 3.0, look().position] {
            let camera = Camera { position, projection: Projection::Orthographic { half_height }, ..look() };
            ask("parallel", &mesh, view(camera, 19, 23));
        }
    }
    mesh.append(&TestMesh::bumpy_ball(1.0, 6));
    for far in [1e3, 1e7, 1e9] {
        let forward = random.point().normalize();
        let camera = Camera::look_at(Vec3::ZERO, forward, Vec3::Y, 1.0);
        let projection = Projection::Orthographic { half_height: 1.3 };
        ask("parallel from afar", &mesh, view(Camera { position: forward * -far, projection, ..camera }, 20, 17));
        ask("a telescope", &mesh, view(telescope(far), 20, 17));
    }

    let mesh = TestMesh::soup(&mut random, 20, 0.3);
    let mut odd = vec![look(); 2];
    odd[0].right *= 2.0;
    odd[1].right = odd[1].up;
    for tan_half_height in [0.0, f32::NAN, f32::INFINITY, -0.5, 1e-9, 1e9] {
        odd.push(Camera { projection: Projection::Perspective { tan_half_height }, ..look() });
    }
    odd.push(Camera { position: Vec3::new(f32::NAN, 1.0, 1.0), ..look() });
    odd.into_iter().for_each(|camera| ask("out of square", &mesh, view(camera, 16, 12)));
    let offset_pixels = DVec2::new(1e3, -1e12);
    cases.push(Case { offset_pixels, ..Case::new("beside all pixels", mesh, view(look(), 16, 12), &lights) });
    cases.extend(from_points_of_a_lens(&lights));
    cases
}

/// The camera moves across its axis, and its image the other way: by more, the nearer the focus is.
fn from_points_of_a_lens(lights: &[LightSource]) -> Vec<Case> {
    let mut mesh = room(7);
    mesh.append(&TestMesh::soup(&mut Random::new(5), 30, 0.1));
    let mut cases = Vec::new();
    for (focus, x, y) in [(4.0, 0.1, 0.2), (0.5, -0.3, 0.1), (0.05, 0.2, -0.2), (1e-3, 0.3, 0.3)] {
        let position = look().position + look().right * x + look().up * y;
        // Turned towards the focus, so that rays from far beside the image see triangles too.
        let target = position + look().forward + look().right * (x / focus) + look().up * (y / focus);
        for camera in [Camera { position, ..look() }, Camera::look_at(position, target, Vec3::Y, 0.9)] {
            let view = view(camera, 41, 26);
            let slope = DVec2::new(f64::from(-x), f64::from(y)) / f64::from(focus);
            let shift = slope * f64::from(view.height) / (2.0 * f64::from(0.45_f32.tan()));
            let case = Case::new("from a point of a lens", mesh.clone(), view, lights);
            cases.push(Case { offset_pixels: case.offset_pixels + (shift * 1024.0).round() / 1024.0, ..case });
        }
    }
    cases
}

/// From no tile to more tiles than are traced together.
pub(super) fn image_sizes() -> Vec<Case> {
    let mut random = Random::new(1);
    let mut cases = Vec::new();
    let lights = [point(Vec3::new(3.0, 5.0, 2.0)), point(Vec3::new(0.3, 0.2, 0.1)), sun(0.3, -1.0, 0.2)];
    let sizes = [(1, 1), (2, 1), (7, 3), (0, 5), (5, 0), (64, 64), (65, 30), (17, 40), (64, 3), (3, 64)];
    for (number, (width, height)) in sizes.into_iter().enumerate() {
        let soup = TestMesh::soup(&mut random, 60, [1.0, 0.1, 0.001][number % 3]);
        cases.push(Case::new("a soup", soup, view(look(), width, height), &lights[..2]));
        if width != 64 {
            cases.push(Case::new("a room", room(9), view(camera(), width, height), &lights));
        }
    }
    // More columns of tiles than are traced together; more rows than columns; one partial tile more in each.
    for (width, height) in [(1100, 5), (3, 400), (140, 70)] {
        let mut mesh = TestMesh::default();
        for step in 0..40 {
            // From needles to triangles that cover the whole view, around the camera and through the eye plane.
            let (length, width) = ([1.0, 2.0, 9.0][step % 3], [0.02, 0.5, 1.0, 40.0][step % 4]);
            let [middle, across, along] = [(); 3].map(|()| random.point());
            let corner = middle * 3.0;
            mesh.push([corner, corner + across * length, corner + across + along * width]);
        }
        let camera = Camera::look_at(random.point() * 0.2, random.point(), Vec3::Y, 1.2);
        cases.push(Case::new("many tiles", mesh, view(camera, width, height), &lights[2..]));
    }
    let mut ball = TestMesh::bumpy_ball(1.0, 20).placed(1.0, Vec3::Y);
    ball.append(&TestMesh::plane(8, 3.0));
    cases.push(Case::new("smaller triangles than pixels", ball, view(look(), 37, 25), &lights[..1]));
    cases
}

pub(super) fn worlds() -> Vec<Case> {
    let mut random = Random::new(4);
    let mut soup = TestMesh::soup(&mut random, 60, 0.05);
    soup.append(&TestMesh::bumpy_ball(1.0, 6));
    let mut cases = Vec::new();
    for (scale, offset) in [
        (1e-6, Vec3::ZERO),
        (1e-3, Vec3::splat(3e-3)),
        (1.0, FAR),
        (300.0, FAR),
        (1.0, Vec3::new(3e8, 0.0, 0.0)),
        (1e6, Vec3::ZERO),
        (1e-25, Vec3::ZERO),
        (1e25, Vec3::ZERO),
        (1e-36, Vec3::ZERO),
        (1e-43, Vec3::ZERO),
        (1e35, Vec3::ZERO),
        (1e38, Vec3::ZERO),
    ] {
        let lights = around(scale, offset);
        let name = format!("× {scale}, moved to {offset}");
        let seen = view(placed(look(), scale, offset), 24, 20);
        cases.push(Case::new(&*name, soup.clone().placed(scale, offset), seen, &lights[..2]));
        let parallel = view(placed(parallel_camera(), scale, offset), 17, 14);
        cases.push(Case::new(&*name, room(6).placed(scale, offset), parallel, &[lights[3], lights[7]]));
        if (1e-6..=1e6).contains(&scale) {
            let seen = view(placed(camera(), scale, offset), 25, 19);
            cases.push(Case::new(name, room(7).placed(scale, offset), seen, &lights));
        }
    }
    // A ball in a stadium, from all over it and from where the ball fills the view.
    for smallness in [1e-2, 1e-4, 1e-6] {
        let mesh = stadium(9, smallness);
        for away in [0.8, 3.0 * smallness] {
            let eye = BALL + Vec3::new(0.4, 0.5, 0.7) * away;
            let seen = view(Camera::look_at(eye, BALL, Vec3::Y, 0.8), 25, 20);
            let above = Vec3::new(-1.0, 2.0, 1.0) * smallness;
            let lights = [point(BALL + Vec3::new(0.2, 0.5, 0.3)), point(BALL + above), sun(0.3, -1.0, 0.2)];
            cases.push(Case::new(format!("a ball of {smallness}"), mesh.clone(), seen, &lights));
        }
    }
    cases
}

/// Position of the ball in [`stadium`].
pub(crate) const BALL: Vec3 = Vec3::new(0.3, -0.7, 0.2);

/// A bumpy ball with a radius of `smallness` on the floor of a room from -1 to 1.
pub(crate) fn stadium(rings: u32, smallness: f32) -> TestMesh {
    let mut mesh = TestMesh::bumpy_ball(smallness, rings).placed(1.0, BALL);
    mesh.append(&TestMesh::plane(4, 1.0).placed(1.0, Vec3::Y * (BALL.y - smallness)));
    mesh.append(&TestMesh::plane(1, 1.0).placed(1.0, Vec3::Y));
    mesh
}
