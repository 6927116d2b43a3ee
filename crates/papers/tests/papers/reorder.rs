//! Batches of rays in all orders, by all methods, against the hierarchy's single rays.

use glam::{DVec3, Vec3};
use umbrage_papers::reorder::{Counts, Order, Reorder, Traversal, blocked, nearest};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, LightSource, Ray, SimdLevel, SingleRays as _, Triangles};

use crate::support::{
    Mesh, Random, blocks, corners_of_cells, grazing_rays, random_ray, rays_in_planes, rays_with_intervals, scene,
};

const ORDERS: [Order; 4] = [Order::Arrival, Order::Runs, Order::Types, Order::Directions];
const TRAVERSALS: [Traversal; 9] = [
    Traversal::Single,
    Traversal::SingleCounted,
    Traversal::Packets(8),
    Traversal::Packets(16),
    Traversal::Packets(64),
    Traversal::Ranged,
    Traversal::Adaptive,
    Traversal::Stream,
    Traversal::MultiFrusta,
];

fn methods() -> impl Iterator<Item = Reorder> {
    ORDERS.into_iter().flat_map(|order| TRAVERSALS.map(|by| Reorder { order, by }))
}

type Bits = Option<(u32, u64, [u32; 2])>;

fn bits(hit: &Option<Hit>) -> Bits {
    hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric.map(f32::to_bits)))
}

/// Compares all methods with single rays at a level, including shadow rays from the hits to some lights. Returns the
/// numbers of hits and of blocked shadow rays.
#[track_caller]
fn check_at(
    level: SimdLevel,
    triangles: Triangles<'_>,
    rays: &[Ray],
    lets: &dyn Fn(u32, [f32; 2]) -> bool,
) -> [usize; 2] {
    let mut bvh = Bvh::with_level(level);
    bvh.build(triangles);
    let kinds = |count: usize| (0..count as u32).map(|index| index / 5 % 3).collect::<Vec<u32>>();
    let stops = |hit: &Hit| lets(hit.triangle, hit.barycentric);
    let expected: Vec<_> = rays.iter().map(|ray| bvh.nearest(triangles, ray, &stops)).collect();
    let bounds = triangles.bounds();
    let lights = [
        LightSource::Point { position: bounds.center() + bounds.size() * 0.8 },
        LightSource::Point { position: bounds.center() },
        LightSource::Directional { direction: Vec3::new(0.3, -1.0, 0.0) },
    ];
    let (mut shadow_rays, mut own) = (Vec::new(), Vec::new());
    for (index, (ray, hit)) in rays.iter().zip(&expected).enumerate() {
        let Some(hit) = hit else { continue };
        let point = HitPoint::new(ray, hit.t);
        if point.position.is_finite() {
            shadow_rays.push(ShadowRay::new(&lights[index % lights.len()], point));
            own.push(hit.triangle);
        }
    }
    let expected_shadows: Vec<_> =
        shadow_rays.iter().zip(&own).map(|(ray, &own)| bvh.blocked(triangles, ray, own, lets)).collect();
    for how in methods() {
        // Old contents are overwritten.
        let mut hits = vec![Some(Hit { t: 0.0, triangle: 0, barycentric: [0.0; 2] }); rays.len()];
        nearest(&bvh, triangles, (rays, &kinds(rays.len())), how, &stops, &mut hits);
        for (index, (found, expected)) in hits.iter().zip(&expected).enumerate() {
            assert_eq!(bits(found), bits(expected), "{how:?}, {level}, number {index}: {:?}", rays[index]);
        }
        let mut shadows = vec![true; shadow_rays.len()];
        blocked(&bvh, triangles, (&shadow_rays, &own, &kinds(own.len())), how, lets, &mut shadows);
        for (index, (found, expected)) in shadows.iter().zip(&expected_shadows).enumerate() {
            assert_eq!(found, expected, "{how:?}, {level}, number {index}: {:?}", shadow_rays[index]);
        }
    }
    let shadowed = expected_shadows.iter().filter(|&&is_blocked| is_blocked).count();
    [expected.iter().flatten().count(), shadowed]
}

#[track_caller]
fn check(mesh: &Mesh, rays: &[Ray]) -> [usize; 2] {
    check_at(SimdLevel::default(), mesh.triangles(), rays, &|_, _| true)
}

/// Rays of a small picture.
fn fan(random: &mut Random, side: u32) -> Vec<Ray> {
    let (origin, target) = (random.point() * 4.0, random.point() * 0.5);
    let forward = (target - origin).normalize();
    let right = forward.any_orthonormal_vector();
    let up = forward.cross(right);
    let pixels = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
    let beside = |[x, y]: [u32; 2]| [x, y].map(|at| (at as f32 / side as f32 - 0.5) * 0.8);
    pixels.map(beside).map(|[x, y]| Ray::new(origin.as_dvec3(), (forward + right * x + up * y).as_dvec3())).collect()
}

