//! Lights in every bad place.

use glam::Vec3;
use umbrage_rays::{Camera, Projection};
use umbrage_verify::TestMesh;

use crate::grids::{WORLDS, camera, grids, parallel_camera, placed, point, shot, sun, view};

#[test]
fn lights_on_behind_and_grazing_surfaces() {
    let Some(mut grids) = grids() else { return };
    let room = TestMesh::room();
    for (world, (scale, offset)) in WORLDS.into_iter().enumerate() {
        let mesh = room.clone().placed(scale, offset);
        let mut lights = Vec::new();
        // At vertices, in edges and inside triangles of the floor, the ball and the wall; and just beside.
        for id in [0, 37, 130, 300, mesh.indices.len() as u32 - 1] {
            let [a, b, c] = mesh.triangles().corners(id);
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
            grids.check(&format!("scale {scale} at {offset}, {:?}", camera.projection), &shot(&mesh, view, &half));
        }
    }
}

#[test]
fn a_telescope_far_away() {
    // Its points are about as wrong as they are far from their light.
    let Some(mut grids) = grids() else { return };
    let forward = Vec3::new(-0.25, -0.5, -1.0).normalize();
    for far in [2e6_f32, 2e9, 2e12] {
        let right = forward.cross(Vec3::Y).normalize();
        let projection = Projection::Perspective { tan_half_height: 1.5 / far };
        let telescope = Camera { position: -forward * far, right, up: right.cross(forward), forward, projection };
        let lights = [point(Vec3::new(0.5, -0.9999, 0.5)), point(Vec3::new(0.3, 0.4, 0.2)), sun(0.3, -1.0, 0.1)];
        let mesh = TestMesh::room();
        grids.check(&format!("from {far}"), &shot(&mesh, view(telescope, 23, 17), &lights));
    }
}

#[test]
fn many_lights_and_none() {
    let Some(mut grids) = grids() else { return };
    let mesh = TestMesh::room();
    let all: Vec<_> = (0..40).map(|number| (number as f32 * 0.7).sin_cos()).collect();
    let lights: Vec<_> = all.iter().map(|(x, z)| point(Vec3::new(2.0 * x, 1.5, 2.0 * z))).collect();
    for count in [0, 1, 40] {
        grids.check(&format!("{count} lights"), &shot(&mesh, view(camera(), 30, 20), &lights[..count]));
    }
}
