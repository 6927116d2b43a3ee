//! Any rays through the tracer: their first hits, whether they hit anything and how many triangles, against the predicate
//! asked about every triangle.

use umbrage_rays::predicate::hit;
use umbrage_rays::{Hit, Ray, Scanned, Sides, SimdLevel, Trace, Tracer, Triangles, Wanted};

use crate::support::scales::{SCALES, meshes};
use crate::support::{Random, far};
use glam::Vec3;

/// Compares all answers at every level with the predicate's; returns the number of hits.
fn check(name: &str, trace: &Trace<'_>) -> usize {
    let is_usable = |id: &u32| trace.triangles.usable_corners(*id).is_ok();
    let ids: Vec<u32> = (0..trace.triangles.len() as u32).filter(is_usable).collect();
    let all = |ray: Ray| -> Vec<Hit> {
        let hits = ids.iter().filter_map(|&id| hit(&ray, trace.triangles, id));
        let is_stopped = |hit: &Hit| {
            trace.sides.stop(&ray, hit.triangle, trace.triangles.corners(hit.triangle))
                && trace.opacity.is_stopped_at(hit.triangle, hit.barycentric)
        };
        let mut hits: Vec<Hit> = hits.filter(is_stopped).collect();
        hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        hits
    };
    let expected: Vec<Vec<Hit>> = (0..trace.rays.len()).map(|index| all(trace.rays.get(index))).collect();
    for level in SimdLevel::available() {
        let (mut tracer, mut found, mut of_ids) = (Tracer::with_level(level), Scanned::default(), Scanned::default());
        let (mut any, mut counts) = (Vec::new(), Vec::new());
        tracer.trace(trace, &mut found);
        tracer.trace(&Trace { wanted: Wanted::IDS, ..*trace }, &mut of_ids);
        tracer.hits_any(trace, &mut any);
        tracer.count_hits(trace, &mut counts);
        assert_eq!([found.len(), of_ids.len(), any.len(), counts.len()], [expected.len(); 4], "{name}");
        for (index, hits) in expected.iter().enumerate() {
            let about = || format!("{name} at {level}, {:?}", trace.rays.get(index));
            assert_eq!(found.hits(index).next(), hits.first().copied(), "{}", about());
            assert_eq!(of_ids.triangle[index], hits.first().map_or(Scanned::NONE, |hit| hit.triangle), "{}", about());
            assert_eq!((any[index], counts[index] as usize), (!hits.is_empty(), hits.len()), "{}", about());
        }
    }
    expected.iter().map(Vec::len).sum()
}

/// Rays through and along corners, edges and middles of triangles. Some begin or end before a triangle that they would hit,
/// or at it.
fn rays(triangles: Triangles<'_>, random: &mut Random) -> Vec<Ray> {
    let size = f64::from(triangles.bounds().size().max_element());
    let mut rays = Vec::new();
    for number in 0..300 {
        let [a, b, c] = triangles.corners(number * 7 % triangles.len() as u32).map(Vec3::as_dvec3);
        let target = [a, a.midpoint(b), a.lerp(b, 0.3).lerp(c, 0.4)][number as usize % 3];
        let origin = target + random.point().as_dvec3() * size;
        let ray = Ray::new(origin, target - origin);
        rays.push(match number % 5 {
            0 => Ray { t_max: 0.5, ..ray },
            1 => Ray { t_min: f64::NEG_INFINITY, t_max: 1.0, ..ray },
            2 => Ray { t_min: 1.0 - 1e-7, t_max: 1.0 + 1e-7, ..ray },
            // t may be zero or infinite.
            3 => Ray {
                direction: ray.direction * [1e-320, 1e-200, 1e-30, 1e30, 1e200, 1e300][number as usize % 6],
                ..ray
            },
            _ => ray,
        });
    }
    rays
}

#[test]
fn scenes_of_every_scale_are_hit_as_the_predicate_says() {
    let mut random = Random(71);
    for scale in SCALES {
        for (name, mesh) in meshes(&mut random) {
            let mesh = mesh.moved(scale, Vec3::ZERO);
            let rays = rays(mesh.triangles(), &mut random);
            let hits = check(&format!("{name} of {scale:e}"), &Trace::new(mesh.triangles(), &rays));
            assert!(hits > 50, "{name} of {scale:e}: {hits}");
        }
    }
}

#[test]
fn scenes_some_of_which_is_far_away_are_hit_as_the_predicate_says() {
    for (name, mesh) in far::damaged() {
        let hits = check(&name, &Trace::new(mesh.triangles(), &far::rays()));
        assert!(hits > 50, "{name}: {hits}");
    }
}

#[test]
fn triangles_that_let_rays_through_are_not_counted() {
    let mesh = far::ordinary();
    let rays = rays(mesh.triangles(), &mut Random(72));
    let all = Trace::new(mesh.triangles(), &rays);
    let mask = |id: u32, [u, v]: [f32; 2]| !id.is_multiple_of(5) || u + v < 0.5;
    let of_all = check("opaque", &all);
    for trace in [Trace { sides: Sides::Front, ..all }, Trace { opacity: &mask, ..all }] {
        let hits = check("not all stop", &trace);
        assert!((50..of_all).contains(&hits), "{hits} of {of_all}");
    }
}
