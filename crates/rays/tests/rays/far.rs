//! Scenes that one far vertex stretches, or that one triangle covers: they cost as much as ordinary ones.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::hit;
use umbrage_rays::{Bvh, Choice as _, Hit, KdBuilder, KdTree, KdTreeOptions, Ray, SingleRays as _, Visit};

use crate::support::far::{check_answers, damaged, ordinary, rays};
use crate::support::{Mesh, Random, nearest_of_all};

/// Counts the triangles that rays are tested against.
fn tests(structure: &impl Visit, mesh: &Mesh, rays: &[Ray]) -> usize {
    let triangles = mesh.triangles();
    let mut count = 0;
    for ray in rays {
        let _ = structure.visit(triangles, ray, |id, t_max| {
            count += 1;
            if let Some(hit) = hit(ray, triangles, id) {
                *t_max = t_max.min(hit.t);
            }
            ControlFlow::Continue(())
        });
    }
    count
}

fn tree(builder: KdBuilder, mesh: &Mesh) -> KdTree {
    let mut tree = KdTree::default();
    tree.set_options(KdTreeOptions { builder, ..KdTreeOptions::FAST }).expect("possible options");
    tree.build(mesh.triangles());
    tree.check(mesh.triangles()).expect("a valid tree");
    tree
}

#[test]
fn rays_are_tested_against_hardly_more_triangles() {
    let (rays, ordinary) = (rays(), ordinary());
    use KdBuilder::{Naive, SpatialInTurn, SpatialMedian};
    // Planes in the middle of space take a level for each power of two before they come near the other triangles.
    let builders = KdBuilder::all().filter(|builder| ![Naive, SpatialMedian, SpatialInTurn].contains(builder));
    for builder in builders {
        let usual = tests(&tree(builder, &ordinary), &ordinary, &rays);
        for (name, mesh) in damaged() {
            let count = tests(&tree(builder, &mesh), &mesh, &rays);
            // Far triangles are in many leaves: those of a vertex are six.
            let most = 4 * usual + 30 * 6 * rays.len();
            assert!(count < most, "{builder}: {name}: {count} tests instead of {usual}, of {}", mesh.indices.len());
        }
    }
}

#[test]
fn answers_are_the_predicates() {
    check_answers(Bvh::default());
    let mut tree = KdTree::default();
    tree.set_options(KdTreeOptions { builder: KdBuilder::Binned, ..KdTreeOptions::FAST }).expect("possible options");
    check_answers(tree);
}

#[test]
fn packets_hit_what_the_predicate_says() {
    let rays = rays();
    for (name, mesh) in damaged() {
        let triangles = mesh.triangles();
        let mut packet = vec![None; rays.len()];
        tree(KdBuilder::Binned, &mesh).nearest_of_packet(triangles, &rays, |_| true, &mut packet);
        let expected: Vec<Option<Hit>> = rays.iter().map(|ray| nearest_of_all(triangles, ray, |_| true)).collect();
        assert_eq!(packet, expected, "{name}");
    }
}

#[test]
fn a_far_hit_is_found_behind_near_ones() {
    // From inside a huge tetrahedron, past a ball.
    let (distance, mut mesh) = (1e20, Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    let corners =
        [Vec3::new(1.0, 1.0, 1.0), Vec3::new(-1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, -1.0, -1.0)];
    let [a, b, c, d] = corners.map(|corner| corner * distance);
    [[a, b, c], [a, b, d], [a, c, d], [b, c, d]].into_iter().for_each(|corners| mesh.push(corners));
    let triangles = mesh.triangles();
    let mut bvh = Bvh::default();
    bvh.build(triangles);
    let mut random = Random(43);
    let mut far = 0;
    for _ in 0..200 {
        let ray = Ray::new((random.point() * 2.0).as_dvec3(), random.point().as_dvec3());
        let expected = nearest_of_all(triangles, &ray, |_| true);
        assert_eq!(bvh.nearest(triangles, &ray, &|_| true), expected);
        far += usize::from(expected.is_some_and(|hit| hit.t > 1e15));
        let near_only = |hit: &Hit| hit.t < 1e15;
        assert_eq!(bvh.nearest(triangles, &ray, &near_only), nearest_of_all(triangles, &ray, near_only));
    }
    assert!(far > 100, "{far}");
    assert!(bvh.nearest(triangles, &Ray::new(DVec3::splat(0.1), DVec3::X), &|_| true).is_some());
}
