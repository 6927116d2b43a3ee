//! Scenes that one far vertex stretches, or that one triangle covers.

use glam::Vec3;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray, Structure};

use super::{Mesh, Random, blocked_by_any, nearest_of_all};

/// A ball and small triangles around it.
pub(crate) fn ordinary() -> Mesh {
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40);
    mesh.append(&Mesh::soup(&mut Random(41), 400, 0.01));
    mesh
}

/// The same scene with a far vertex of the ball, with several at different distances, or with a triangle that covers all.
pub(crate) fn damaged() -> Vec<(String, Mesh)> {
    let directions = [Vec3::NEG_X, Vec3::new(0.3, -1.0, 0.2), Vec3::new(1.0, -0.9, 1.1)];
    let mut all = Vec::new();
    for (step, distance) in [1e6, 1e12, 1e13, 1.5e25, 1e30, 1e37].into_iter().enumerate() {
        let mut mesh = ordinary();
        mesh.positions[500] = directions[step % 3] * distance;
        all.push((format!("a vertex {distance} away"), mesh));
        let mut mesh = ordinary();
        let [a, b, c] = [Vec3::new(-3.0, -4.0, 1.0), Vec3::new(4.0, -3.0, 2.0), Vec3::new(-1.0, 5.0, 1.5)];
        mesh.push([a, b, c].map(|corner| corner * distance));
        all.push((format!("a triangle of {distance}"), mesh));
    }
    let mut mesh = ordinary();
    for (step, distance) in [1e4, 1e9, 1e15, 1e20, 1e28].into_iter().enumerate() {
        mesh.positions[300 + 40 * step] = directions[step % 3] * distance;
    }
    all.push(("vertices at five distances".to_owned(), mesh));
    // A far triangle that can't be hit.
    let mut mesh = ordinary();
    mesh.push([Vec3::X * 1e30; 3]);
    all.push(("a far triangle without an area".to_owned(), mesh));
    all
}

pub(crate) fn rays() -> Vec<Ray> {
    let mut random = Random(42);
    let ray = |_| {
        let origin = (random.point() * 4.0).as_dvec3();
        Ray::new(origin, (random.point() * 1.2).as_dvec3() - origin)
    };
    (0..150).map(ray).collect()
}

/// Compares a structure's answers for single rays with the predicate's.
pub(crate) fn check_answers(mut structure: impl Structure) {
    let rays = rays();
    let light = LightSource::Point { position: Vec3::new(2.0, 3.0, -1.0) };
    for (name, mesh) in damaged() {
        let triangles = mesh.triangles();
        structure.build(triangles);
        let answers = structure.single_rays().expect("a structure for single rays");
        let mut hits = 0;
        for ray in &rays {
            let expected: Option<Hit> = nearest_of_all(triangles, ray, |_| true);
            assert_eq!(answers.nearest(triangles, ray, &|_| true), expected, "{structure:?}, {name}, {ray:?}");
            let Some(hit) = expected else { continue };
            hits += 1;
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(ray, hit.t));
            let blocked = blocked_by_any(triangles, &shadow_ray, hit.triangle, |_, _| true);
            let found = answers.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true);
            assert_eq!(found, blocked, "{structure:?}, {name}, {ray:?}");
        }
        assert!(hits > 50, "{name}");
    }
}
