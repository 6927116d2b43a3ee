//! A golden cup with a knot on its lid: many triangles in a small volume.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::build::math::{around, cos, sin_cos, smoothstep, wave};
use super::build::{Join, MeshBuilder, Sheet};

/// Height of the cup with its knot, in metres.
pub(super) const HEIGHT: f32 = 0.74;

/// The cup's outline, (distance from the axis, height), from the foot to the middle of the lid.
const OUTLINE: [(f32, f32); 24] = [
    (0.0, 0.0),
    (0.118, 0.0),
    (0.124, 0.012),
    (0.112, 0.03),
    (0.074, 0.048),
    (0.036, 0.078),
    (0.022, 0.115),
    (0.02, 0.145),
    (0.042, 0.162),
    (0.042, 0.182),
    (0.02, 0.196),
    (0.03, 0.214),
    (0.085, 0.24),
    (0.128, 0.285),
    (0.142, 0.335),
    (0.138, 0.385),
    (0.134, 0.43),
    (0.142, 0.458),
    (0.152, 0.468),
    (0.148, 0.484),
    (0.13, 0.494),
    (0.095, 0.53),
    (0.04, 0.562),
    (0.0, 0.568),
];

/// Adds the cup, standing on the origin, in about `triangles` triangles of one material.
pub(super) fn cup(builder: &mut MeshBuilder, triangles: usize) {
    let part = |share: f32| (triangles as f32 * share) as usize;
    let body = Sheet { across: Join::Joined, ..Sheet::of_triangles(part(0.5), 1.0) };
    builder.sheet(body, body_point);
    for side in [-1.0, 1.0] {
        let handle = Sheet { across: Join::Joined, ..Sheet::of_triangles(part(0.08), 0.35) };
        builder.sheet(handle, |u, v| handle_point(side, u, v));
    }
    let left = triangles.saturating_sub(part(0.5) + 2 * part(0.08));
    let knot = Sheet::of_triangles(left, 0.12);
    builder.sheet(Sheet::ring(knot.columns, knot.rows.max(6)), knot_point);
}

/// A point of the lathed body: flutes around the bowl and the lid, beads on the rim and a garland in relief.
fn body_point(u: f32, v: f32) -> Vec3 {
    let point = outline(v);
    let (radius, height) = (point.x, point.y);
    let within = |low: f32, high: f32| {
        let edge = 0.25 * (high - low);
        smoothstep(low, low + edge, height) * smoothstep(high, high - edge, height)
    };
    let ridge = |count: f32| wave(count * u).abs();
    let lobes = 0.007 * within(0.222, 0.335) * ridge(12.0);
    let lid = 0.004 * within(0.496, 0.562) * ridge(12.0);
    let foot = 0.005 * within(0.014, 0.075) * ridge(10.0);
    let knop = 0.003 * within(0.158, 0.188) * ridge(9.0);
    let bead = 0.0022 * within(0.464, 0.486) * ridge(36.0);
    let garland = {
        let vine = 0.393 + 0.013 * wave(9.0 * u);
        let stem = smoothstep(0.004, 0.0015, (height - vine).abs());
        let (leaf_u, leaf_v) = (wave(27.0 * u + 0.1 * wave(9.0 * u)), (height - vine) / 0.012);
        let leaf = smoothstep(0.35, 0.0, leaf_v * leaf_v * 0.4 + (1.0 - leaf_u.abs()) - 0.3);
        0.0026 * within(0.356, 0.43) * stem.max(leaf * smoothstep(2.2, 1.2, leaf_v.abs()))
    };
    let out = radius + (lobes + lid + foot + knop + bead + garland) * smoothstep(0.0, 0.02, radius);
    around(u, out, height)
}

/// The outline at `along`, 0 … 1: a smooth curve that is cut more finely than its corners.
fn outline(along: f32) -> Vec2 {
    let spans = (OUTLINE.len() - 1) as f32;
    let span = ((along * spans) as usize).min(OUTLINE.len() - 2);
    let point = |index: usize| Vec2::from(OUTLINE[index.min(OUTLINE.len() - 1)]);
    let (weights, _) = super::sweep::catmull_rom(along * spans - span as f32);
    let four = [point(span.saturating_sub(1)), point(span), point(span + 1), point(span + 2)];
    let at: Vec2 = four.iter().zip(weights).map(|(point, weight)| *point * weight).sum();
    // At the ends the surface meets the axis exactly.
    if along <= 0.0 || along >= 1.0 { at.with_x(0.0) } else { at.max(Vec2::new(0.0, f32::MIN)) }
}

/// A handle: an ear that springs from the bowl's belly and curls onto the rim.
fn handle_point(side: f32, u: f32, v: f32) -> Vec3 {
    let turn = -0.32 + 1.02 * v;
    let (sin, cosine) = sin_cos(TAU * 0.5 * turn);
    let center = Vec2::new(0.118 + 0.105 * cosine * (1.0 - 0.2 * v), 0.37 + 0.092 * sin + 0.02 * v);
    let out = Vec2::new(cosine, sin);
    let radius = 0.0105 + 0.004 * cos(TAU * v) + 0.003 * wave(3.0 * v).abs();
    let (sin_u, cos_u) = sin_cos(TAU * u);
    let twisted = radius * (1.0 + 0.12 * wave(6.0 * u + 8.0 * v));
    let flat = center + out * (cos_u * twisted);
    Vec3::new(side * flat.x, flat.y, -side * sin_u * twisted * 1.15)
}

/// The trefoil knot on the lid, twisted like rope.
fn knot_point(u: f32, v: f32) -> Vec3 {
    let at = |v: f32| {
        let (sin_2, cos_2) = sin_cos(2.0 * TAU * v);
        let (sin_3, cos_3) = sin_cos(3.0 * TAU * v);
        let across = 2.0 + cos_3;
        Vec3::new(across * cos_2, across * sin_2, sin_3 * 0.9) * 0.0245
    };
    let center = at(v);
    let tangent = (at(v + 1e-3) - at(v - 1e-3)).normalize();
    let side = (center - tangent * tangent.dot(center)).normalize_or(tangent.any_orthonormal_vector());
    let other = tangent.cross(side);
    let radius = 0.0125 * (1.0 + 0.16 * wave(4.0 * u + 24.0 * v).abs());
    let (sin, cos) = sin_cos(TAU * u);
    Vec3::Y * (HEIGHT - 0.09) + center + (side * cos + other * sin) * radius
}
