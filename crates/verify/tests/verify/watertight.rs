//! No ray slips between triangles that share an edge or a corner, and nothing shadows itself.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, LightSource, Ray, SingleRays as _};
use umbrage_verify::{Oracle, Random, TestMesh};

/// Balls of all sizes and at all positions that a scene may have, with mixed windings.
fn balls() -> Vec<(TestMesh, f32)> {
    const FAR: Vec3 = Vec3::new(148_376.0, 1_234.0, -223_423.0);
    [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (50.0, FAR), (1.0, Vec3::new(0.1, 7.0, -0.3))]
        .map(|(scale, offset)| (TestMesh::ball(3).placed(scale, offset), scale))
        .into()
}

/// A point on an edge or a corner of a random triangle, in f32 for corners and f64 along edges.
fn seam(mesh: &TestMesh, random: &mut Random) -> DVec3 {
    let corners = mesh.triangles().corners(random.below(mesh.indices.len()) as u32).map(Vec3::as_dvec3);
    let (from, to) = (random.below(3), random.below(3));
    match random.below(3) {
        0 => corners[from],
        1 => corners[from].midpoint(corners[to]),
        _ => corners[from].lerp(corners[to], f64::from(random.unit())),
    }
}

#[test]
fn no_ray_leaks_through_a_seam() {
    const RAYS: usize = 60_000;
    let mut random = Random::new(5);
    for (ball, scale) in balls() {
        let triangles = ball.triangles();
        let center = triangles.bounds().center();
        let mut bvh = Bvh::default();
        bvh.build(triangles);
        for _ in 0..RAYS {
            // From inside a closed surface every ray hits it; a tenth of a radius from the middle is inside.
            let origin = center + random.point() * (0.1 * scale);
            let ray = Ray::new(origin.as_dvec3(), seam(&ball, &mut random) - origin.as_dvec3());
            assert!(bvh.nearest(triangles, &ray, &|_| true).is_some(), "{ray:?} leaks out of a ball of {scale}");
        }
    }
}

#[test]
fn nothing_convex_shadows_itself_where_it_faces_the_light() {
    const RAYS: usize = 30_000;
    let mut random = Random::new(6);
    for (ball, scale) in balls() {
        let triangles = ball.triangles();
        let center = triangles.bounds().center();
        let mut bvh = Bvh::default();
        bvh.build(triangles);
        for _ in 0..RAYS {
            // The camera looks at seams of the outside; the light is above the point that it sees.
            let outwards = random.point().normalize_or(Vec3::X);
            let camera = (center + outwards * (4.0 * scale)).as_dvec3();
            let ray = Ray::new(camera, seam(&ball, &mut random) - camera);
            let Some(hit) = bvh.nearest(triangles, &ray, &|_| true) else { continue };
            let point = HitPoint::new(&ray, hit.t);
            let above = (point.position - center.as_dvec3()).normalize().as_vec3();
            let position = center + above * (3.0 * scale);
            for light in [LightSource::Point { position }, LightSource::Directional { direction: -above }] {
                let shadow_ray = ShadowRay::new(&light, point);
                let blocked = bvh.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true);
                assert!(!blocked, "{ray:?} is shadowed by a ball of {scale} itself");
            }
        }
    }
}

#[test]
fn the_far_side_of_a_ball_is_in_its_shadow() {
    let (ball, mut random) = (TestMesh::ball(3), Random::new(8));
    let oracle = Oracle::new(ball.triangles());
    let light = LightSource::Point { position: Vec3::new(0.0, 3.0, 0.0) };
    for _ in 0..500 {
        let camera = DVec3::new(0.0, -4.0, 0.0);
        let target = (random.point() * 0.35).with_y(-0.8).as_dvec3();
        let ray = Ray::new(camera, target - camera);
        let hit = oracle.nearest(&ray, |_| true).expect("the ball fills this part of the view");
        let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
        assert!(oracle.blocked(&shadow_ray, hit.triangle, |_, _| true));
    }
}

