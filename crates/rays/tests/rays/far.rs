//! Scenes that one far vertex stretches, or that one triangle covers: they cost as much as ordinary ones.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay, hit};
use umbrage_rays::{
    Bvh, Choice as _, Hit, KdBuilder, KdTree, KdTreeOptions, LightSource, Ray, SingleRays, UniformGrid, Visit,
};

use crate::support::{Mesh, Random, blocked_by_any, nearest_of_all};

/// A ball and small triangles around it.
fn ordinary() -> Mesh {
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40);
    mesh.append(&Mesh::soup(&mut Random(41), 400, 0.01));
    mesh
}

/// The same scene with a far vertex of the ball, with several at different distances, or with a triangle that covers all.
fn damaged() -> Vec<(String, Mesh)> {
    let directions = [Vec3::NEG_X, Vec3::new(0.3, -1.0, 0.2), Vec3::new(1.0, -0.9, 1.1)];
    let mut all = Vec::new();
    for (step, distance) in [1e6, 1e12, 1e13, 1.5e25, 1e30, 1e37].into_iter().enumerate() {
        let mut mesh = ordinary();
        mesh.positions[500] = directions[step % 3] * distance;
        all.push((format!("a vertex {distance} away"), mesh));
        let mut mesh = ordinary();
        let [a, b, c] = [Vec3::new(-3.0, -4.0, 1.0), Vec3::new(4.0, -3.0, 2.0), Vec3::new(-1.0, 5.0, 1.5)];
        mesh.push([a, b, c].map(|corner| corner * distance));
        all.push((format!("a triangle of {distance}"), mesh));
    }
    let mut mesh = ordinary();
    for (step, distance) in [1e4, 1e9, 1e15, 1e20, 1e28].into_iter().enumerate() {
        mesh.positions[300 + 40 * step] = directions[step % 3] * distance;
    }
    all.push(("vertices at five distances".to_owned(), mesh));
    // A far triangle that can't be hit.
    let mut mesh = ordinary();
    mesh.push([Vec3::X * 1e30; 3]);
    all.push(("a far triangle without an area".to_owned(), mesh));
    all
}

fn rays() -> Vec<Ray> {
    let mut random = Random(42);
    let ray = |_| {
        let origin = (random.point() * 4.0).as_dvec3();
        Ray::new(origin, (random.point() * 1.2).as_dvec3() - origin)
    };
    (0..150).map(ray).collect()
}

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
    let rays = rays();
    let light = LightSource::Point { position: Vec3::new(2.0, 3.0, -1.0) };
    for (name, mesh) in damaged() {
        let triangles = mesh.triangles();
        let mut bvh = Bvh::default();
        bvh.build(triangles);
        bvh.check(triangles).expect("a sound hierarchy");
        let mut grid = UniformGrid::default();
        grid.build(triangles);
        let tree = tree(KdBuilder::Binned, &mesh);
        let structures: [(&str, &dyn SingleRays); 3] = [("hierarchy", &bvh), ("kd-tree", &tree), ("grid", &grid)];
        let mut packet = vec![None; rays.len()];
        tree.nearest_of_packet(triangles, &rays, |_| true, &mut packet);
        let expected: Vec<Option<Hit>> = rays.iter().map(|ray| nearest_of_all(triangles, ray, |_| true)).collect();
        assert_eq!(packet, expected, "packets, {name}");
        for (structure, rays_of) in structures {
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(rays_of.nearest(triangles, ray, &|_| true), *expected, "{structure}, {name}, {ray:?}");
                let Some(hit) = expected else { continue };
                let shadow_ray = ShadowRay::new(&light, HitPoint::new(ray, hit.t));
                let blocked = blocked_by_any(triangles, &shadow_ray, hit.triangle, |_, _| true);
                let found = rays_of.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true);
                assert_eq!(found, blocked, "{structure}, {name}, {ray:?}");
            }
        }
        assert!(expected.iter().flatten().count() > 50, "{name}");
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
