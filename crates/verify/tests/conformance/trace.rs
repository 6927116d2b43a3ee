//! Any rays hit the triangles that the oracle says, with any structure that the tracer chooses.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage_rays::{Hit, Ray, Rays, Scanned, Sides, SimdLevel, SingleRays as _, Trace, TracedBy, Tracer, Triangles};
use umbrage_verify::{MIXED_SIDES, Oracle, Random, TestMesh};

use crate::scan::{self, WANTED, are_parts, meshes};
use crate::single_rays::{ALL, bits};

fn pools() -> Vec<ThreadPool> {
    [1, 2, 3, 7].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")).into()
}

/// The true hits, of triangles that may be hit.
fn truth(trace: &Trace<'_>) -> Vec<Option<Hit>> {
    let oracle = Oracle::new(trace.triangles);
    let all = 0..trace.rays.len();
    all.into_par_iter()
        .map(|index| {
            let ray = trace.rays.get(index);
            let is_some = ray.origin.is_finite() && ray.t_min < ray.t_max;
            let is_sound = is_some && ray.direction.is_finite() && ray.direction != DVec3::ZERO;
            let ray = Ray { t_min: ray.t_min.max(trace.t_min), t_max: ray.t_max.min(trace.t_max), ..ray };
            let nearest = oracle.nearest(&ray, |hit| {
                let id = hit.triangle;
                let is_stopped = trace.opacity.is_opaque(id) || trace.opacity.stops(id, hit.barycentric);
                is_stopped && trace.sides.stop(&ray, id, trace.triangles.corners(id))
            });
            nearest.filter(|_| is_sound)
        })
        .collect()
}

/// Compares a tracer's answers at every SIMD level and on several numbers of threads with the truth; returns the chosen
/// structure.
fn check(name: &str, trace: &Trace<'_>, truth: &[Option<Hit>], pools: &[ThreadPool]) -> TracedBy {
    let nowhere = |ray: Ray| !ray.direction.is_finite() || ray.direction == DVec3::ZERO;
    let without_direction = (0..truth.len()).filter(|&index| nowhere(trace.rays.get(index))).count();
    let (mut chosen, mut traced, mut any) = (None, Scanned::default(), Vec::new());
    for level in SimdLevel::available() {
        for pool in pools {
            let mut tracer = Tracer::with_level(level);
            let by = pool.install(|| tracer.trace(trace, &mut traced));
            let form = || format!("{name}, by the {by}, {level}, {} threads", pool.current_num_threads());
            assert_eq!(*chosen.get_or_insert(by), by, "{}", form());
            assert_eq!((traced.len(), traced.without_direction), (truth.len(), without_direction), "{}", form());
            for wanted in WANTED {
                let mut parts = Scanned::default();
                let same = pool.install(|| tracer.trace(&Trace { wanted, ..*trace }, &mut parts));
                assert!(same == by && are_parts(wanted, &parts, &traced), "{}: {wanted:?}", form());
            }
            pool.install(|| tracer.hits_any(trace, &mut any));
            assert!(any.iter().copied().eq(truth.iter().map(Option::is_some)), "{}", form());
            for (index, truth) in truth.iter().enumerate() {
                let found = traced.hits(index).next();
                assert_eq!(bits(&found), bits(truth), "{}: {:?}", form(), trace.rays.get(index));
                assert!(found.is_some() || traced.t[index] == f64::INFINITY && traced.barycentric[index][0].is_nan());
            }
        }
    }
    chosen.expect("some level")
}

#[test]
fn rays_from_anywhere_hit_what_the_oracle_says() {
    let pools = pools();
    for rays in &*ALL {
        let by = check(&rays.name, &Trace::new(rays.triangles(), &rays.rays), &rays.nearest, &pools);
        // Such rays hardly share an origin.
        assert!(by == TracedBy::Hierarchy || rays.rays.len() < 2, "{}", rays.name);
    }
}

/// Rays from a few origins in directions of f32, as for a scanner; the last ones are invalid.
fn together(mesh: &TestMesh, size: f32, middle: Vec3, random: &mut Random) -> Vec<Ray> {
    let origins = scan::origins(mesh, size, middle, random);
    let each = origins.into_iter().flat_map(|origin| {
        let directions = scan::directions(mesh, origin, size, random, 300);
        directions.into_iter().map(move |direction| Ray::new(origin, direction.as_dvec3()))
    });
    let mut rays: Vec<Ray> = each.collect();
    // After another one from the same origin, but not to be answered with it.
    rays.push(Ray { t_max: f64::NAN, ..rays[rays.len() - 1] });
    rays.push(Ray::new(DVec3::NAN, DVec3::X));
    rays
}

