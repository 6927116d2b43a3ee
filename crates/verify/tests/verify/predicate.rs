//! The reference predicate against the referee.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{Crossing, HitPoint, ShadowRay, crossing};
use umbrage_rays::{LightSource, Ray, Sides};
use umbrage_verify::{Random, referee};

fn agree(ray: &Ray, corners: [Vec3; 3]) -> Option<Crossing> {
    let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
    let found = crossing(ray, corners);
    assert_eq!(found.map(|found| found.t), referee::hit(&line, corners, true), "{ray:?} {corners:?}");
    if let Some(Crossing { barycentric: [v, w], front, .. }) = found {
        assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + f32::EPSILON, "{v} {w}");
        assert_eq!(front, referee::hit(&line, corners, false).is_some(), "{ray:?} {corners:?}");
    }
    found
}

/// A triangle, sometimes with corners that share coordinates or lie on a line, near the origin or far away.
fn triangle(random: &mut Random) -> [Vec3; 3] {
    let offset = match random.below(3) {
        0 => Vec3::ZERO,
        1 => Vec3::new(148_376.0, 1_234.0, -223_423.0),
        _ => random.point() * 10.0,
    };
    let scale = [1.0, 1e-6, 1e6, 0.03][random.below(4)];
    let mut corners = [(); 3].map(|()| random.point() * scale + offset);
    match random.below(6) {
        0 => corners[1].x = corners[0].x,
        1 => corners.iter_mut().for_each(|corner| corner.z = offset.z),
        2 => corners[2] = corners[0].lerp(corners[1], 0.5),
        _ => {}
    }
    corners
}

#[test]
fn random_lines_cross_where_they_should() {
    let mut random = Random::new(1);
    let mut hits = 0;
    for _ in 0..1500 {
        let corners = triangle(&mut random);
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let size = corners[0].distance(corners[1]) + corners[0].distance(corners[2]);
        let origin = (center + random.point() * size * 3.0).as_dvec3();
        let target = (center + random.point() * size * 0.2).as_dvec3();
        if origin != target {
            hits += u32::from(agree(&Ray::new(origin, target - origin), corners).is_some());
        }
    }
    assert!((200..1200).contains(&hits), "the test aims badly: {hits} hits");
}

#[test]
fn lines_through_edges_and_corners_cross_where_they_should() {
    let mut random = Random::new(2);
    for _ in 0..1500 {
        let corners = triangle(&mut random);
        let [a, b, _] = corners.map(Vec3::as_dvec3);
        let origin = match random.below(4) {
            // In the triangle's plane, or on a corner itself.
            0 => a + (a - b) * f64::from(random.unit()),
            1 => a,
            _ => (corners[0] + random.point() * corners[0].distance(corners[1])).as_dvec3(),
        };
        let target = match random.below(3) {
            0 => a,
            1 => a.lerp(b, f64::from(random.unit())),
            _ => a.midpoint(b),
        };
        let ray = Ray::new(origin, target - origin);
        if ray.direction != DVec3::ZERO {
            agree(&ray, corners);
        }
    }
}

#[test]
fn grazing_lines_cross_at_the_nearest_number() {
    let mut random = Random::new(6);
    let mut hits = 0;
    for _ in 0..3000 {
        // Corners of such different sizes that two terms can't represent a normal.
        let corners = [(); 3].map(|()| random.point() * 10.0_f32.powi(random.below(16) as i32 - 6));
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let (center, along) = ((a + b + c) / 3.0, (b - a) * f64::from(random.unit()) + (c - a));
        // So little above the plane, and then below it, that most of the slope's digits cancel.
        let lift = normal * (along.length() * 2.0_f64.powi(-10 - random.below(35) as i32));
        let origin = center + along * 0.15 + lift;
        let target = center - along * 0.15 - lift * f64::from(random.unit());
        hits += u32::from(agree(&Ray::new(origin, target - origin), corners).is_some());
    }
    assert!(hits > 1000, "the test aims badly: {hits} hits");
}

/// A triangle near a point of another triangle or between it and a light: in its plane, at its edges, or reaching far.
fn other(random: &mut Random, own: [Vec3; 3], light: Vec3) -> [Vec3; 3] {
    let [a, b, c] = own;
    let size = a.distance(b).max(a.distance(c));
    let far = |random: &mut Random| random.point() * size * 10.0_f32.powf(9.0 * random.unit());
    match random.below(6) {
        // In the same plane, nearly in it, and at an edge.
        0 => [b, a, c],
        1 => [a, a.lerp(b, random.unit() * 2.0), c.lerp(b, random.unit() * 2.0)],
        2 => [a, b, a + far(random)],
        // Slender ones that reach far, through the own triangle and beside the shadow ray.
        3 => [a, a + random.point() * size * 0.02, a + far(random)],
        4 => {
            let between = light.lerp(a, random.unit());
            [between, between + random.point() * size * 0.02, between + far(random)]
        }
        _ => [light.lerp(a, random.unit()), light.lerp(b, random.unit()) + far(random), c + random.point() * size],
    }
}

