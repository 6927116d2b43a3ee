//! Triangles of bad shapes and in difficult places.

use glam::{EulerRot, Quat, Vec3};
use umbrage_rays::Camera;
use umbrage_verify::lights::{among_bad_shapes, point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, view};
use umbrage_verify::{Random, TestMesh, meshes_in_bad_places};

use super::grids::{WORLDS, case, grids};

/// A camera at the origin that looks along −z.
fn eye() -> Camera {
    Camera { position: Vec3::ZERO, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, ..camera() }
}

#[test]
fn few_triangles() {
    let Some(mut grids) = grids() else { return };
    let at = Vec3::new;
    for (name, mesh) in meshes_in_bad_places() {
        let lights = [point(at(0.5, 2.0, -1.0)), point(Vec3::ZERO), sun(0.2, -1.0, -0.3)];
        for (width, height) in [(1, 1), (1, 23), (23, 1), (17, 16), (65, 33)] {
            let parallel = Camera { projection: parallel_camera().projection, ..eye() };
            for camera in [Some(eye()), (width > 16).then_some(parallel)].into_iter().flatten() {
                let name = format!("{name} in {width}×{height}, {:?}", camera.projection);
                grids.check(&name, &case(&mesh, view(camera, width, height), &lights));
            }
        }
    }
}

/// Long carpets that begin behind the camera, at smaller and smaller heights above their floor, level and aslant.
#[test]
fn carpets_on_floors() {
    let Some(mut grids) = grids() else { return };
    let sheet = |mesh: &mut TestMesh, tilt: Quat, [x, z]: [f32; 2], height: f32| {
        let at = |x: f32, z: f32| tilt * Vec3::new(x, height - 1.72, z);
        let [a, b, c, d] = [at(-x, 5.0), at(x, 5.0), at(x, -z), at(-x, -z)];
        mesh.push([a, b, c]);
        mesh.push([a, c, d]);
    };
    for tilt in [Quat::IDENTITY, Quat::from_euler(EulerRot::XYZ, 0.013, 0.4, -0.02)] {
        for gap in [6e-3, 3e-5, 3e-6, 3e-7, 0.0] {
            let mut mesh = TestMesh::default();
            sheet(&mut mesh, tilt, [9.0, 31.0], 0.0);
            sheet(&mut mesh, tilt, [1.0, 23.0], gap);
            let lights = [point(Vec3::new(0.5, 3.0, -6.0)), sun(0.2, -1.0, -0.3)];
            grids.check(&format!("a gap of {gap}, {tilt}"), &case(&mesh, view(eye(), 97, 71), &lights));
        }
    }
}

#[test]
fn what_is_no_triangle_is_never_there() {
    let Some(mut grids) = grids() else { return };
    let room = TestMesh::room();
    let mut mesh = room.clone();
    let good = room.positions.len() as u32;
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -f32::NAN];
    mesh.positions
        .extend(bad.iter().flat_map(|&value| [Vec3::splat(value), Vec3::Y.with_x(value), Vec3::Y.with_z(value)]));
    for vertex in good..mesh.positions.len() as u32 {
        mesh.indices.extend([[vertex, 0, 80], [0, vertex, 80], [0, 80, vertex], [vertex, vertex, vertex]]);
    }
    let count = mesh.positions.len() as u32;
    for vertex in [count, count + 1, 1 << 20, u32::MAX, u32::MAX / 3 + 1] {
        mesh.indices.extend([[vertex, 0, 80], [0, vertex, 80], [0, 80, vertex], [vertex, vertex, vertex]]);
    }
    // Only the room's triangles have valid corners, so the room is the truth.
    let lights = [point(Vec3::new(2.0, 3.0, 1.0)), sun(0.3, -1.0, 0.2), point(mesh.positions[3])];
    for camera in [camera(), parallel_camera()] {
        let view = view(camera, 41, 29);
        let truth = case(&room, view, &lights).truth();
        grids.check_against("bad vertices", &case(&mesh, view, &lights), &truth);
        // Depths without a finite inverse: each point is compared with all triangles.
        let (scale, offset) = (1e32, Vec3::ZERO);
        let view = umbrage_rays::View { camera: placed(camera, scale, offset), width: 11, height: 9 };
        let [huge, room] = [mesh.clone(), room.clone()].map(|mesh| mesh.placed(scale, offset));
        let lights = [point(Vec3::new(1.0, 3.0, 1.0) * scale), sun(0.2, -1.0, 0.1)];
        let truth = case(&room, view, &lights).truth();
        grids.check_against("bad vertices of a huge world", &case(&huge, view, &lights), &truth);
    }
    // Nor without any vertex.
    let indices = [[0, 1, 2], [5, 5, 5]];
    let none = case(&TestMesh { positions: Vec::new(), indices: indices.to_vec() }, view(camera(), 5, 5), &lights);
    let truth = case(&TestMesh::default(), view(camera(), 5, 5), &lights).truth();
    grids.check_against("no vertices", &none, &truth);
}

#[test]
fn slivers_points_and_giants() {
    let Some(mut grids) = grids() else { return };
    let room = TestMesh::bad_shapes(&mut Random::new(51));
    for (scale, offset) in WORLDS {
        let mesh = room.clone().placed(scale, offset);
        let lights = among_bad_shapes(scale, offset);
        for camera in [camera(), parallel_camera()] {
            let view = view(placed(camera, scale, offset), 33, 25);
            grids.check(&format!("scale {scale} at {offset}, {:?}", camera.projection), &case(&mesh, view, &lights));
        }
    }
}

#[test]
fn coordinates_of_any_size() {
    let Some(mut grids) = grids() else { return };
    let mut random = Random::new(52);
    for range in [4, 24, 60, 120] {
        let mut mesh = TestMesh::default();
        let mut any = || {
            let exponent = random.below(2 * range + 1) as i32 - range as i32;
            random.point() * 2.0_f32.powi(exponent)
        };
        (0..300).for_each(|_| mesh.push([any(), any(), any()]));
        let lights = [point(any()), point(any()), sun(0.1, -0.7, 0.3)];
        for camera in [camera(), parallel_camera(), eye()] {
            let name = format!("up to 2^{range}, {:?}", camera.projection);
            grids.check(&name, &case(&mesh, view(camera, 21, 17), &lights));
        }
    }
}
