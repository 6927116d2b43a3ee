//! Rigid instances with ids and transforms, and their hits.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use umbrage_rays::predicate::hit;
use umbrage_rays::{Ray, Triangles};
use umbrage_scene::{BadInstance, Frame, Instances, Scene};

/// The nearest hit among a few triangles, by brute force.
fn nearest(triangles: Triangles<'_>, ray: &Ray) -> Option<umbrage_rays::Hit> {
    let hits = (0..triangles.len() as u32).filter_map(|id| hit(ray, triangles, id));
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// The hit of a ray parallel to the z axis, downwards.
fn above(instances: &Instances, x: f64, y: f64) -> Option<(String, u32, DVec3)> {
    let ray = Ray::new(DVec3::new(x, y, 50.0), DVec3::NEG_Z);
    let there = instances.hit(&nearest(instances.triangles(), &ray)?);
    Some((instances.all()[there.instance as usize].name().to_owned(), there.triangle, there.position))
}

/// A square of two triangles, of two objects where they have names.
fn square(names: &[&str]) -> Scene {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mut frame = Frame::from_triangles(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let objects = &mut Arc::make_mut(&mut frame.mesh).objects;
    names.iter().enumerate().for_each(|(triangle, name)| objects.begin(triangle, name));
    Scene::new(Box::new(frame)).unwrap()
}

#[test]
fn what_shares_vertices_is_in_the_world() {
    let mut instances = Instances::of_scene(&square(&["right", "left"]), 0.0).unwrap();
    assert_eq!(above(&instances, 1.0, 3.0), Some(("left".into(), 0, DVec3::new(1.0, 3.0, 0.0))));
    instances.set_transform(1, DAffine3::from_translation(DVec3::X * 100.0));
    assert_eq!(above(&instances, 3.0, 1.0), Some(("right".into(), 0, DVec3::new(3.0, 1.0, 0.0))));
    assert_eq!(above(&instances, 1.0, 3.0), None);
    assert_eq!(above(&instances, 101.0, 3.0), Some(("left".into(), 0, DVec3::new(1.0, 3.0, 0.0))));
    let whole = Instances::of_scene(&square(&[]), 0.0).unwrap();
    assert_eq!(above(&whole, 1.0, 3.0), Some(("scene".into(), 1, DVec3::new(1.0, 3.0, 0.0))));
}

#[test]
fn added_meshes_move_as_they_are_told() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut instances = Instances::default();
    let ids = ["a", "empty", "b"].map(|name| {
        let triangles: &[[u32; 3]] = if name == "empty" { &[] } else { &[[0, 1, 2], [2, 1, 0]] };
        instances.add(name, &corners, triangles).unwrap()
    });
    assert_eq!(ids, [0, 1, 2]);
    assert_eq!([0, 1, 2, 3].map(|id| instances.of_triangle(id)), [[0, 0], [0, 1], [2, 0], [2, 1]]);
    // Turned, so that x goes along y, then moved; then its vertices are updated.
    let turned = DMat3::from_rotation_z(FRAC_PI_2);
    instances.set_transform(2, DAffine3 { matrix3: turned, translation: DVec3::new(0.0, 10.0, 0.0) });
    instances.update(2, &corners.map(|corner| corner * 2.0));
    let (name, triangle, position) = above(&instances, -0.5, 10.25).unwrap();
    assert_eq!((name.as_str(), triangle), ("b", 0));
    assert!(position.distance(DVec3::new(0.25, 0.5, 0.0)) < 1e-6, "{position}");
    // The new transform replaces the last one.
    instances.set_transform(2, DAffine3::from_translation(DVec3::X * 5.0));
    assert_eq!(above(&instances, 5.25, 0.5), Some(("b".into(), 0, DVec3::new(0.25, 0.5, 0.0))));
    assert_eq!(instances.all()[2].vertices(), 3);
    assert_eq!(instances.add("c", &corners, &[[0, 1, 3]]), Err(BadInstance::Index { index: 3, vertices: 3 }));
    assert_eq!(instances.all().len(), 3);
}
