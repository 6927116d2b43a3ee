//! Scenes of every magnitude that coordinates may have, through every structure, against the predicate asked about every
//! triangle.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Bvh, Cone, DirectGrids, Lit, LitBits, Ray, Receivers, Scan, Scanned, Scanner, Sweep};

use crate::support::scales::{SCALES, Structures, check_every_scale, check_far_parts, lights, meshes};
use crate::support::{Random, blocked_by_any, nearest_of_all};

/// Every structure, by its name.
fn structures() -> Structures {
    vec![("direct grids", Box::new(DirectGrids::default())), ("hierarchy", Box::new(Bvh::default()))]
}

#[test]
fn scenes_of_every_scale_are_seen_and_lit_as_the_predicate_says() {
    check_every_scale(structures());
}

#[test]
fn scenes_some_of_which_is_far_away_are_seen_and_lit_as_the_predicate_says() {
    check_far_parts(structures());
}

#[test]
fn scans_of_every_scale_and_length_find_what_the_predicate_says() {
    let mut random = Random(53);
    let (mut scanner, mut scanned) = (Scanner::default(), Scanned::default());
    let mut failures = Vec::new();
    for scale in SCALES {
        for (name, mesh) in meshes(&mut random) {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let triangles = mesh.triangles();
            scanner.build(triangles);
            for length in [1e-38, 1e-30, 1e-15, 1.0, 1e15, 1e30, 1e38] {
                let origins = [
                    Vec3::new(0.1, 0.2, 0.3).as_dvec3() * f64::from(scale),
                    Vec3::new(2.0, -3.0, 1.5).as_dvec3() * f64::from(scale),
                    Vec3::new(2e4, -3e5, 1.5e5).as_dvec3() * f64::from(scale),
                    DVec3::new(0.3, 0.5, -0.6) * 1e36,
                ];
                for origin in origins {
                    let towards = |target: Vec3| {
                        let direction = (target * scale).as_dvec3() - origin;
                        (direction / direction.abs().max_element() * length).as_vec3()
                    };
                    let directions: Vec<Vec3> = (0..60).map(|_| towards(random.point())).collect();
                    let sweeps = [Sweep { origin, directions: &directions }];
                    scanner.scan(&Scan::new(triangles, &sweeps), 1, &mut scanned);
                    let mut wrong = 0;
                    for (index, direction) in directions.iter().enumerate() {
                        let ray = Ray::new(sweeps[0].origin, direction.as_dvec3());
                        let expected = nearest_of_all(triangles, &ray, |_| true);
                        wrong += usize::from(scanned.hits(index).next() != expected);
                    }
                    if wrong > 0 {
                        failures.push(format!("{name} of {scale:e}, from {origin}, directions of {length:e}: {wrong}"));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn points_of_every_scale_are_lit_as_the_predicate_says() {
    let mut random = Random(54);
    let (mut scanner, mut bits) = (Scanner::default(), LitBits::default());
    let mut failures = Vec::new();
    for scale in SCALES {
        for (name, mesh) in meshes(&mut random) {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let triangles = mesh.triangles();
            scanner.build(triangles);
            let lights = lights(scale);
            let middles: Vec<Vec3> = (0..triangles.len() as u32)
                .map(|id| {
                    let [a, b, c] = triangles.corners(id);
                    a.lerp(b, 0.3).lerp(c, 0.4)
                })
                .collect();
            let own: Vec<u32> = (0..triangles.len() as u32).collect();
            for receivers in [
                Receivers::Faces,
                Receivers::Points { positions: &middles, own: &own },
                Receivers::Points { positions: &middles, own: &[] },
            ] {
                let lit = Lit::new(triangles, receivers);
                scanner.lit(&lit, &lights, &mut bits);
                for (number, light) in lights.iter().enumerate() {
                    let is_wrong = |point: &usize| {
                        let Some((at, own)) = lit.receivers.point(triangles, *point) else { return false };
                        let shadow_ray = ShadowRay::new(light, at);
                        let is_lit = Cone::of(light).is_none_or(|cone| cone.contains(at.position))
                            && !blocked_by_any(triangles, &shadow_ray, own, |_, _| true);
                        bits.is_lit(number, *point) != is_lit
                    };
                    let wrong = (0..triangles.len()).filter(is_wrong).count();
                    if wrong > 0 {
                        failures.push(format!("{name} of {scale:e}, light {number}: {wrong}"));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
