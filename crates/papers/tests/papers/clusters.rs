//! Clusters of triangles that move together, and fuzzy kd-trees of these.

use glam::{Quat, Vec3};
use umbrage_papers::clusters::{ClusterOptions, clusters};
use umbrage_papers::{KdMoved, TwoLevelKdTree};
use umbrage_rays::{Parts, Ray, SingleRays as _, Structure as _};

use crate::support::{Mesh, Random, nearest_of_all};

/// Three balls: one stays, one turns and flies, one breathes a little while it turns.
fn at(time: f32) -> Mesh {
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 0.5, 10);
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 1.0, -0.5).normalize(), time);
    let mut second = Mesh::bumpy_ball(Vec3::ZERO, 0.4, 10);
    second.positions.iter_mut().for_each(|at| *at = turn * *at + Vec3::X * (1.0 + time));
    let mut third = Mesh::bumpy_ball(Vec3::ZERO, 0.4, 10);
    for at in &mut third.positions {
        *at = turn.inverse() * (*at * (1.0 + 0.01 * (time * 3.0 + at.x * 5.0).sin())) + Vec3::Y * 2.0;
    }
    mesh.append(&second);
    mesh.append(&third);
    mesh
}

#[test]
fn what_moves_together_is_found_and_its_boxes_are_enough() {
    let poses: Vec<_> = (0..8).map(|step| at(step as f32 * 0.3).positions).collect();
    let mesh = at(0.0);
    let options = ClusterOptions { residual: 0.05, ..ClusterOptions::default() };
    let of_triangle = clusters(&mesh.indices, &poses, options);
    let ball = mesh.indices.len() / 3;
    let mut parts: Vec<_> = of_triangle.chunks(ball).map(|part| part[0]).collect();
    assert!(of_triangle.chunks(ball).all(|part| part.iter().all(|cluster| *cluster == part[0])), "{of_triangle:?}");
    parts.sort_unstable();
    assert_eq!(parts, [0, 1, 2]);

    let mut random = Random(81);
    let mut trees = TwoLevelKdTree::new(KdMoved::Enclose);
    let parts = Parts { of_triangle: &of_triangle, objects: &[] };
    trees.prepare(mesh.triangles(), parts, &poses);
    for step in 0..15 {
        let mesh = at(step as f32 * 0.15);
        trees.build_parts(mesh.triangles(), parts);
        assert_eq!(trees.check(mesh.triangles()), Ok(()));
        assert!(trees.counts().rebuilt <= 1 && trees.counts().objects == 3, "{step}: {:?}", trees.counts());
        for _ in 0..300 {
            let [from, to] = [random.point() * 4.0, random.point()].map(Vec3::as_dvec3);
            let ray = Ray::new(from, to - from);
            let expected = nearest_of_all(mesh.triangles(), &ray, |_| true);
            assert_eq!(trees.nearest(mesh.triangles(), &ray, &|_| true), expected);
        }
    }
}

#[test]
fn few_clusters_are_used_where_few_are_allowed_or_needed() {
    let still = at(0.0);
    let poses = [still.positions.clone(), still.positions.clone()];
    assert!(clusters(&still.indices, &poses, ClusterOptions::default()).iter().all(|cluster| *cluster == 0));
    assert!(clusters(&[], &[Vec::new()], ClusterOptions::default()).is_empty());
    let mut poses: Vec<_> = (0..4).map(|step| at(step as f32 * 0.5).positions).collect();
    poses[2][3] = Vec3::NAN;
    let two = clusters(&still.indices, &poses, ClusterOptions { most: 2, ..ClusterOptions::default() });
    assert_eq!(two.iter().max(), Some(&1));
}