#[test]
fn points_are_in_the_shadow_that_the_referee_sees() {
    let mut random = Random::new(5);
    let (mut shadowed, mut asked) = (0, 0);
    for _ in 0..40_000 {
        let own = triangle(&mut random);
        let [a, b, c] = own.map(Vec3::as_dvec3);
        let size = own[0].distance(own[1]).max(own[0].distance(own[2]));
        let origin = (own[0] + random.point() * size * 3.0).as_dvec3();
        let target = a.lerp(b, f64::from(random.unit())).lerp(c, [0.0, 0.3][random.below(2)]);
        let ray = Ray::new(origin, target - origin);
        let Some(t) = referee::hit(&ray, own, true) else { continue };
        let position = match random.below(4) {
            0 => own[0] + (own[1] - own[0]) * 3.0,
            1 => own[random.below(3)] + random.point() * size * 1e6,
            _ => own[0] + random.point() * size * 3.0,
        };
        let light = match random.below(4) {
            0 => LightSource::Directional { direction: random.point().normalize_or(Vec3::X) },
            _ => LightSource::Point { position },
        };
        let other = other(&mut random, own, position);
        let found = ShadowRay::new(&light, HitPoint::new(&ray, t)).blocked_by(other).is_some();
        for sides in [Sides::Both, Sides::Front] {
            let expected = referee::Point::new(&ray, t).is_shadowed(&light, other, sides.has_back(0));
            let found = found && sides.stop_light(&light, 0, other);
            assert_eq!(found, expected, "{ray:?} at {t}, {light:?}, {other:?}, {sides:?}");
        }
        shadowed += u32::from(found);
        asked += 1;
    }
    assert!(asked > 20_000 && shadowed > asked / 20, "the test aims badly: {shadowed} of {asked} shadowed");
}

#[test]
fn however_the_corners_are_listed_the_crossing_is_the_same() {
    let mut random = Random::new(3);
    for _ in 0..2000 {
        let [a, b, c] = triangle(&mut random);
        let origin = (a + random.point()).as_dvec3();
        let ray = Ray::new(origin, a.lerp(b, 0.3).lerp(c, 0.3).as_dvec3() - origin);
        let Some(first) = crossing(&ray, [a, b, c]) else { continue };
        let [v, w] = first.barycentric;
        for (corners, front) in [([b, c, a], true), ([c, a, b], true), ([a, c, b], false), ([b, a, c], false)] {
            let other = crossing(&ray, corners).expect("the same triangle");
            assert_eq!(first.t.to_bits(), other.t.to_bits());
            assert_eq!(other.front == first.front, front);
        }
        let turned = crossing(&ray, [a, c, b]).expect("the same triangle");
        assert_eq!(turned.barycentric, [w, v]);
    }
}

#[test]
fn however_long_the_direction_the_crossing_is_at_the_same_place() {
    let mut random = Random::new(4);
    let mut near_edges = 0;
    for _ in 0..2000 {
        let corners = triangle(&mut random);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let origin = (corners[0] + random.point() * corners[0].distance(corners[1])).as_dvec3();
        // Close to an edge the filter decides some of the edge functions, and exact arithmetic the others.
        let inwards = [0.0, 1e-16, 1e-15, 1e-14, 0.2][random.below(5)];
        let mut direction = a.lerp(b, f64::from(random.unit())).lerp(c, inwards) - origin;
        if random.below(2) == 0 {
            // As little below a power of two as possible.
            let axis = direction.abs().max_position();
            direction /= direction[axis].abs();
            direction[axis] = direction[axis].signum() * 1.0_f64.next_down();
        }
        let at_scale = |exponent| crossing(&Ray::new(origin, direction * 2.0_f64.powi(exponent)), corners);
        let truth = at_scale(0).map(|crossing| crossing.barycentric);
        near_edges += u32::from(truth.is_some_and(|[v, w]| v.min(w).min(1.0 - v - w) < 1e-6));
        for exponent in [-600, -60, -1, 1, 60, 400] {
            let found = at_scale(exponent).map(|crossing| crossing.barycentric);
            assert_eq!(found, truth, "2^{exponent}: {origin} {direction} {corners:?}");
        }
    }
    assert!(near_edges > 200, "the test aims badly: {near_edges} near edges");
}

#[test]
fn the_front_is_where_corners_go_counterclockwise() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let from_front = Ray::new(DVec3::new(0.2, 0.2, 1.0), DVec3::NEG_Z);
    let from_back = Ray::new(DVec3::new(0.2, 0.2, -1.0), DVec3::Z);
    assert!(crossing(&from_front, corners).is_some_and(|crossing| crossing.front));
    assert!(crossing(&from_back, corners).is_some_and(|crossing| !crossing.front));
}

#[test]
fn what_is_not_a_triangle_is_never_crossed() {
    let ray = Ray::new(DVec3::new(0.1, 0.1, 1.0), DVec3::NEG_Z);
    let good = [Vec3::ZERO, Vec3::X, Vec3::Y];
    assert!(crossing(&ray, good).is_some());
    for corner in 0..3 {
        for axis in 0..3 {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut corners = good;
                corners[corner][axis] = value;
                assert!(crossing(&ray, corners).is_none(), "{corners:?}");
            }
        }
    }
    let point = Vec3::new(0.1, 0.1, 0.0);
    for corners in [[point; 3], [point, point, Vec3::X], [Vec3::ZERO, Vec3::X, Vec3::X * 2.0]] {
        assert!(crossing(&ray, corners).is_none(), "{corners:?}");
    }
    let edge_on = Ray::new(DVec3::new(-1.0, 0.25, 0.0), DVec3::X);
    assert!(crossing(&edge_on, good).is_none());
}
