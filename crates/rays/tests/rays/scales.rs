//! Scenes of every magnitude that coordinates may have, through every structure, against the predicate asked about every
//! triangle.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bvh, Camera, Cone, DirectGrids, KdMoved, KdTree, KdTreeOptions, LightMapping, LightMask, LightSource, ListedGrids,
    ListedLightOptions, ListedOptions, Lit, LitBits, Projection, Ray, Receivers, Scan, Scanned, Scanner, SeenPixels,
    Shot, SimdLevel, Structure, Sweep, TwoLevelKdTree, UniformGrid, UniformOptions, View,
};

use crate::support::{Mesh, Random, blocked_by_any, nearest_of_all};

/// Every structure, by its name.
fn structures() -> Vec<(&'static str, Box<dyn Structure>)> {
    let level = SimdLevel::default();
    let mut nested = UniformGrid::default();
    let options = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(4), ..UniformOptions::DEFAULT };
    nested.set_options(options).expect("possible options");
    let mut binned = KdTree::default();
    binned.set_options(KdTreeOptions::FAST).expect("possible options");
    let mut spherical = ListedLightOptions::DEFAULT;
    spherical.map = LightMapping::Spherical;
    vec![
        ("direct grids", Box::new(DirectGrids::default())),
        ("listed grids", Box::new(ListedGrids::default())),
        ("spherical grids", Box::new(ListedGrids::with_options(level, ListedOptions::DEFAULT, spherical))),
        ("uniform grid", Box::new(UniformGrid::default())),
        ("nested grid", Box::new(nested)),
        ("kd-tree", Box::new(KdTree::default())),
        ("binned kd-tree", Box::new(binned)),
        ("two-level kd-tree", Box::new(TwoLevelKdTree::with_level(level, KdMoved::Transform))),
        ("hierarchy", Box::new(Bvh::default())),
    ]
}

/// Returns the expected answer for each pixel: its triangle, and whether each light reaches it.
fn truth(shot: &Shot<'_>, lights: &[LightSource]) -> Vec<(u32, Vec<bool>)> {
    let View { width, height, .. } = shot.view;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let of_pixel = |(x, y)| {
        let ray = shot.ray(x, y);
        let Some(hit) = nearest_of_all(shot.triangles, &ray, |_| true) else {
            return (SeenPixels::NONE, vec![false; lights.len()]);
        };
        let is_lit = |light: &LightSource| {
            let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
            Cone::of(light).is_none_or(|cone| cone.contains(shadow_ray.point()))
                && !blocked_by_any(shot.triangles, &shadow_ray, hit.triangle, |_, _| true)
        };
        (hit.triangle, lights.iter().map(is_lit).collect())
    };
    pixels.map(of_pixel).collect()
}

/// Counts the pixels of a shot, and the points of a light, about which a structure is wrong.
fn wrong(
    structure: &mut dyn Structure,
    shot: &Shot<'_>,
    lights: &[LightSource],
    truth: &[(u32, Vec<bool>)],
) -> [usize; 2] {
    structure.build(shot.triangles);
    let mut seen = SeenPixels::default();
    structure.see(shot, &mut seen).expect("a small image");
    let mut masks = vec![LightMask::default(); lights.len()];
    structure.shadow(shot, &seen, lights, &mut masks);
    let mut wrong = [0; 2];
    for (pixel, (triangle, lit)) in truth.iter().enumerate() {
        let (x, y) = (pixel as u32 % shot.view.width, pixel as u32 / shot.view.width);
        wrong[0] += usize::from(seen.triangle_at(x, y) != *triangle);
        wrong[1] += masks.iter().zip(lit).filter(|(mask, lit)| mask.is_lit(x, y) != **lit).count();
    }
    wrong
}

/// Scenes of a size of about one, with a mesh that may reach farther.
fn meshes(random: &mut Random) -> Vec<(&'static str, Mesh)> {
    let mut soup = Mesh::soup(random, 40, 0.05);
    soup.append(&Mesh::floor(3, 3.0));
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 5);
    vec![("a soup over a floor", soup), ("a ball", ball)]
}

fn lights(scale: f32) -> Vec<LightSource> {
    let far = (1e6 * scale).min(1e37);
    vec![
        LightSource::Point { position: Vec3::new(2.0, 3.0, -1.0) * scale },
        LightSource::Point { position: Vec3::new(0.6, 0.7, -0.4) * far },
        LightSource::Point { position: Vec3::new(-0.5, 0.8, 0.3) * 1e36 },
        LightSource::Directional { direction: Vec3::new(0.3, -1.0, -0.2) },
        LightSource::Spot {
            position: Vec3::new(0.5, 2.5, 1.0) * scale,
            direction: Vec3::new(-0.1, -1.0, -0.3),
            inner_radians: 0.3,
            outer_radians: 0.6,
        },
    ]
}

fn cameras(scale: f32) -> [Camera; 2] {
    let near = Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8);
    let camera = Camera { position: near.position * scale, ..near };
    [camera, Camera { projection: Projection::Orthographic { half_height: 1.7 * scale }, ..camera }]
}

/// The magnitudes of coordinates.
const SCALES: [f32; 12] = [1e-37, 1e-30, 1e-24, 1e-18, 1e-10, 1.0, 1e10, 1e18, 1e24, 1e30, 1e36, 1e37];

#[test]
fn scenes_of_every_scale_are_seen_and_lit_as_the_predicate_says() {
    let mut random = Random(51);
    let mut structures = structures();
    let mut failures = Vec::new();
    for scale in SCALES {
        for (name, mesh) in meshes(&mut random) {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let lights = lights(scale);
            for camera in cameras(scale) {
                let shot = Shot::new(mesh.triangles(), View { camera, width: 13, height: 11 });
                let truth = truth(&shot, &lights);
                let hits = truth.iter().filter(|(id, _)| *id != SeenPixels::NONE).count();
                for (structure, made) in &mut structures {
                    let wrong = wrong(&mut **made, &shot, &lights, &truth);
                    if wrong != [0; 2] {
                        let kind = if matches!(camera.projection, Projection::Perspective { .. }) {
                            "perspective"
                        } else {
                            "parallel"
                        };
                        failures.push(format!("{structure}: {name} of {scale:e}, {kind}: {wrong:?} of {hits}"));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn scenes_some_of_which_is_far_away_are_seen_and_lit_as_the_predicate_says() {
    let mut random = Random(52);
    let mut structures = structures();
    let mut failures = Vec::new();
    for reach in [1e6, 1e12, 1e18, 1e24, 1e30, 1e36, 1e37, 3e38] {
        for round in 0..12 {
            let mut mesh = Mesh::default();
            for number in 0..16 {
                let mut corners = [0; 3].map(|_| random.point());
                if number % 2 == 1 {
                    corners[number / 2 % 3] = random.point() * reach;
                }
                mesh.push(corners);
            }
            let mut lights = lights(1.0);
            lights[1] = LightSource::Point { position: random.point() * (reach * 0.1) };
            let camera = cameras(1.0)[round % 2];
            let shot = Shot::new(mesh.triangles(), View { camera, width: 13, height: 11 });
            let truth = truth(&shot, &lights);
            for (structure, made) in &mut structures {
                let wrong = wrong(&mut **made, &shot, &lights, &truth);
                if wrong != [0; 2] {
                    failures.push(format!("{structure}: reach {reach:e}, round {round}: {wrong:?}"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
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
