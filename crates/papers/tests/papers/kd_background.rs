//! The kd-tree that is built beside tracing, frame after frame, against the predicate asked about every triangle.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_papers::{BackgroundKdTree, ImpossibleBackground, KdBuilder, KdLayout, KdTreeOptions, RebuildPolicy};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray, SingleRays as _, Structure as _, Triangles};

use crate::support::{self, Mesh, Random, blocked_by_any, nearest_of_all as nearest};

/// Uses the first tree for all frames of the same triangles.
const NEVER: RebuildPolicy = RebuildPolicy { rebuild_above: f64::INFINITY, wait_above: f64::INFINITY };
/// Begins a tree for every frame, if none is being built, and waits for none.
const ALWAYS: RebuildPolicy = RebuildPolicy { rebuild_above: 1.0, wait_above: f64::INFINITY };

fn rest(random: &mut Random) -> Mesh {
    let mut mesh = Mesh::soup(random, 60, 0.02);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 12));
    mesh.append(&Mesh::floor(5, 3.0));
    mesh.positions[5].x = f32::NAN;
    mesh.indices.push([0, 1, u32::MAX]);
    mesh.indices.push([7, 7, 8]);
    mesh
}

/// The scene at a time: a part stays, a part waves, and some triangles fly apart.
fn at(rest: &Mesh, time: f32) -> Mesh {
    let mut mesh = rest.clone();
    for (vertex, position) in mesh.positions.iter_mut().enumerate() {
        if position.y > -0.2 {
            *position += Vec3::new(0.0, 0.2, 0.1) * (position.x * 3.0 + time * 2.0).sin() * time;
        }
        if vertex < 60 {
            *position *= 1.0 + time;
        }
    }
    if time > 0.15 {
        mesh.positions[80].z = f32::INFINITY;
    }
    mesh
}

fn check(tree: &BackgroundKdTree, triangles: Triangles<'_>, rays: &[Ray]) -> usize {
    tree.check(triangles).unwrap_or_else(|broken| panic!("{broken}"));
    assert_eq!(tree.omitted(), &triangles.omitted());
    let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric));
    let is_hit = rays.par_iter().map(|ray| {
        let expected = nearest(triangles, ray, |_| true);
        assert_eq!(bits(&tree.nearest(triangles, ray, &|_| true)), bits(&expected), "{ray:?} through {tree:?}");
        expected.is_some()
    });
    is_hit.filter(|is_hit| *is_hit).count()
}

/// Rays from anywhere, along axes, and grazing.
fn rays(triangles: Triangles<'_>, random: &mut Random) -> Vec<Ray> {
    let mut rays = support::grazing_rays(triangles, random, 40);
    for step in 0..100 {
        let [origin, to] = [random.point() * 4.0, random.point() * 1.5].map(Vec3::as_dvec3);
        rays.push(Ray::new(origin, to - origin));
        let axis = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z][step % 6];
        rays.push(Ray::new(to - axis * 4.0, axis));
        rays.push(Ray { t_min: -1.0, t_max: 0.3, ..Ray::new(to, axis + to * 1e-9) });
    }
    rays.push(Ray::new(DVec3::ZERO, DVec3::new(1e-320, 1.0, 1e-310)));
    rays
}

fn with(options: KdTreeOptions, policy: RebuildPolicy) -> BackgroundKdTree {
    let mut tree = BackgroundKdTree::new(1).expect("a thread");
    tree.set_options(options).expect("possible options");
    tree.set_policy(policy).expect("a possible policy");
    tree
}

