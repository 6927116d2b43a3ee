use glam::Vec3;
use umbrage_papers::light_buffer::LightBuffer;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, LightSource, Ray, SingleRays as _};

use crate::support::{Mesh, Random, random_ray};

/// Number of points of random rays in shadow, for which the buffer agrees with the hierarchy, and of hidden entries.
fn check(mesh: &Mesh, light: Vec3, side: u32) -> [usize; 2] {
    let triangles = mesh.triangles();
    let mut hierarchy = Bvh::default();
    hierarchy.build(triangles);
    let buffer = LightBuffer::new(triangles, light, side, &|_| true);
    let mut random = Random(u64::from(side));
    let source = LightSource::Point { position: light };
    let mut shadowed = 0;
    for _ in 0..3000 {
        let ray: Ray = random_ray(&mut random, 2.0);
        let Some(hit) = hierarchy.nearest(triangles, &ray, &|_| true) else { continue };
        let shadow_ray = ShadowRay::new(&source, HitPoint::new(&ray, hit.t));
        let [of_buffer, of_hierarchy] = [
            buffer.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true),
            hierarchy.blocked(triangles, &shadow_ray, hit.triangle, &|_, _| true),
        ];
        assert_eq!(of_buffer, of_hierarchy, "{side} cells, light {light}, {ray:?}");
        shadowed += usize::from(of_buffer);
    }
    [shadowed, buffer.hidden()]
}

#[test]
fn points_are_shadowed_as_by_the_hierarchy() {
    let soup = Mesh::soup(&mut Random(1), 600, 0.4);
    let ball = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 25);
    let mut hidden = 0;
    for mesh in [&soup, &ball] {
        // Outside, inside, at a vertex, on an axis and far away.
        let lights =
            [Vec3::new(3.0, 2.0, -1.0), Vec3::new(0.1, 0.05, 0.02), mesh.positions[0], Vec3::X * 5.0, Vec3::ONE * 1e6];
        for light in lights {
            for side in [1, 7, 64] {
                let [shadowed, out_of_sight] = check(mesh, light, side);
                assert!(shadowed > 100 || light.length() < 1.1, "{light}: {shadowed}");
                hidden += out_of_sight;
            }
        }
    }
    assert!(hidden > 1000, "{hidden}");
}

#[test]
fn nothing_and_what_is_not_a_triangle_are_listed_nowhere() {
    let nothing = Mesh::soup(&mut Random(2), 0, 1.0);
    assert!(LightBuffer::new(nothing.triangles(), Vec3::ZERO, 4, &|_| true).is_empty());
    let mut broken = Mesh::soup(&mut Random(3), 1, 1.0);
    broken.positions[0].x = f32::NAN;
    let buffer = LightBuffer::new(broken.triangles(), Vec3::ZERO, 4, &|_| true);
    assert!(buffer.is_empty() && buffer.bytes() > 0);
}
