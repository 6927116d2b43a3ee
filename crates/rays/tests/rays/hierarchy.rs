//! The hierarchy, ray by ray, against the predicate asked about every triangle.

use glam::{DVec3, Vec3, Vec3Swizzles as _};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, LightSource, Ray, SimdLevel, SingleRays as _, Triangles};

use crate::support::{
    Mesh, Random, blocked_by_any, blocks, grazing_rays, nearest_of_all, random_ray, rays_in_planes,
    rays_with_intervals, scene,
};

/// A hierarchy that is built for the first time, and one of patches that were made when all vertices were elsewhere.
fn built(level: SimdLevel, triangles: Triangles<'_>) -> [Bvh; 2] {
    let elsewhere: Vec<Vec3> = triangles.positions.iter().rev().map(|position| position.yzx()).collect();
    [0, 3].map(|frames| {
        let mut bvh = Bvh::with_level(level);
        (0..frames).for_each(|_| bvh.build(Triangles { positions: &elsewhere, ..triangles }));
        build(&mut bvh, triangles);
        bvh
    })
}

fn build(bvh: &mut Bvh, triangles: Triangles<'_>) {
    bvh.build(triangles);
    bvh.check(triangles).expect("a sound hierarchy");
}

/// Compares the hierarchy at each level with the predicate for each ray, with everything opaque and with holes. Returns the
/// number of hits.
fn check(mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let bits = |hit: Option<Hit>| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric));
    let stops: [&dyn Fn(&Hit) -> bool; 2] =
        [&|_| true, &|hit| (hit.triangle + u32::from(hit.barycentric[0] < 0.5)) % 3 > 0];
    let mut count = 0;
    for stops in stops {
        let expected: Vec<_> = rays.iter().map(|ray| nearest_of_all(triangles, ray, stops)).collect();
        for level in SimdLevel::available() {
            for bvh in built(level, triangles) {
                for (ray, &expected) in rays.iter().zip(&expected) {
                    assert_eq!(bits(bvh.nearest(triangles, ray, stops)), bits(expected), "{ray:?} at {level}");
                }
            }
        }
        count += expected.iter().flatten().count();
    }
    count
}

#[test]
fn rays_from_anywhere_hit_what_the_predicate_says() {
    let mut random = Random(31);
    let mesh = scene(&mut random);
    let mut rays: Vec<Ray> = (0..600).map(|_| random_ray(&mut random, 3.0)).collect();
    rays.extend(rays_with_intervals(mesh.triangles(), &mut random, 100));
    rays.extend(grazing_rays(mesh.triangles(), &mut random, 200));
    assert!(check(&mesh, &rays) > 1000);
}

#[test]
fn rays_in_planes_of_boxes_hit_what_the_predicate_says() {
    let mut random = Random(32);
    let mesh = blocks(&mut random, 60);
    assert!(check(&mesh, &rays_in_planes(&mut random, 200)) > 500);
}

#[test]
fn scale_and_distance_change_nothing() {
    let mut random = Random(33);
    let small = scene(&mut random);
    // Tiny, huge, so large that squares overflow f32, and far from the origin.
    for (scale, offset) in [(1e-18, 0.0), (1e-6, 1.0), (1e9, 1e10), (1e15, 0.0), (1e30, 1e31), (1.0, 1e6)] {
        let mesh = small.moved(scale, Vec3::splat(offset));
        let far = f64::from(scale) * 1e4;
        let place = |point: DVec3| point * f64::from(scale) + f64::from(offset);
        let rays: Vec<Ray> = (0..60)
            .flat_map(|_| {
                let ray = random_ray(&mut random, 3.0);
                let (origin, target) = (place(ray.origin), place(ray.origin + ray.direction));
                let direction = target - origin;
                [Ray::new(origin, direction), Ray::new(origin - direction * far, direction)]
            })
            .collect();
        check(&mesh, &rays);
    }
}

#[test]
fn few_triangles_and_odd_ones_are_found() {
    let mut random = Random(34);
    let rays: Vec<Ray> = (0..100).map(|_| random_ray(&mut random, 3.0)).collect();
    check(&Mesh::default(), &rays);
    let mut mesh = Mesh::default();
    for count in 1..40 {
        mesh.push([0; 3].map(|_| random.point()));
        if count % 7 == 0 {
            // A triangle in the plane of the last one, the last one with its corners in another order, and one that covers
            // all.
            let [a, b, c] = mesh.triangles().corners(mesh.indices.len() as u32 - 1);
            mesh.push([b + c - a, c, b]);
            mesh.push([c, a, b]);
            mesh.push([a * 100.0, b * 100.0, c * 100.0]);
        }
        check(&mesh, &rays[..30]);
    }
    // No triangle can be hit.
    mesh.positions.fill(Vec3::NAN);
    check(&mesh, &rays);
    let nowhere = [
        Ray::new(DVec3::NAN, DVec3::X),
        Ray::new(DVec3::ZERO, DVec3::INFINITY),
        Ray::new(DVec3::ZERO, DVec3::ZERO),
        Ray::new(DVec3::splat(1e300), DVec3::NEG_ONE),
        Ray::new(DVec3::splat(-1e36), DVec3::ONE),
        Ray { t_max: f64::NAN, ..Ray::new(DVec3::ZERO, DVec3::X) },
    ];
    let mesh = scene(&mut random);
    let [bvh, _] = built(SimdLevel::default(), mesh.triangles());
    for ray in nowhere {
        let expected = if ray.origin.is_finite() && ray.direction.is_finite() && ray.direction != DVec3::ZERO {
            nearest_of_all(mesh.triangles(), &ray, |_| true)
        } else {
            None
        };
        assert_eq!(bvh.nearest(mesh.triangles(), &ray, &|_| true), expected, "{ray:?}");
    }
}