#[test]
fn trees_of_any_age_lead_to_what_the_predicate_says() {
    let mut random = Random(61);
    let rest = rest(&mut random);
    for options in [
        KdTreeOptions::DEFAULT,
        KdTreeOptions {
            builder: KdBuilder::Binned,
            layout: KdLayout::Subtrees,
            lazy_below: 100,
            ..KdTreeOptions::DEFAULT
        },
        // Children before their parents.
        KdTreeOptions { layout: KdLayout::Scattered, ..KdTreeOptions::DEFAULT },
    ] {
        for policy in [NEVER, ALWAYS, RebuildPolicy::DEFAULT] {
            let mut tree = with(options, policy);
            let mut hits = 0;
            for step in 0..8 {
                let mesh = at(&rest, step as f32 * 0.05);
                let age = tree.advance(mesh.triangles());
                assert!(age.cost_ratio >= 1.0 && age.cost_ratio <= policy.wait_above, "{age:?}");
                assert!(step > 0 || (age.frames == 0 && age.has_waited && age.cost_ratio == 1.0), "{age:?}");
                if policy == NEVER {
                    assert!(age.frames == step && age.has_waited == (step == 0) && !age.is_building, "{age:?}");
                    assert!(step == 0 || age.cost_ratio > 1.0 + 0.05 * f64::from(step), "{age:?}");
                }
                hits += check(&tree, mesh.triangles(), &rays(mesh.triangles(), &mut random));
            }
            assert!(hits > 1000, "{hits}");
        }
    }
}

/// Moves by less than a triangle's size leave cells that rays must still find from beside them.
#[test]
fn small_and_far_moves_are_followed() {
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 24);
    let mut tree = with(KdTreeOptions::DEFAULT, NEVER);
    tree.advance(ball.triangles());
    for by in [1e-7, 1e-4, 1e-2, 0.3, 50.0] {
        let mut random = Random(62);
        let mut mesh = ball.clone();
        mesh.positions.iter_mut().for_each(|position| *position += random.point() * by);
        tree.advance(mesh.triangles());
        let rays: Vec<_> = (0..2000)
            .map(|step| {
                let target = mesh.triangles().corners((step % mesh.indices.len()) as u32)[step / 7 % 3].as_dvec3();
                Ray::new(target + random.point().as_dvec3() * 3.0, random.point().as_dvec3() * 1e-9 - target)
            })
            .map(|ray| Ray { direction: ray.origin * -0.1 + ray.direction, ..ray })
            .collect();
        check(&tree, mesh.triangles(), &rays);
        let to_corners: Vec<_> = (0..2000)
            .map(|step| {
                let target = mesh.triangles().corners((step * 3 % mesh.indices.len()) as u32)[step / 7 % 3].as_dvec3();
                let origin = target * 2.0 + random.point().as_dvec3();
                Ray::new(origin, target - origin)
            })
            .collect();
        assert!(check(&tree, mesh.triangles(), &to_corners) > 1000);
    }
}

#[test]
fn points_are_shadowed_and_hits_pass_through() {
    let mut random = Random(63);
    let rest = rest(&mut random);
    let mut tree = with(KdTreeOptions::DEFAULT, NEVER);
    let lights = [
        LightSource::Point { position: Vec3::new(3.0, 5.0, 2.0) },
        LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize() },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let (mut lit, mut shadowed) = (0, 0);
    for time in [0.0, 0.1, 0.3] {
        let mesh = at(&rest, time);
        let triangles = mesh.triangles();
        tree.advance(triangles);
        for (step, ray) in rays(triangles, &mut random).iter().enumerate() {
            let counts = |hit: &Hit| hit.triangle % 3 < 2 && hit.barycentric[0] < 0.7;
            let seen = nearest(triangles, ray, counts);
            assert_eq!(tree.nearest(triangles, ray, &counts), seen, "{ray:?}");
            let Some(seen) = seen else { continue };
            let shadow_ray = ShadowRay::new(&lights[step % 3], HitPoint::new(ray, seen.t));
            let counts = |id: u32, barycentric: [f32; 2]| !id.is_multiple_of(5) || barycentric[1] < 0.5;
            let expected = blocked_by_any(triangles, &shadow_ray, seen.triangle, counts);
            assert_eq!(tree.blocked(triangles, &shadow_ray, seen.triangle, &counts), expected, "{ray:?}");
            if expected { shadowed += 1 } else { lit += 1 }
        }
    }
    assert!(lit > 100 && shadowed > 100, "{lit} {shadowed}");
}

