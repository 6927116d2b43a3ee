//! The nodes of glTF files as rigid instances.

use glam::{DAffine3, DVec3, Vec3};
use serde_json::json;
use umbrage_rays::predicate::hit;
use umbrage_rays::{Ray, Triangles};
use umbrage_scene::{Ground, Instances};

use crate::builder::{Builder, TRIANGLE};

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

#[test]
fn nodes_are_instances_at_every_moment() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh, "name": "wheel", "translation": [10, 0, 0] }));
    file.push("nodes", json!({ "mesh": mesh, "name": "wheel", "scale": [2, 2, 2] }));
    file.push("nodes", json!({ "mesh": mesh, "name": "door" }));
    file.animate(2, "translation", "LINEAR", &[0.0, 1.0], &[[0.0, 20.0, 0.0], [0.0, 40.0, 0.0]]);
    let mut scene = file.open().unwrap();
    for seconds in [0.0, 0.5, 1.0] {
        let instances = Instances::of_scene(&scene, seconds).unwrap();
        let frame = scene.at(seconds).unwrap();
        assert_eq!(instances.triangles().positions, frame.positions);
        assert_eq!(instances.triangles().indices, frame.mesh.triangles);
        let at = |x: f32, y: f32| DVec3::new(f64::from(x), f64::from(y), 0.0);
        assert_eq!(above(&instances, 10.25, 0.5), Some(("wheel".into(), 0, at(0.25, 0.5))));
        assert_eq!(above(&instances, 0.25, 0.5), Some(("wheel".into(), 0, at(0.125, 0.25))));
        let door = 20.0 + 20.0 * seconds;
        assert_eq!(above(&instances, 0.25, door + 0.5), Some(("door".into(), 0, at(0.25, 0.5))));
        assert_eq!(instances.all()[2].world_from_object(), DAffine3::from_translation(DVec3::Y * door));
        let (vertices, triangles) = instances.mesh(2);
        assert_eq!((vertices, triangles.collect::<Vec<_>>()), (&TRIANGLE.map(Vec3::from)[..], vec![[0, 1, 2]]));
        assert_eq!(above(&instances, 5.0, 5.0), None);
    }
    // The ground's two triangles are an instance too.
    scene.set_ground(Some(Ground::default()));
    let instances = Instances::of_scene(&scene, 0.0).unwrap();
    let names: Vec<_> = instances.all().iter().map(|instance| (instance.name(), instance.triangles())).collect();
    assert_eq!(names, [("wheel", 0..1), ("wheel", 1..2), ("door", 2..3), ("ground", 3..5)]);
}

#[test]
fn what_deforms_is_in_the_world() {
    // A node that morphs, before one that doesn't.
    let mut file = Builder::new();
    let (positions, deltas) = (file.floats(&TRIANGLE), file.floats(&[[0.0, 0.0, 1.0]; 3]));
    let more = json!({ "targets": [{ "POSITION": deltas }] });
    let morphing = file.mesh(json!({ "POSITION": positions }), more);
    let rigid = file.triangle();
    file.push("nodes", json!({ "mesh": morphing, "name": "face", "translation": [10, 0, 0], "weights": [1] }));
    file.push("nodes", json!({ "mesh": rigid, "name": "hat", "translation": [0, 10, 0] }));
    let instances = Instances::of_scene(&file.open().unwrap(), 0.0).unwrap();
    assert_eq!(above(&instances, 10.25, 0.5), Some(("face".into(), 0, DVec3::new(10.25, 0.5, 1.0))));
    assert_eq!(above(&instances, 0.25, 10.5), Some(("hat".into(), 0, DVec3::new(0.25, 0.5, 0.0))));
    assert_eq!(instances.all()[0].world_from_object(), DAffine3::IDENTITY);
}
