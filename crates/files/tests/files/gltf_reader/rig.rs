use glam::Vec3;
use serde_json::json;
use umbrage_files::Clip;
use umbrage_scene::rig::{Placement, Pose};
use umbrage_scene::{Animated, Error, Frame, Ground, GroundSurface, Scene};

use crate::builder::{Builder, U8};

/// A skinned mesh, a morphed one, one on a moving node, one on a still one, and two instances on a still one.
fn varied() -> Builder {
    let mut file = Builder::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 3]);
    let plain = file.mesh(json!({ "POSITION": positions, "NORMAL": normals }), json!({}));
    let joints = file.accessor(U8, "VEC4", 3, &[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    let weights = file.floats(&[[0.25, 0.75, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]);
    let skinned = file.mesh(json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights }), json!({}));
    let targets = json!({ "targets": [{ "POSITION": normals }, { "POSITION": positions }] });
    let morphed = file.mesh(json!({ "POSITION": positions, "NORMAL": normals }), targets);
    let places = file.floats(&[[0.0, 0.0, 3.0], [0.0, 0.0, 4.0]]);
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    file.json["nodes"] = json!([
        { "mesh": plain, "translation": [5, 0, 0] },
        { "mesh": skinned, "skin": 0 },
        { "mesh": morphed, "weights": [0.5, 0.0] },
        { "mesh": plain },
        { "mesh": plain, "scale": [1, 2, 1], "extensions": instances },
        { "translation": [0, 7, 0] },
        { "mesh": plain },
    ]);
    file.json["skins"] = json!([{ "joints": [5, 3] }]);
    let animate = |file: &mut Builder, node: usize| {
        file.animate(node, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [1.0, 2.0, 3.0]]);
    };
    animate(&mut file, 3);
    file.animate(2, "weights", "LINEAR", &[0.0, 1.0], &[[0.5], [0.0], [0.5], [1.0]]);
    file
}

fn posed_by_rig(scene: &Scene, seconds: f64) -> (Frame, Pose) {
    // Values of an earlier pose are replaced.
    let (mut frame, mut pose) = (scene.at(0.9).unwrap(), Pose::default());
    let rig = scene.pose_rig(seconds, &mut frame, &mut pose).unwrap().unwrap();
    assert!(frame.positions.is_empty() && frame.normals.is_empty() && frame.tangents.is_empty());
    rig.pose(&pose, &mut frame);
    (frame, pose)
}

#[test]
fn a_rig_poses_what_its_scene_does() {
    let scene = varied().open().unwrap();
    for seconds in [0.0, 0.3, 1.0, 1.4] {
        let (frame, _) = posed_by_rig(&scene, seconds);
        let expected = scene.at(seconds).unwrap();
        assert_eq!(frame.positions, expected.positions);
        assert_eq!(frame.normals, expected.normals);
        assert_eq!((&frame.lights, &frame.cameras), (&expected.lights, &expected.cameras));
        assert_eq!((frame.seconds, frame.animation_bounds), (seconds, expected.animation_bounds));
    }
    assert_ne!(scene.at(0.0).unwrap().positions, scene.at(0.3).unwrap().positions);
}

#[test]
fn a_ground_is_under_what_a_rig_poses() {
    let mut scene = varied().open().unwrap();
    let bare = scene.at(0.3).unwrap();
    scene.set_ground(Some(Ground { surface: GroundSurface::Shadow, height: None }));
    for seconds in [0.0, 0.3, 1.0] {
        let (frame, _) = posed_by_rig(&scene, seconds);
        let expected = scene.at(seconds).unwrap();
        assert_eq!(frame.positions, expected.positions);
        assert_eq!(frame.normals, expected.normals);
        assert_eq!(frame.mesh.triangles, expected.mesh.triangles);
        frame.check().unwrap();
    }
    let frame = scene.at(0.3).unwrap();
    assert_eq!(frame.positions[..bare.positions.len()], bare.positions);
    let corners = &frame.positions[bare.positions.len()..];
    let depth = bare.animation_bounds.min.y - corners[0].y;
    assert!(corners.len() == 4 && depth > 0.0 && depth < 1e-3 && corners.iter().all(|corner| corner.y == corners[0].y));
    assert_eq!(frame.mesh.part_of_triangle.len(), frame.mesh.triangles.len());
    assert_eq!(frame.camera(1.5), bare.camera(1.5));
    // Frames with unchanged visibility share their mesh.
    assert!(std::sync::Arc::ptr_eq(&frame.mesh, &scene.at(0.7).unwrap().mesh));
    scene.set_ground(None);
    assert_eq!(scene.at(0.3).unwrap().positions, bare.positions);
}

