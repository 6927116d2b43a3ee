//! Triangles with edges, planes and corners on shadow rays, as exactly as f32 allows.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{Camera, LightSource};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, parallel_camera, placed, telescope, view};
use umbrage_verify::{Case, Oracle, Random, TestMesh};

use super::FAR;

/// Adds `count` triangles for each light. Up to the rounding of corners to f32, a pixel's shadow ray passes through an
/// edge, a corner or the plane of the triangle, or lies in it.
pub(super) fn aim(mut case: Case, random: &mut Random, count: u32, size: f32, first_row: u32, kinds: &[u32]) -> Case {
    let (shot, oracle) = (case.shot(), Oracle::new(case.mesh.triangles()));
    let mut points = Vec::new();
    for (x, y) in case.pixels().filter(|&(_, y)| y >= first_row) {
        let ray = shot.ray(x, y);
        points.extend(oracle.nearest(&ray, |_| true).map(|hit| HitPoint::new(&ray, hit.t).position));
    }
    let mut mesh = case.mesh.clone();
    for light in &case.lights {
        for number in 0..count {
            let to = points[random.below(points.len())];
            let from = match *light {
                LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3(),
                LightSource::Directional { direction } => to - direction.as_dvec3() * f64::from(8.0 * size),
            };
            let at = |part: f64| from.lerp(to, part);
            let mut some = || f64::from(random.unit());
            let part = 0.6 + 0.38 * some();
            let girth = f64::from(size) * 10.0_f64.powf(-4.0 * some());
            let near = 10.0_f64.powf(-2.0 - 5.0 * some()) * girth;
            let [s, t] = [some(), some()];
            let mut aside = || random.point().as_dvec3() * girth;
            let (u, v, w) = (aside(), aside(), aside());
            let corners = match kinds[number as usize % kinds.len()] {
                // An edge.
                0 => [at(part) + u * s, at(part) - u * t, at(part) + v],
                // A corner.
                1 => [at(part), at(part) + u, at(part) + v],
                // The plane, with the point inside of the triangle.
                2 => [to + u, to + v, to - (u + v) * (0.3 + s)],
                // The whole ray lies in the triangle.
                3 => [at(part), at(part + (0.95 - part) * s), at(part) + u],
                // A sliver.
                4 => [at(part) + u * s, at(part) - u * t, at(part) + u * (s - t) * 0.5 + w * near / girth],
                // Reaching behind the light.
                5 => [at(part) + u * (20.0 * s), at(part) - u * (20.0 * t), at(-1.0) + v],
                6 => [to + (at(-0.5) - to) + u, to + (to - at(-0.5)) * s - u, to + v * 10.0],
                // Steep, and near the point.
                _ => [at(0.9 + 0.09 * s) + u * near / girth, at(0.9 * part) + v * near / girth, at(part) + w],
            };
            mesh.push(corners.map(DVec3::as_vec3));
        }
    }
    case.mesh = mesh;
    case
}

/// A card and a smaller one above it. All of it is within a light's face, so that it takes the filter of small triangles.
fn cards() -> TestMesh {
    let mut mesh = TestMesh::plane(2, 0.9).placed(1.0, Vec3::NEG_Y);
    mesh.quad([(-0.5, -0.5), (0.4, -0.5), (0.5, 0.3), (-0.5, 0.4)].map(|(x, z)| Vec3::new(x, -0.8 + 0.1 * x, z)));
    mesh
}

/// Settings for aimed triangles: one of four lights, a camera and a world.
pub(super) fn setting(number: u32, seed: u64) -> Case {
    let (light, seen) = (number % 4, number / 4);
    let mut random = Random::new(seed);
    let grazing = Camera::look_at(Vec3::new(0.3, -0.93, 1.0), Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 1.0);
    let (scale, offset) =
        [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (300.0, FAR)][if seen < 3 { seen as usize } else { 0 }];
    let (camera, (width, height)) = match seen {
        0..3 => (camera(), (26, 20)),
        3 => (parallel_camera(), (26, 20)),
        4 => (grazing, (24, 130)),
        5 => (telescope(100.0), (26, 20)),
        _ => (telescope(1000.0), (26, 20)),
    };
    let at = |x: f32, y: f32, z: f32| point(Vec3::new(x, y, z) * scale + offset);
    let low = Vec3::new(0.4 + random.unit(), 0.2, 0.3);
    let light = match light {
        0 => at(0.5, 2.5, 0.7),
        1 => at(low.x, low.y, low.z),
        2 => sun(0.3, -1.0, 0.2),
        _ => sun(1.0, -0.05, 0.3),
    };
    let view = view(placed(camera, scale, offset), width, height);
    let name = format!("aimed, setting {number}, seed {seed}");
    let case = Case::new(name, cards().placed(scale, offset), view, &[light]);
    let first_row = if height > 100 { 64 } else { 0 };
    let [small, large] = [&[0, 1, 2, 3, 4, 7], &[5, 6, 7, 0, 2, 1]];
    aim(case, &mut random, 120, 0.2 * scale, first_row, if seed % 8 == 7 { large } else { small })
}

/// Settings that fail without certain margins: points' errors in the edges and nearness of small and large triangles
/// and in the boxes of parts, and the thresholds above which a shadow is certain.
pub(super) fn all() -> Vec<Case> {
    let mut all: Vec<Case> = [0, 1, 2, 3, 5, 6, 9, 12, 15, 17, 20, 21, 24, 27].map(|number| setting(number, 5)).into();
    all.extend([4, 5, 22].map(|number| setting(number, 7)));
    all
}