#[test]
fn batches_hit_what_single_rays_do() {
    let mut random = Random(1);
    let mesh = scene(&mut random);
    let mut rays = fan(&mut random, 40);
    rays.extend((0..700).map(|_| random_ray(&mut random, 2.0)));
    let lets = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(3) || barycentric[0] < 0.7;
    for level in SimdLevel::available() {
        let [hit, shadowed] = check_at(level, mesh.triangles(), &rays, &lets);
        assert!(hit > 300 && shadowed > 50, "{hit} hit, {shadowed} in shadow");
    }
    for count in [0, 1, 7, 8, 9, 63, 64, 65, 255, 257] {
        check(&mesh, &rays[..count]);
    }
}

#[test]
fn awkward_batches_hit_what_single_rays_do() {
    let mut random = Random(2);
    let (cells, at_corners) = corners_of_cells();
    let [hit, _] = check(&cells, &at_corners);
    assert!(hit > 100, "{hit}");
    let cubes = blocks(&mut random, 60);
    let mut rays = rays_in_planes(&mut random, 200);
    rays.extend(grazing_rays(cubes.triangles(), &mut random, 200));
    rays.extend(rays_with_intervals(cubes.triangles(), &mut random, 200));
    let [hit, _] = check(&cubes, &rays);
    assert!(hit > 200, "{hit}");
    // Of all sizes and far away, where f32 is coarse.
    for (scale, offset) in [(1e-18, 0.0), (1e12, 0.0), (1.0, 3e4), (1e-3, 7.0)] {
        let moved = scene(&mut random).moved(scale, Vec3::splat(offset));
        let place = |ray: Ray| Ray {
            origin: ray.origin * f64::from(scale) + f64::from(offset),
            direction: ray.direction * f64::from(scale),
            ..ray
        };
        let mut rays: Vec<_> = (0..150).map(|_| place(random_ray(&mut random, 2.0))).collect();
        rays.extend(fan(&mut random, 20).into_iter().map(place));
        let [hit, _] = check(&moved, &rays);
        assert!(hit > 20, "{hit} at {scale} and {offset}");
    }
    check(&Mesh::default(), &fan(&mut random, 9));
}

#[test]
fn rays_that_are_none_go_alone() {
    let mut random = Random(3);
    let mesh = scene(&mut random);
    let mut rays = fan(&mut random, 16);
    for (index, ray) in rays.iter_mut().enumerate() {
        match index % 11 {
            0 => ray.direction = DVec3::ZERO,
            1 => ray.origin.x = f64::NAN,
            2 => ray.direction.y = f64::INFINITY,
            3 => ray.origin *= 1e40,
            4 => ray.t_min = -5.0,
            5 => (ray.t_min, ray.t_max) = (2.0, 1.0),
            6 => ray.t_min = f64::NEG_INFINITY,
            _ => {}
        }
    }
    let [hit, _] = check(&mesh, &rays);
    assert!(hit > 20, "{hit}");
}

#[test]
fn demo_scenes_are_the_same_in_batches() {
    for demo in umbrage_gallery::DEMOS {
        let scene = umbrage_gallery::open(&format!("demo:{}?triangles=3000", demo.name)).expect("a scene");
        let mut frame = umbrage_scene::Frame::default();
        scene.pose(0.3, &mut frame).expect("a pose");
        let triangles = frame.triangles();
        let (bounds, mut random) = (triangles.bounds(), Random(4));
        let size = bounds.size().max_element();
        let place = |ray: Ray| Ray {
            origin: bounds.center().as_dvec3() + ray.origin * f64::from(size) * 0.3,
            direction: ray.direction * f64::from(size),
            ..ray
        };
        let mut rays: Vec<_> = fan(&mut random, 24).into_iter().map(place).collect();
        rays.extend((0..200).map(|_| place(random_ray(&mut random, 1.0))));
        let [hit, _] = check_at(SimdLevel::default(), triangles, &rays, &|_, _| true);
        assert!(hit > 20, "{hit} in {}", demo.name);
    }
}

/// The methods reach their goals: the bounds of parallel rays cull boxes, and regrouped packets fill their lanes.
#[test]
fn coherent_rays_take_fewer_tests_together() {
    let mut random = Random(5);
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    let triangles = mesh.triangles();
    let mut bvh = Bvh::default();
    bvh.build(triangles);
    let rays = fan(&mut random, 64);
    let kinds = vec![0; rays.len()];
    let mut hits = vec![None; rays.len()];
    let mut count = |order, by| -> Counts {
        nearest(&bvh, triangles, (&rays, &kinds), Reorder { order, by }, &|_| true, &mut hits)
    };
    let single = count(Order::Arrival, Traversal::SingleCounted);
    assert!(single.tests > rays.len() as u64, "{single:?}");
    let packets = count(Order::Directions, Traversal::Packets(64));
    let adaptive = count(Order::Directions, Traversal::Adaptive);
    let ranged = count(Order::Directions, Traversal::Ranged);
    let frusta = count(Order::Directions, Traversal::MultiFrusta);
    // Without bounds, every child would be for all.
    assert!(5 * ranged.tests < 6 * packets.tests, "{ranged:?}, {packets:?}");
    assert!(frusta.tests < 2 * packets.tests, "{frusta:?}, {packets:?}");
    assert!(adaptive.tests < packets.tests && adaptive.regrouped > 0, "{adaptive:?}, {packets:?}");
    let used = |counts: Counts| counts.lanes as f64 / (8 * counts.tests) as f64;
    assert!(used(adaptive) > used(packets), "{adaptive:?}, {packets:?}");
}
