//! Scenes that one far vertex stretches, or that one triangle covers.

use glam::{DVec3, Vec3};
use umbrage_rays::{Bvh, Hit, Ray, SingleRays as _};

use crate::support::far::check_answers;
use crate::support::{Mesh, Random, nearest_of_all};

#[test]
fn answers_are_the_predicates() {
    check_answers(Bvh::default());
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