#[test]
fn newer_trees_come_while_frames_go_on() {
    let mut random = Random(64);
    let rest = rest(&mut random);
    let mut tree = with(KdTreeOptions::DEFAULT, ALWAYS);
    let mut came = 0;
    let mut last = 0;
    for step in 0..2000 {
        let mesh = at(&rest, 0.01 * (step % 40) as f32);
        let age = tree.advance(mesh.triangles());
        assert!(age.has_waited == (step == 0), "{age:?}");
        assert!(age.is_building || age.cost_ratio == 1.0, "{age:?}");
        if age.frames <= last && step > 0 {
            came += 1;
            check(&tree, mesh.triangles(), &rays(mesh.triangles(), &mut random));
        }
        last = age.frames;
        if came == 5 {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    panic!("{came} trees came");
}

#[test]
fn frames_wait_where_the_tree_is_of_other_triangles_or_too_costly() {
    let mut random = Random(65);
    let rest = rest(&mut random);
    let mut tree = with(KdTreeOptions::DEFAULT, NEVER);
    let mut check = |tree: &BackgroundKdTree, mesh: &Mesh| {
        check(tree, mesh.triangles(), &rays(mesh.triangles(), &mut random));
    };
    let mut mesh = rest.clone();
    assert!(tree.advance(mesh.triangles()).has_waited);
    assert!(!tree.advance(mesh.triangles()).has_waited);
    type Change = fn(&mut Mesh);
    let changes: [(Change, bool); 5] = [
        (|mesh| mesh.indices.swap(3, 4), true),
        (|mesh| mesh.positions.push(Vec3::ONE), true),
        (|mesh| mesh.positions[5].x = 0.3, true),
        (|mesh| mesh.positions[5].x = f32::NAN, false),
        (|mesh| *mesh = Mesh::default(), true),
    ];
    for (place, (change, waits)) in changes.into_iter().enumerate() {
        change(&mut mesh);
        assert_eq!(tree.advance(mesh.triangles()).has_waited, waits, "change {place}");
        if !mesh.indices.is_empty() {
            check(&tree, &mesh);
        }
        assert!(!tree.advance(mesh.triangles()).has_waited, "change {place}");
    }
    assert_eq!(tree.nearest(mesh.triangles(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    // All positions change while a tree is being built that is no better.
    let policy = RebuildPolicy { rebuild_above: 1.0, wait_above: 1.5 };
    tree.set_policy(policy).expect("a possible policy");
    tree.advance(rest.triangles());
    for time in [0.01, 3.0, 3.01, 0.0] {
        let mesh = at(&rest, time);
        let age = tree.advance(mesh.triangles());
        assert!(age.cost_ratio <= policy.wait_above && (age.has_waited || time != 3.0), "{age:?}");
        check(&tree, &mesh);
    }
}

#[test]
fn impossible_policies_are_refused() {
    let mut tree = BackgroundKdTree::new(2).expect("threads");
    assert_eq!(tree.nearest(Triangles::default(), &Ray::new(DVec3::ZERO, DVec3::X), &|_| true), None);
    for (rebuild_above, wait_above) in [(0.9, 2.0), (3.0, 2.0), (f64::NAN, 2.0), (1.0, f64::NAN)] {
        let policy = RebuildPolicy { rebuild_above, wait_above };
        let error = tree.set_policy(policy).unwrap_err();
        assert!(
            matches!(error, ImpossibleBackground::Policy(_)) && error.to_string().contains("can't be rebuilt above")
        );
    }
    assert!(tree.set_options(KdTreeOptions { lazy_below: u32::MAX, ..KdTreeOptions::DEFAULT }).is_err());
}