#[test]
fn coincident_surfaces_do_not_speckle_each_other() {
    let mut random = Random::new(9);
    for place in [Vec3::ZERO, Vec3::new(148_376.0, 1_234.0, -223_423.0)] {
        // The same floor three times, cut along different diagonals.
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| place + Vec3::new(x, 0.0, z));
        let mut floor = TestMesh::default();
        for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3], [2, 1, 0], [3, 2, 0]] {
            floor.push([corners[a], corners[b], corners[c]]);
        }
        let oracle = Oracle::new(floor.triangles());
        for _ in 0..3000 {
            let camera = (place + random.point().with_y(2.0)).as_dvec3();
            let target = (place + random.point().with_y(0.0)).as_dvec3();
            let ray = Ray::new(camera, target - camera);
            let Some(hit) = oracle.nearest(&ray, |_| true) else { continue };
            let point = HitPoint::new(&ray, hit.t);
            let position = place + random.point().with_y(random.unit() + 0.01);
            for light in [LightSource::Point { position }, LightSource::Directional { direction: Vec3::NEG_Y }] {
                let shadow_ray = ShadowRay::new(&light, point);
                assert!(!oracle.blocked(&shadow_ray, hit.triangle, |_, _| true), "{ray:?} {light:?}");
            }
        }
    }
}

#[test]
fn shells_that_are_nearly_together_keep_their_order() {
    const GAP: f32 = 4e-5;
    let (mut shells, outer) = (TestMesh::ball(2), TestMesh::ball(2).placed(1.0 + GAP, Vec3::ZERO));
    let inner = shells.indices.len() as u32;
    (0..inner).for_each(|id| shells.push(outer.triangles().corners(id)));
    let oracle = Oracle::new(shells.triangles());
    let (mut random, light) = (Random::new(10), LightSource::Point { position: Vec3::new(0.0, 5.0, 0.0) });
    for _ in 0..1500 {
        let camera = DVec3::new(0.0, 4.0, 0.0);
        let target = (random.point() * 0.35).with_y(0.8).as_dvec3();
        let ray = Ray::new(camera, target - camera);
        let hit = oracle.nearest(&ray, |_| true).expect("a ball is there");
        assert!(hit.triangle >= inner, "the inner shell shows through");
        let lit = |hit: &umbrage_rays::Hit| {
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            !oracle.blocked(&shadow_ray, hit.triangle, |_, _| true)
        };
        assert!(lit(&hit), "the outer shell shadows itself");
        let below = oracle.nearest(&ray, |hit| hit.triangle < inner).expect("the inner ball is there");
        assert!(!lit(&below), "light leaks through the outer shell");
    }
}

#[test]
fn lights_on_and_in_surfaces_are_not_blocked_by_them() {
    let mut mesh = TestMesh::default();
    mesh.push([Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, 1.0, -1.0), Vec3::new(0.0, 1.0, 1.0)]);
    mesh.push([Vec3::new(-9.0, 0.0, -9.0), Vec3::new(9.0, 0.0, -9.0), Vec3::new(0.0, 0.0, 9.0)]);
    let oracle = Oracle::new(mesh.triangles());
    let ray = Ray::new(DVec3::new(3.0, 0.5, -3.0), DVec3::new(-3.0, -0.5, 3.0));
    let hit = oracle.nearest(&ray, |_| true).expect("the floor");
    assert_eq!(hit.triangle, 1);
    let point = HitPoint::new(&ray, hit.t);
    let blocked = |position: Vec3| {
        oracle.blocked(&ShadowRay::new(&LightSource::Point { position }, point), hit.triangle, |_, _| true)
    };
    assert!(!blocked(Vec3::Y), "a light in the lamp's own triangle");
    assert!(blocked(Vec3::Y * 1.000_001), "a light just above it");
    assert!(!blocked(Vec3::Y * 0.999_999), "a light just below it");
    assert!(!blocked(point.position.as_vec3()), "a light on the lit point itself");
}
