//! Lights for the test meshes.

use glam::Vec3;
use umbrage_rays::LightSource;

use crate::{TestMesh, views};

/// A light at a point.
#[must_use]
pub fn point(position: Vec3) -> LightSource {
    LightSource::Point { position }
}

/// Parallel light along a direction of any length.
#[must_use]
pub fn sun(x: f32, y: f32, z: f32) -> LightSource {
    LightSource::Directional { direction: Vec3::new(x, y, z).normalize() }
}

/// Lights at difficult positions of a scaled and moved [room](TestMesh::room): on the triangles `ids` and the last one,
/// behind surfaces, and along them.
#[must_use]
pub fn in_bad_places(ids: &[u32], scale: f32, offset: Vec3) -> Vec<LightSource> {
    let mesh = TestMesh::room().placed(scale, offset);
    let mut lights = Vec::new();
    // At vertices, on edges and inside triangles of the floor, the ball and the wall; and just beside.
    for &id in ids.iter().chain(&[mesh.indices.len() as u32 - 1]) {
        let [a, b, c] = mesh.triangles().corners(id);
        let inside = a + ((b - a) + (c - a)) * 0.25;
        lights.extend([a, a.midpoint(b), inside].map(point));
        lights.extend([inside.with_y(inside.y.next_up()), inside.with_y(inside.y.next_down())].map(point));
    }
    let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
    // In the floor's plane far away, barely above and below it, and behind the floor, the wall and the camera.
    lights.extend([at(40.0, -1.0, 3.0), at(40.0, -0.999_99, 3.0), at(3.0, -1.000_01, 0.0)]);
    lights.extend([at(0.5, -3.0, 0.0), at(0.0, 0.0, -1.5), at(0.3, 0.4, -9.0), at(1.0, 3.0, 30.0)]);
    lights.push(point(views::camera().position * scale + offset));
    // Along the floor, along the wall, and from behind both.
    lights.extend([sun(1.0, 0.0, 0.0), sun(1.0, -1e-6, 0.0), sun(1.0, 1e-6, 0.1), sun(0.0, -1.0, 0.0)]);
    lights.extend([sun(0.0, 1.0, 0.0), sun(0.1, -0.2, 1.0)]);
    lights
}

/// Lights around, inside and below the scaled and moved [room among bad shapes](TestMesh::bad_shapes).
#[must_use]
pub fn among_bad_shapes(scale: f32, offset: Vec3) -> [LightSource; 5] {
    let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
    [at(2.0, 3.0, 1.0), at(0.1, 0.5, 0.2), at(-0.5, -0.9, 0.75), at(1.0, 1.5, 4.0), sun(0.3, -1.0, 0.2)]
}

/// Lights in front of, above, inside, on and behind all triangles of a scaled and moved world, near and far.
#[must_use]
pub fn around(scale: f32, offset: Vec3) -> [LightSource; 10] {
    let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
    let spot = LightSource::Spot {
        position: Vec3::new(2.0, 3.0, 1.0) * scale + offset,
        direction: Vec3::new(-2.0, -3.0, -1.0).normalize(),
        inner_radians: 0.2,
        outer_radians: 0.4,
    };
    [
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