#[test]
fn a_million_copies_of_a_triangle_are_one_hit() {
    let mut mesh = Mesh::default();
    mesh.push([Vec3::X, Vec3::Y, Vec3::Z]);
    mesh.indices = vec![[0, 1, 2]; 1_000_000];
    let triangles = mesh.triangles();
    for bvh in built(SimdLevel::default(), triangles) {
        let ray = Ray::new(DVec3::ZERO, DVec3::ONE);
        assert_eq!(bvh.nearest(triangles, &ray, &|_| true).map(|hit| hit.triangle), Some(0));
        assert_eq!(bvh.nearest(triangles, &ray, &|hit| hit.triangle > 70).map(|hit| hit.triangle), Some(71));
        let light = LightSource::Point { position: Vec3::ZERO };
        let shadow_ray = ShadowRay::new(&light, HitPoint { position: DVec3::ONE, error: 0.0 });
        assert!(bvh.blocked(triangles, &shadow_ray, 5, &|_, _| true));
    }
}

#[test]
fn a_chain_of_ever_smaller_triangles_is_deep_and_found() {
    // Each triangle is half as large as the one before and beside it, so that every division separates a single one.
    let mut mesh = Mesh::default();
    for step in 0..120 {
        let size = 2.0_f32.powi(40 - step);
        mesh.push([Vec3::new(size, 0.0, 0.0), Vec3::new(size * 1.5, size, 0.0), Vec3::new(size * 1.5, 0.0, size)]);
    }
    let rays: Vec<Ray> = (0..120)
        .map(|step| {
            let size = 2.0_f64.powi(40 - step);
            Ray::new(DVec3::new(0.0, size * 0.2, size * 0.2), DVec3::X)
        })
        .collect();
    check(&mesh, &rays);
}

#[test]
fn points_are_in_shadow_where_the_predicate_says() {
    let mut random = Random(35);
    let (mut shadowed, mut lit) = (0, 0);
    for mesh in [scene(&mut random), blocks(&mut random, 60)] {
        let triangles = mesh.triangles();
        let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[0] > 0.3;
        let hits: Vec<(Ray, Hit)> = (0..400)
            .filter_map(|_| {
                let ray = random_ray(&mut random, 3.0);
                Some((ray, nearest_of_all(triangles, &ray, |_| true)?))
            })
            .collect();
        let lights = [
            LightSource::Point { position: Vec3::new(2.0, 3.0, -1.0) },
            LightSource::Point { position: Vec3::new(0.1, 0.2, 0.3) },
            LightSource::Directional { direction: Vec3::new(0.3, -1.0, 0.2) },
            LightSource::Directional { direction: Vec3::NEG_Y },
        ];
        for level in SimdLevel::available() {
            let [_, bvh] = built(level, triangles);
            for light in &lights {
                for (ray, hit) in &hits {
                    let shadow_ray = ShadowRay::new(light, HitPoint::new(ray, hit.t));
                    let expected = blocked_by_any(triangles, &shadow_ray, hit.triangle, counts);
                    let blocked = bvh.blocked(triangles, &shadow_ray, hit.triangle, &counts);
                    assert_eq!(blocked, expected, "{light:?}, {hit:?} at {level}");
                    *if blocked { &mut shadowed } else { &mut lit } += 1;
                }
            }
        }
    }
    assert!(shadowed > 500 && lit > 500, "{shadowed} in shadow, {lit} lit");
}

#[test]
fn the_hierarchy_is_the_same_for_any_number_of_threads() {
    let mut random = Random(36);
    let mut mesh = Mesh::soup(&mut random, 30_000, 0.001);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60));
    let triangles = mesh.triangles();
    let rays: Vec<Ray> = (0..200).map(|_| random_ray(&mut random, 3.0)).collect();
    let all: Vec<_> = [1, 2, 5]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let bvhs = pool.install(|| built(SimdLevel::default(), triangles));
            // Triangles come in the order of nodes and leaves.
            let order: Vec<u32> = bvhs.iter().flat_map(Bvh::ids).collect();
            let [bvh, _] = bvhs;
            (
                format!("{bvh:?}"),
                order,
                rays.iter().map(|ray| bvh.nearest(triangles, ray, &|_| true)).collect::<Vec<_>>(),
            )
        })
        .collect();
    assert!(all.iter().all(|one| *one == all[0]));
    for (ray, found) in rays.iter().zip(&all[0].2) {
        assert_eq!(*found, nearest_of_all(triangles, ray, |_| true));
    }
}
