//! kd-trees whose subtrees are built when a ray first reaches them, against those that are built at once.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_papers::{KdBuilder, KdPacketOptions, KdPacketWidth, KdTree, KdTreeCounts, KdTreeOptions};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Choice as _, LightSource, Ray, SingleRays as _, Structure as _, Triangles};

use crate::support::{self, Mesh, Random};

const BUILDERS: [KdBuilder; 5] =
    [KdBuilder::Resorting, KdBuilder::Presorted, KdBuilder::Binned, KdBuilder::Streaming, KdBuilder::Adaptive];

fn scene() -> Mesh {
    let mut random = Random(31);
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 60);
    mesh.append(&Mesh::soup(&mut random, 2000, 0.01));
    mesh.positions[5].x = f32::NAN;
    mesh
}

fn tree(triangles: Triangles<'_>, options: KdTreeOptions) -> KdTree {
    let mut tree = KdTree::default();
    tree.set_options(options).expect("possible options");
    tree.build(triangles);
    tree.check(triangles).unwrap_or_else(|broken| panic!("{options:?}: {broken}"));
    tree
}

fn pair(triangles: Triangles<'_>, builder: KdBuilder, lazy_below: u32) -> [KdTree; 2] {
    [0, lazy_below].map(|lazy_below| tree(triangles, KdTreeOptions { builder, lazy_below, ..KdTreeOptions::DEFAULT }))
}

/// Rays that go through the whole scene.
fn rays(count: usize) -> Vec<Ray> {
    let mut random = Random(32);
    let mut ray = || {
        let [origin, to] = [random.point() * 4.0, random.point() * 1.5].map(Vec3::as_dvec3);
        Ray::new(origin, to - origin)
    };
    (0..count).map(|_| ray()).collect()
}

#[test]
fn what_all_rays_reach_is_the_tree_that_is_built_at_once() {
    let mesh = scene();
    let triangles = mesh.triangles();
    for builder in BUILDERS {
        for lazy_below in [40, KdTreeOptions::MOST_LAZY] {
            let [eager, lazy] = pair(triangles, builder, lazy_below);
            let before = lazy.counts();
            assert!(before.deferred > 0 && before.reached == 0, "{builder:?}: {before:?}");
            assert!(before.nodes * 3 < eager.counts().nodes * 2, "{builder:?}: {before:?}");
            // Without a nearest hit, rays go on to the end.
            let visit = |ray: &Ray| assert_eq!(lazy.nearest(triangles, ray, &|_| false), None);
            rays(3000).iter().for_each(visit);
            for id in (0..triangles.len() as u32).filter(|&id| support::is_usable(triangles, id)) {
                let [a, b, c] = triangles.corners(id).map(Vec3::as_dvec3);
                let center = (a + b + c) / 3.0;
                visit(&Ray::new(center - DVec3::new(0.3, 0.4, 0.5), DVec3::new(0.3, 0.4, 0.5)));
            }
            lazy.check(triangles).expect("a valid tree");
            let KdTreeCounts { deferred, reached, .. } = lazy.counts();
            // Empty cells may be left.
            assert!(reached <= deferred && reached * 20 >= deferred * 19, "{builder:?}: {reached} of {deferred}");
            if reached == deferred {
                assert_eq!(KdTreeCounts { deferred: 0, reached: 0, ..lazy.counts() }, eager.counts(), "{builder:?}");
            } else {
                assert!(lazy.counts().leaves <= eager.counts().leaves);
            }
        }
    }
}

#[test]
fn only_what_rays_look_at_is_built() {
    let mesh = scene();
    let [eager, lazy] = pair(mesh.triangles(), KdBuilder::Presorted, 200);
    let before = lazy.bytes().triangles;
    for ray in &rays(10) {
        assert_eq!(lazy.nearest(mesh.triangles(), ray, &|_| true), eager.nearest(mesh.triangles(), ray, &|_| true));
    }
    let KdTreeCounts { deferred, reached, .. } = lazy.counts();
    assert!(reached > 0 && reached * 3 < deferred, "{reached} of {deferred}");
    assert!(lazy.bytes().triangles > before);
}

#[test]
fn threads_that_come_together_get_the_same_answers() {
    let mesh = scene();
    let triangles = mesh.triangles();
    let rays = rays(3000);
    let light = LightSource::Point { position: Vec3::new(0.2, 3.0, 0.5) };
    for builder in [KdBuilder::Presorted, KdBuilder::Binned] {
        let [eager, lazy] = pair(triangles, builder, 1000);
        let answer = |tree: &KdTree, ray: &Ray| {
            let hit = tree.nearest(triangles, ray, &|hit| !hit.triangle.is_multiple_of(3))?;
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(ray, hit.t));
            Some((hit, tree.blocked(triangles, &shadow_ray, hit.triangle, &|id, _| id % 5 > 0)))
        };
        let expected: Vec<_> = rays.iter().map(|ray| answer(&eager, ray)).collect();
        assert!(expected.iter().flatten().count() > 1000);
        let mut reached = Vec::new();
        let mut fresh = lazy;
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                fresh.build(triangles);
                let found: Vec<_> = rays.par_iter().with_max_len(8).map(|ray| answer(&fresh, ray)).collect();
                assert!(found == expected, "{builder:?} on {threads} threads");
            });
            fresh.check(triangles).expect("a valid tree");
            reached.push(fresh.counts());
        }
        assert!(reached.iter().all(|counts| *counts == reached[0]), "{reached:?}");
    }
}

