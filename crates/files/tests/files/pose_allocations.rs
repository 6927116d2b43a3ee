//! Posing into a frame that has been posed before doesn't allocate.

use serde_json::json;
use umbrage_scene::{Frame, Scene};

use crate::builder::{Builder, U8};

/// A strip of 20,000 vertices, skinned and morphed, with a moving light and camera: enough for many parallel tasks.
fn moving_scene() -> Builder {
    let mut file = Builder::new();
    let count = 20_000_u16;
    let positions: Vec<_> = (0..count).map(|vertex| [f32::from(vertex / 2), f32::from(vertex % 2), 0.0]).collect();
    let positions = file.floats(&positions);
    let normals = file.floats(&vec![[0.0, 0.0, 1.0]; usize::from(count)]);
    let tangents = file.floats(&vec![[1.0, 0.0, 0.0, 1.0]; usize::from(count)]);
    let weights = file.floats(&vec![[0.5, 0.5, 0.0, 0.0]; usize::from(count)]);
    let joints = file.accessor(U8, "VEC4", usize::from(count), &[0, 1, 0, 0].repeat(usize::from(count)));
    let attributes = json!({
        "POSITION": positions, "NORMAL": normals, "TANGENT": tangents, "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    let targets = json!([{ "POSITION": normals, "NORMAL": normals, "TANGENT": normals }]);
    let mesh = file.mesh(attributes, json!({ "mode": 5, "targets": targets }));
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.json["nodes"] = json!([
        { "mesh": mesh, "skin": 0 },
        { "children": [2] },
        { "camera": 0, "extensions": light },
    ]);
    file.json["skins"] = json!([{ "joints": [1, 2] }]);
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } });
    file.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);
    file.animate(2, "translation", "CUBICSPLINE", &[0.0, 1.0], &[[1.0; 3]; 6]);
    file.animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    file
}

/// Poses a scene at twenty times into one frame, and asserts that no pose but the first allocates. Returns the last frame.
#[track_caller]
pub(crate) fn assert_later_poses_allocate_nothing(scene: &Scene) -> Frame {
    // On one thread, since the pool allocates queues between several threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut frame = Frame::default();
        let none = allocations::on_this_thread();
        scene.pose(0.0, &mut frame).unwrap();
        let before = allocations::on_this_thread();
        assert!(before > none, "the first pose is counted");
        (1..20).for_each(|step| scene.pose(f64::from(step) / 10.0, &mut frame).unwrap());
        assert_eq!(allocations::on_this_thread() - before, 0, "allocations in 19 poses");
        frame
    })
}

#[test]
fn later_poses_allocate_nothing() {
    let frame = assert_later_poses_allocate_nothing(&moving_scene().open().unwrap());
    assert_eq!((frame.cameras.len(), frame.lights.len()), (1, 1));
}
