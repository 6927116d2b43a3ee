//! Scenes of every magnitude that coordinates may have, against the predicate asked about every triangle.

use glam::Vec3;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Camera, Cone, LightMask, LightSource, Projection, SeenPixels, Shot, Structure, View};

use super::{Mesh, Random, blocked_by_any, nearest_of_all};

/// Structures by their names.
pub(crate) type Structures = Vec<(&'static str, Box<dyn Structure>)>;

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
pub(crate) fn meshes(random: &mut Random) -> Vec<(&'static str, Mesh)> {
    let mut soup = Mesh::soup(random, 40, 0.05);
    soup.append(&Mesh::floor(3, 3.0));
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 5);
    vec![("a soup over a floor", soup), ("a ball", ball)]
}

pub(crate) fn lights(scale: f32) -> Vec<LightSource> {
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
pub(crate) const SCALES: [f32; 12] = [1e-37, 1e-30, 1e-24, 1e-18, 1e-10, 1.0, 1e10, 1e18, 1e24, 1e30, 1e36, 1e37];

/// Compares structures with the predicate in scenes of every scale.
pub(crate) fn check_every_scale(mut structures: Structures) {
    let mut random = Random(51);
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

/// Compares structures with the predicate in scenes some of which is far away.
pub(crate) fn check_far_parts(mut structures: Structures) {
    let mut random = Random(52);
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