#[test]
fn the_way_of_traversing_may_change_while_subtrees_wait() {
    use umbrage_papers::KdTraversal::{PushDown, Restart, ShortStack, Stack};
    let mesh = scene();
    let [eager, mut lazy] = pair(mesh.triangles(), KdBuilder::Streaming, 500);
    for (step, ray) in rays(400).iter().enumerate() {
        let traversal = [Stack, Restart, PushDown, ShortStack(2)][step % 4];
        // The builder of the next build doesn't matter to this tree.
        let options = KdTreeOptions { traversal, builder: KdBuilder::Binned, ..lazy.options() };
        lazy.set_options(options).expect("possible options");
        assert_eq!(lazy.nearest(mesh.triangles(), ray, &|_| true), eager.nearest(mesh.triangles(), ray, &|_| true));
    }
    lazy.check(mesh.triangles()).expect("a valid tree");
}

/// Calls `each` with both trees for each traversal and each width of packets.
fn packets_through(trees: &mut [KdTree; 2], mut each: impl FnMut(&mut [KdTree; 2], KdTreeOptions)) {
    use umbrage_papers::KdTraversal::{PushDown, Restart, ShortStack, Stack};
    for traversal in [Stack, Restart, PushDown, ShortStack(3)] {
        for width in KdPacketWidth::all() {
            let packets = KdPacketOptions { width, ..KdPacketOptions::DEFAULT };
            let options = trees.each_ref().map(|tree| KdTreeOptions { traversal, packets, ..tree.options() });
            for (tree, options) in trees.iter_mut().zip(options) {
                tree.set_options(options).expect("possible options");
            }
            each(trees, options[1]);
        }
    }
}

#[test]
fn packets_build_what_they_reach() {
    let mesh = scene();
    let triangles = mesh.triangles();
    let (rays, light) = (rays(200), LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.2) });
    for builder in [KdBuilder::Presorted, KdBuilder::Binned] {
        let mut trees = pair(triangles, builder, 300);
        packets_through(&mut trees, |trees, options| {
            trees[1].build(triangles);
            let mut hits = [vec![None; rays.len()], vec![None; rays.len()]];
            for (tree, hits) in trees.iter().zip(&mut hits) {
                tree.nearest_of_packet(triangles, &rays, |hit| !hit.triangle.is_multiple_of(7), hits);
            }
            assert_eq!(hits[1], hits[0], "{options:?}");
            let KdTreeCounts { deferred, reached, .. } = trees[1].counts();
            assert!(reached > 10 && reached < deferred, "{reached} of {deferred}, {options:?}");
            let seen: Vec<_> = rays.iter().zip(&hits[0]).filter_map(|(ray, hit)| Some((ray, (*hit)?))).collect();
            let shadow_rays: Vec<_> =
                seen.iter().map(|(ray, hit)| ShadowRay::new(&light, HitPoint::new(ray, hit.t))).collect();
            let own: Vec<_> = seen.iter().map(|(_, hit)| hit.triangle).collect();
            let blocked = trees.each_ref().map(|tree| {
                let mut blocked = vec![false; own.len()];
                tree.blocked_of_packet(triangles, &shadow_rays, &own, |_, _| true, &mut blocked);
                blocked
            });
            assert!(blocked[1] == blocked[0] && blocked[0].contains(&true) && blocked[0].contains(&false));
            trees[1].check(triangles).expect("a valid tree");
        });
    }
}

#[cfg(feature = "statistics")]
#[test]
fn packets_take_the_same_steps_through_subtrees_as_through_one_tree() {
    let mesh = scene();
    let rays = rays(500);
    packets_through(&mut pair(mesh.triangles(), KdBuilder::Presorted, 300), |trees, options| {
        let [eager, lazy] = trees.each_ref().map(|tree| {
            tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut vec![None; rays.len()]);
            tree.take_visits()
        });
        assert!(eager == lazy && eager.nodes > 1000, "{options:?}: {eager:?}, {lazy:?}");
    });
}

#[cfg(feature = "statistics")]
#[test]
fn visits_of_subtrees_count() {
    let mesh = scene();
    let [eager, lazy] = pair(mesh.triangles(), KdBuilder::Presorted, 1000);
    let [expected, found] = [&eager, &lazy].map(|tree| {
        let hits = rays(300).iter().filter(|ray| tree.nearest(mesh.triangles(), ray, &|_| true).is_some()).count();
        assert!(hits > 100);
        tree.take_visits()
    });
    assert!(found.rays == expected.rays && found.tests >= expected.tests, "{found:?} {expected:?}");
    assert!(
        found.nodes * 10 >= expected.nodes * 9 && found.nodes * 10 <= expected.nodes * 11,
        "{found:?} {expected:?}"
    );
    assert_eq!(lazy.take_visits(), umbrage_rays::Counts::default());
}