/// Intervals behind the origin, and directions that f32 can't represent, aren't for a scanner.
#[test]
fn what_a_scanner_does_not_take_hits_what_the_oracle_says() {
    let (pools, mesh) = (pools(), TestMesh::ball(2));
    let turned = |number: u32| (f64::from(number) * 0.1).sin_cos();
    let direction = |number: u32| DVec3::new(turned(number).0, 0.3, turned(number).1);
    let precise: Vec<Ray> = (0..5000).map(|number| Ray::new(DVec3::ZERO, direction(number))).collect();
    let rounded = precise.iter().map(|ray| Ray { direction: ray.direction.as_vec3().as_dvec3(), ..*ray });
    let behind: Vec<Ray> = rounded.clone().map(|ray| Ray { t_min: -3.0, t_max: -0.01, ..ray }).collect();
    for (name, rays, expected) in [
        ("f64 directions", precise.clone(), TracedBy::Hierarchy),
        ("behind", behind, TracedBy::Hierarchy),
        ("f32 directions", rounded.collect(), TracedBy::Scanner),
    ] {
        let trace = Trace::new(mesh.triangles(), &rays);
        let truth = truth(&trace);
        assert!(truth.iter().all(Option::is_some), "{name}");
        assert_eq!(check(name, &trace, &truth, &pools), expected, "{name}");
    }
}

/// Arrays of f32 and f64 give the same rays, and structures of other triangles are forgotten.
#[test]
fn moving_triangles_are_traced_where_they_are() {
    let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
    let single = [[0.25_f32, 0.5, 4.0, 0.0, 0.0, -2.0]; 3];
    let double = single.map(|ray| ray.map(f64::from));
    for step in 0_u8..4 {
        let mesh = TestMesh::ball(2).placed(1.0, Vec3::new(0.0, 0.0, -f32::from(step)));
        let triangles: Triangles<'_> = mesh.triangles();
        tracer.forget();
        for rays in [Rays::Single(&single), Rays::Double(&double)] {
            let trace = Trace::new(triangles, rays);
            tracer.trace(&trace, &mut traced);
            let expected = truth(&trace)[0].expect("a hit");
            assert!((0..3).all(|index| traced.hits(index).next() == Some(expected)), "step {step}");
            assert_eq!(tracer.hierarchy(triangles).nearest(triangles, &rays.get(0), &|_| true), Some(expected));
            assert!((expected.t - 0.5 * (4.0 + f64::from(step))).abs() < 0.5);
        }
    }
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn rays_from_few_origins_hit_what_the_oracle_says() {
        let (pools, mut random) = (pools(), Random::new(31));
        let mut hits = 0;
        for (name, mesh, size, middle) in meshes() {
            let triangles = mesh.triangles();
            let rays = together(&mesh, size, middle, &mut random);
            let base = Trace::new(triangles, &rays);
            let mask = |id: u32, [u, v]: [f32; 2]| !id.is_multiple_of(5) || u + v < 0.5;
            let part = Trace { t_min: 0.3, t_max: 1.0, ..base };
            let front = Trace { sides: Sides::Front, ..base };
            let masked = Trace { sides: MIXED_SIDES, opacity: &mask, ..base };
            for (trace, pool) in [base, part, front, masked].into_iter().zip(pools.chunks(1)) {
                let truth = truth(&trace);
                hits += truth.iter().flatten().count();
                // Each ray many times, so that a scanner pays; except for those with an origin of their own.
                let again: Vec<usize> =
                    (0..rays.len() - 2).flat_map(|index| [index; 12]).chain(rays.len() - 2..rays.len()).collect();
                let many: Vec<Ray> = again.iter().map(|&index| rays[index]).collect();
                let of_many: Vec<Option<Hit>> = again.iter().map(|&index| truth[index]).collect();
                let by = check(name, &Trace { rays: Rays::from(&many), ..trace }, &of_many, pool);
                assert_eq!(by, TracedBy::Scanner, "{name}");
                // In another order, in which two rays from one origin hardly ever follow each other.
                let order: Vec<usize> = (0..rays.len()).map(|index| index * 997 % rays.len()).collect();
                let mixed: Vec<Ray> = order.iter().map(|&index| rays[index]).collect();
                let truth: Vec<Option<Hit>> = order.iter().map(|&index| truth[index]).collect();
                let by = check(name, &Trace { rays: Rays::from(&mixed), ..trace }, &truth, &pools);
                assert_eq!(by, TracedBy::Hierarchy, "{name}");
            }
        }
        assert!(hits > 20_000, "{hits} hits");
    }
}
