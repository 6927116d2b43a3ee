//! Triangles in difficult places for lights that see by two angles: around their axes, through the seam behind them and
//! through the planes of right angles. All other tests of this folder have such lights as well.

use glam::Vec3;
use umbrage_gpu::LightOptions;
use umbrage_rays::{Camera, LightSource};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, placed, view};
use umbrage_verify::{Random, TestMesh};

use super::grids::{SPHERICAL, WORLDS, case, grids, truth_of_cpu};

/// Rectangles of angles: narrow, all around, and behind the light.
const CLAMPS: [[f32; 4]; 4] = [
    [-40.0, 20.0, 5.0, 170.0],
    [-180.0, 180.0, -180.0, 180.0],
    [100.0, 180.0, -180.0, -100.0],
    [-0.1, 0.1, -90.0, 90.0],
];

fn clamped(degrees: [f32; 4]) -> LightOptions {
    LightOptions { clamp: Some(degrees), slices: 2, ..SPHERICAL }
}

/// A ball around the origin, seen from inside, and a floor with a light between them and the origin in its middle.
fn inside_of_a_ball() -> (TestMesh, Camera) {
    let mut mesh = TestMesh::ball(3).placed(4.0, Vec3::ZERO);
    mesh.append(&TestMesh::floor(6));
    (mesh, Camera::look_at(Vec3::new(0.1, 0.7, 3.4), Vec3::ZERO, Vec3::Y, 1.2))
}

/// A spot that shines along an axis of its own, nearly everywhere.
fn wide(position: Vec3, direction: Vec3) -> LightSource {
    LightSource::Spot { position, direction, inner_radians: 1.0, outer_radians: 1.57 }
}

#[test]
fn triangles_around_the_axes_of_a_light() {
    let Some(mut grids) = grids() else { return };
    let (ball, look) = inside_of_a_ball();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let (across, beside) = (axis.any_orthonormal_vector(), axis.cross(axis.any_orthonormal_vector()));
        let mut mesh = ball.clone();
        for side in [-0.7, 0.7] {
            // One that the axis passes through, one with an edge on it, and one with a corner there.
            let at = |along: f32, x: f32, y: f32| axis * along + across * x + beside * y;
            mesh.push([at(side, 0.3, 0.1), at(side * 1.2, -0.2, 0.3), at(side, -0.1, -0.4)]);
            mesh.push([at(side * 1.5, 0.2, 0.0), at(side * 1.5, -0.2, 0.0), at(side * 1.5, 0.0, 0.4)]);
            mesh.push([at(side * 1.8, 0.0, 0.0), at(side * 1.8, 0.3, 0.1), at(side * 1.8, 0.1, 0.3)]);
            // In a plane through the light, and in one just beside it.
            mesh.push([at(0.3, side, 0.0), at(-0.3, side, 0.0), at(0.1, 1.3 * side, 0.0)]);
            mesh.push([at(0.3, side, 1e-7), at(-0.3, side, -1e-7), at(0.1, 1.3 * side, 1e-7)]);
        }
        let lights = [
            point(Vec3::ZERO),
            point(Vec3::new(1e-8, -1e-8, 1e-8)),
            wide(Vec3::ZERO, axis),
            wide(Vec3::ZERO, -axis),
            wide(Vec3::ZERO, axis + 0.01 * across),
        ];
        let case = case(&mesh, view(look, 50, 40), &lights);
        let truth = case.truth();
        grids.check_against(&format!("around {axis}"), &case, &truth);
        assert!(grids.work().iter().all(|work| work.faces == 1), "{:?}", grids.work());
        // All rectangles of angles around one axis, and around the others the full rectangle.
        for clamp in if axis == Vec3::X { &CLAMPS[..] } else { &CLAMPS[1..2] } {
            grids.check_lights(&format!("around {axis}"), &case, &truth, clamped(*clamp));
        }
    }
}

