//! A photographer's studio: the seamless backdrop, lamps and camera that several demos share.

use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::Range;

use glam::{Quat, Vec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection};

use super::build::MeshBuilder;
use super::build::math::sin_cos;
use umbrage_scene::{Frame, Light, NamedCamera};

/// Columns of a backdrop that is a fair share of `triangles`; zero, for a flat one, where there are few.
pub(crate) fn backdrop_columns(triangles: usize) -> u32 {
    const FEW: usize = 2_000;
    if triangles < FEW {
        return 0;
    }
    ((triangles as f32 * 0.02 / (2 * BEND_ROWS + 3) as f32) as u32).clamp(12, 96)
}

/// Triangles of a backdrop of `columns`.
pub(crate) fn backdrop_triangles(columns: u32) -> usize {
    if columns == 0 { 2 } else { (columns * (2 * BEND_ROWS + 3)) as usize }
}

const BEND_ROWS: u32 = 6;

/// Adds a round floor at y = 0 of `radius` that bends up, without an edge, to a wall of `height`; without columns a
/// square floor alone. Texture coordinates are lengths along the floor, in world units.
pub(crate) fn backdrop(builder: &mut MeshBuilder, radius: f32, height: f32, columns: u32) {
    if columns == 0 {
        builder.floor(Vec3::ZERO, Vec2::splat(2.0 * radius), [1, 1]);
        return;
    }
    let bend = 0.45 * radius.min(height);
    // From the top down, so that the inside is the outer side.
    let mut profile = vec![Vec2::new(radius, height)];
    profile.extend((0..=BEND_ROWS).map(|row| {
        let (sin, cos) = sin_cos(row as f32 / BEND_ROWS as f32 * FRAC_PI_2);
        Vec2::new(radius - bend + bend * cos, bend - bend * sin)
    }));
    profile.push(Vec2::ZERO);
    let first = builder.positions.len();
    builder.lathe(&profile, columns);
    builder.wrap(first, |position| Vec2::new(position.x, position.y + position.z));
}

/// Adds a lamp to the frame that makes a white surface facing it at `subject` `brightness` bright.
pub(crate) fn light(frame: &mut Frame, name: &str, position: Vec3, subject: Vec3, color: Vec3, brightness: f32) {
    lamp(frame, name, position, color, brightness * PI * position.distance_squared(subject), None);
}

/// Adds a lamp of `candela` to the frame; it has faded to zero at `range`.
pub(crate) fn lamp(frame: &mut Frame, name: &str, position: Vec3, color: Vec3, candela: f32, range: Option<f32>) {
    let source = LightSource::Point { position };
    frame.lights.push(Light { name: name.into(), color, range, ..Light::new(source, candela) });
}

/// Adds a sun to the frame that shines along `way`; it makes a white surface that faces it `brightness` bright.
pub(crate) fn sun(frame: &mut Frame, way: Vec3, color: Vec3, brightness: f32) {
    let source = LightSource::Directional { direction: way.normalize() };
    let intensity = brightness * PI;
    frame.lights.push(Light { name: "sun".into(), color, ..Light::new(source, intensity) });
}

/// Adds a perspective camera to the frame, at `position` and looking at `target`, +Y upwards.
///
/// `tan_half_height` is the tangent of half the vertical field of view. `target` must not be straight above or below.
pub(crate) fn look(frame: &mut Frame, name: &str, position: Vec3, target: Vec3, tan_half_height: f32) {
    // Not `Camera::look_at`, whose tangent may differ in its last bit from machine to machine.
    let forward = (target - position).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let camera = Camera { position, right, up, forward, projection: Projection::Perspective { tan_half_height } };
    frame.cameras.push(NamedCamera { name: name.into(), camera });
}

/// Moves vertices that are around the origin to `hook`, turned.
pub(crate) fn turn(frame: &mut Frame, vertices: Range<usize>, hook: Vec3, turn: Quat) {
    for position in &mut frame.positions[vertices.clone()] {
        *position = hook + turn * *position;
    }
    for normal in &mut frame.normals[vertices] {
        *normal = turn * *normal;
    }
}