#[test]
fn parts_move_that_follow_what_an_animation_moves() {
    let scene = varied().open().unwrap();
    let (early, first) = posed_by_rig(&scene, 0.0);
    let (late, second) = posed_by_rig(&scene, 0.3);
    let rig = scene.pose_rig(0.0, &mut Frame::default(), &mut Pose::default()).unwrap().unwrap();
    assert_eq!(
        rig.parts.iter().map(|part| part.moves).collect::<Vec<_>>(),
        [false, true, true, true, false, false, false]
    );
    for part in &rig.parts {
        let vertices = part.first_vertex as usize..part.first_vertex as usize + 3;
        assert_eq!(early.positions[vertices.clone()] != late.positions[vertices], part.moves, "{part:?}");
    }
    // The moving matrices belong to a node and two joints, one of which moves; the others are constant.
    assert_eq!((rig.moving_matrices, first.matrices.len()), (3, 3 + 5));
    assert_eq!(first.matrices[3..], second.matrices[3..]);
    assert_ne!(first.matrices[..3], second.matrices[..3]);
    assert!(matches!(rig.parts[1].placement, Placement::Skinned { .. }));
}

#[test]
fn nothing_moves_at_rest() {
    let scene = varied().open_clip(Clip::Rest).unwrap();
    let rig = scene.pose_rig(0.0, &mut Frame::default(), &mut Pose::default()).unwrap().unwrap();
    assert!(rig.parts.iter().all(|part| !part.moves));
    assert_eq!(rig.moving_matrices, 0);
}

/// A triangle that rises.
#[derive(Debug)]
struct Rising;

impl Animated for Rising {
    fn duration_seconds(&self) -> f64 {
        1.0
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        let height = seconds as f32;
        let corners = [[0.0, height, 0.0], [1.0, height, 0.0], [0.0, height, 1.0]].map(Vec3::from_array);
        frame.copy_surfaces(&Frame::from_triangles(corners.to_vec(), vec![[0, 1, 2]]));
        Ok(())
    }
}

#[test]
fn scenes_without_a_rig_leave_the_frame_alone() {
    let scene = Scene::new(Box::new(Rising)).unwrap();
    let mut frame = scene.at(0.5).unwrap();
    let before = frame.positions.clone();
    assert!(scene.pose_rig(0.7, &mut frame, &mut Pose::default()).unwrap().is_none());
    assert_eq!((frame.positions, frame.seconds), (before, 0.5));
}

#[test]
fn parts_are_what_moves_together() {
    let mut file = varied();
    // On the animated node.
    file.json["nodes"][3]["children"] = json!([6]);
    let frame = file.at(0.0);
    let parts = frame.parts();
    // All still triangles are one part, and the skin's triangle mostly follows joint 1.
    assert_eq!(parts.of_triangle, [0, 1, 2, 3, 0, 0, 3]);
    assert_eq!(parts.objects, [0, 1, 2, 3]);

    // A second triangle of the skin that follows joint 0 is another part of that object.
    let mut file = varied();
    let joints = file.accessor(U8, "VEC4", 3, &[0; 12]);
    let mut other = file.json["meshes"][1]["primitives"][0].clone();
    other["attributes"]["JOINTS_0"] = json!(joints);
    file.json["meshes"][1]["primitives"].as_array_mut().unwrap().push(other);
    let frame = file.at(0.0);
    assert_eq!(frame.parts().of_triangle, [0, 1, 2, 3, 4, 0, 0, 0]);
    assert_eq!(frame.parts().objects, [0, 1, 1, 2, 3]);
    assert_eq!(frame.parts().object_of(2), 1);
}