#[test]
fn thin_triangles_through_the_seam_and_through_right_angles() {
    let Some(mut grids) = grids() else { return };
    let (mut mesh, _) = inside_of_a_ball();
    let mut random = Random::new(71);
    // Some of them cross each direction from the middle, for any axes of the light.
    for _ in 0..400 {
        let (middle, aside) = (random.point().normalize_or_zero() * 1.5, random.point() * 0.6);
        let thickness = random.point() * 0.02;
        mesh.push([middle + aside, middle - aside, middle + thickness]);
    }
    let lights = [point(Vec3::ZERO), point(Vec3::new(0.2, 0.1, -0.3)), wide(Vec3::new(0.0, 0.3, 0.0), Vec3::NEG_Z)];
    let looks = [Vec3::new(0.1, 0.7, 3.4), Vec3::new(-3.3, 0.2, 0.4), Vec3::new(0.1, 3.5, -0.2)];
    for position in looks {
        let look = Camera::look_at(position, Vec3::new(0.1, 0.0, 0.05), Vec3::new(0.1, 0.6, 0.8), 1.2);
        for clamp in [None, Some(CLAMPS[0]), Some(CLAMPS[2])] {
            let case = case(&mesh, view(look, 60, 50), &lights);
            let truth = truth_of_cpu(&case);
            grids.check_lights("strips", &case, &truth, LightOptions { clamp, ..SPHERICAL });
        }
    }
}
#[test]
fn lights_anywhere_in_a_soup() {
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(72);
    for (scale, offset) in WORLDS {
        let mut mesh = TestMesh::soup(&mut random, 150, 0.02);
        mesh.append(&TestMesh::floor(4));
        let mut lights: Vec<_> = (0..4).map(|_| point(random.point() * 2.0 * scale + offset)).collect();
        let mesh = mesh.placed(scale, offset);
        // In a corner, in an edge, and on a triangle.
        let [a, b, c] = mesh.triangles().corners(7);
        lights.extend([a, a.midpoint(b), a + ((b - a) + (c - a)) * 0.25].map(point));
        lights.push(sun(0.2, -1.0, 0.3));
        let case = case(&mesh, view(placed(camera(), scale, offset), 40, 30), &lights);
        let truth = truth_of_cpu(&case);
        let name = format!("soup at scale {scale} and {offset}");
        for options in [SPHERICAL, clamped(CLAMPS[0]), clamped(CLAMPS[2])] {
            grids.check_lights(&name, &case, &truth, options);
        }
    }
}

#[test]
fn lights_on_slanted_triangles() {
    let Some(mut grids) = grids() else { return };
    let (mut mesh, look) = inside_of_a_ball();
    let mut random = Random::new(73);
    let mut lights = Vec::new();
    for _ in 0..24 {
        let [a, b, c] = [(); 3].map(|()| random.point() * 1.5);
        mesh.push([a, b, c]);
        // After rounding it is on either side of the plane, nearer than f32 can tell.
        lights.push(point(a + ((b - a) + (c - a)) * 0.3));
    }
    let case = case(&mesh, view(look, 30, 24), &lights);
    let truth = truth_of_cpu(&case);
    grids.check_lights("on slanted triangles", &case, &truth, SPHERICAL);
}

#[test]
fn one_grid_where_faces_need_six() {
    let Some(mut grids) = grids() else { return };
    let (mesh, look) = inside_of_a_ball();
    let case = case(&mesh, view(look, 120, 90), &[point(Vec3::new(0.1, 0.2, 0.1)), sun(0.1, -1.0, 0.2)]);
    let truth = truth_of_cpu(&case);
    for (options, expected) in [(LightOptions::default(), [6, 1]), (SPHERICAL, [1, 1])] {
        grids.check_lights("in the middle", &case, &truth, options);
        println!("{options:?}: {:?}", grids.work());
        let faces: Vec<_> = grids.work().iter().map(|work| work.faces).collect();
        assert_eq!(faces, expected);
        // Few pairs are left to the predicate: a filter that leaves all of them would give the same answers.
        assert!(grids.work().iter().all(|work| work.undecided < 200), "{:?}", grids.work());
    }
}

/// Prints the work of lights in the middle, through faces and by angles.
#[test]
fn a_hall_with_lights_in_it() {
    let Some(mut grids) = grids() else { return };
    let scene = umbrage::open("demo:hall?triangles=100000").expect("a scene of the gallery");
    let frame = scene.at(0.0).expect("a frame");
    let mesh = TestMesh { positions: frame.positions.clone(), indices: frame.triangles().indices.to_vec() };
    let low = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let lights = [0.5, 0.3].map(|part| point(low.lerp(high, part)));
    let case = case(&mesh, view(frame.camera(1.0), 256, 256), &lights);
    let truth = truth_of_cpu(&case);
    for options in [LightOptions::default(), SPHERICAL] {
        grids.check_lights("hall", &case, &truth, options);
        println!("{options:?}: {:?}", grids.work());
    }
}
