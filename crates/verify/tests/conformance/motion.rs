//! Rays hit moving triangles where the oracle says that they are at the ray's moment.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::{Hit, Key, MotionTree, MovingTriangles, Ray, Scanned, SimdLevel};
use umbrage_verify::{Oracle, Random, TestMesh};

use crate::frames::on_threads;
use crate::scan::{self, meshes};
use crate::single_rays::bits;

/// Positions somewhat later: all moved, each moved, one moved far away, or some of them gone.
fn later(positions: &[Vec3], size: f32, random: &mut Random) -> Vec<Vec3> {
    let mut later = positions.to_vec();
    let (shift, grown) = (random.point() * size, 1.0 + 0.5 * random.point().x);
    let mode = random.below(8);
    for position in &mut later {
        match mode {
            0 => {}
            1 => *position += random.point() * (0.1 * size),
            2 => *position = *position * -grown + shift,
            _ => *position = *position * grown + shift,
        }
    }
    if !later.is_empty() && random.below(3) == 0 {
        let vertex = random.below(later.len());
        later[vertex] = match random.below(4) {
            0 => Vec3::NAN,
            1 => Vec3::splat(3e38),
            2 => later[vertex] * 1e14,
            _ => later[0],
        };
    }
    later
}

#[test]
fn rays_hit_moving_triangles_where_the_oracle_says() {
    let mut random = Random::new(65);
    let levels = SimdLevel::available();
    let mut trees: Vec<_> = levels.iter().map(|&level| MotionTree::with_level(level)).collect();
    let (mut met, mut traced, mut posed) = (0, Scanned::default(), TestMesh::default());
    let all = meshes();
    for round in 0..4 * all.len() {
        let (name, mesh, size, middle) = &all[round / 4];
        let mut positions = vec![mesh.positions.clone()];
        for _ in 0..round % 4 {
            positions.push(later(&positions[positions.len() - 1], *size, &mut random));
        }
        if round % 3 == 2 {
            // From far away on one side to as far away on the other: halfway all is where it was, but for what f32 loses.
            let far = random.point() * (1e5 * *size);
            positions = [far, -far].map(|far| mesh.positions.iter().map(|&position| position + far).collect()).into();
        }
        let start = f64::from(random.point().x);
        let keys: Vec<_> = (0_u8..)
            .zip(&positions)
            .map(|(number, positions)| Key { seconds: start + f64::from(number) * 0.7, positions })
            .collect();
        let moving = MovingTriangles { keys: &keys, indices: &mesh.indices };
        let mut moments: Vec<f64> = keys.iter().map(|key| key.seconds).collect();
        moments.extend((0..4).map(|_| start + 2.5 * f64::from(random.point().x)));
        moments.extend((0..4).map(|_| start + 0.35 + 1e-6 * f64::from(random.point().x)));
        moving.pose(keys[keys.len() - 1].seconds, &mut posed.positions);
        assert!(
            posed.positions.iter().zip(keys[keys.len() - 1].positions).all(|(a, b)| a == b || b.is_nan() || a.is_nan())
        );
        let mut rays: Vec<(Ray, f64, u32, Option<Hit>)> = Vec::new();
        for seconds in moments {
            moving.pose(seconds, &mut posed.positions);
            posed.indices.clone_from(&mesh.indices);
            let oracle = Oracle::new(posed.triangles());
            let mut here: Vec<(Ray, f64, u32, Option<Hit>)> = Vec::new();
            for origin in scan::origins(mesh, *size, *middle, &mut random) {
                for direction in scan::directions(&posed, origin, *size, &mut random, 36) {
                    let ray = Ray::new(origin, direction.as_dvec3());
                    let part = Ray { t_min: -0.5, t_max: 1.5, ..ray };
                    let own = random.below(2 * mesh.indices.len() + 1) as u32;
                    here.push((if random.below(4) == 0 { part } else { ray }, seconds, own, None));
                }
            }
            here.par_iter_mut().for_each(|(ray, _, own, truth)| {
                let is_sound = ray.direction.is_finite() && ray.direction != DVec3::ZERO;
                *truth = oracle.nearest(ray, |hit| hit.triangle != *own).filter(|_| is_sound);
            });
            rays.extend(here);
        }
        met += rays.iter().filter(|(.., truth)| truth.is_some()).count();
        for tree in &mut trees {
            tree.build(&moving);
            for (ray, seconds, own, truth) in &rays {
                let found = tree.nearest_from(&moving, ray, *seconds, *own, &|_| true);
                assert_eq!(bits(&found), bits(truth), "{name}, round {round}: {ray:?} at {seconds}");
            }
        }
        let only: Vec<Ray> = rays.iter().map(|(ray, ..)| *ray).collect();
        let mut seconds: Vec<f64> = rays.iter().map(|(_, seconds, ..)| *seconds).collect();
        let last = seconds.len() - 1;
        seconds[last] = f64::NAN;
        on_threads(3, || trees[0].trace(&moving, &only, &seconds, &mut traced));
        for (index, (ray, &seconds)) in only.iter().zip(&seconds).enumerate() {
            let alone = trees[0].nearest_from(&moving, ray, seconds, Scanned::NONE, &|_| true);
            assert_eq!(bits(&traced.hits(index).next()), bits(&alone), "{name}");
        }
        assert_eq!(traced.hits(last).next(), None);
    }
    assert!(met > 10_000, "{met} hits");
}
