//! Scenes far from the origin of their coordinates keep their shape.

use std::fs;

use glam::{DVec3, Vec3};
use serde_json::json;
use umbrage_rays::LightSource;
use umbrage_scene::{Instances, Scene};

use crate::builder::{Builder, TRIANGLE};

/// Coordinates as of a survey: f32 has steps of half a unit there.
const AWAY: DVec3 = DVec3::new(500_000.123, 4_649_776.456, 121.5);

/// An outline with a notch, whose ears change if coordinates are rounded to halves, and a top above it.
const NOTCHED: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [0.9, 0.1, 0.0],
    [0.8, 0.9, 0.0],
    [0.45, 0.2, 0.0],
    [0.1, 0.85, 0.0],
    [0.3, 0.3, 0.7],
    [0.5, 0.1, 0.7],
];

fn obj(away: DVec3) -> String {
    let vertices = NOTCHED.map(|position| DVec3::from(position) + away).map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    format!("{}f 1 2 3 4 5\nf 1 2 7 6\n", vertices.concat())
}

/// Whether a scene has the same triangles as another one, displaced by a vector.
fn assert_same_shape(far: &Scene, near: &Scene, seconds: f64, away: DVec3) {
    assert_eq!(near.origin(), [0.0; 3]);
    assert_ne!(far.origin(), [0.0; 3]);
    let (far_frame, near_frame) = (far.at(seconds).unwrap(), near.at(seconds).unwrap());
    assert_eq!(far_frame.origin, far.origin());
    assert_eq!(far_frame.mesh.triangles, near_frame.mesh.triangles);
    assert_eq!(far_frame.positions.len(), near_frame.positions.len());
    for (&far_position, &position) in far_frame.positions.iter().zip(&near_frame.positions) {
        assert_there(far, far_position, position, away);
    }
}

fn assert_there(far: &Scene, local: Vec3, position: Vec3, away: DVec3) {
    let (world, expected) = (far.world_from_local(local), position.as_dvec3() + away);
    assert!(world.distance(expected) < 1e-5, "{world} in place of {expected}");
    assert!(far.local_from_world(world) == local);
}

#[test]
fn obj_files_far_away_keep_their_shape() {
    let [far, near] = [AWAY, DVec3::ZERO].map(|away| umbrage_files::open_bytes("a.obj", obj(away)).unwrap());
    assert_eq!(far.origin(), [500_001.0, 4_649_777.0, 122.0]);
    assert_same_shape(&far, &near, 0.0, AWAY);
    // A scene with hidden objects has it too.
    assert_eq!(far.hiding(&[]).unwrap().origin(), far.origin());
}

#[test]
fn near_files_are_read_as_they_are() {
    // At most 512 diagonals away.
    let text = "v 700.1 0.1 0\nv 701.3 0.2 0\nv 700.7 1.3 1e-3\nf 1 2 3\n";
    let scene = umbrage_files::open_bytes("a.obj", text).unwrap();
    assert_eq!(scene.origin(), [0.0; 3]);
    let expected = [Vec3::new(700.1, 0.1, 0.0), Vec3::new(701.3, 0.2, 0.0), Vec3::new(700.7, 1.3, 1e-3)];
    assert_eq!(scene.at(0.0).unwrap().positions, expected);
}

fn ply_header(format: &str, kind: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex 7\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

#[test]
fn doubles_of_ply_files_keep_their_shape() {
    let text = |away: DVec3| {
        let rows = NOTCHED.map(|at| DVec3::from(at) + away).map(|v| format!("{} {} {}\n", v.x, v.y, v.z)).concat();
        format!("{}{rows}5 0 1 2 3 4\n4 0 1 6 5\n", ply_header("ascii", "double")).into_bytes()
    };
    let binary = |away: DVec3| {
        let mut bytes = ply_header("binary_little_endian", "double").into_bytes();
        bytes.extend(NOTCHED.iter().flat_map(|&at| (DVec3::from(at) + away).to_array()).flat_map(f64::to_le_bytes));
        for face in [&[0_i32, 1, 2, 3, 4][..], &[0, 1, 6, 5]] {
            bytes.push(face.len() as u8);
            bytes.extend(face.iter().flat_map(|index| index.to_le_bytes()));
        }
        bytes
    };
    for file in [&text as &dyn Fn(DVec3) -> Vec<u8>, &binary] {
        let [far, near] = [AWAY, DVec3::ZERO].map(|away| umbrage_files::open_bytes("a.ply", file(away)).unwrap());
        assert_same_shape(&far, &near, 0.0, AWAY);
    }
}

#[test]
fn stl_files_keep_their_shape_as_far_as_they_have_it() {
    let text = |away: DVec3| {
        let corners = [0, 1, 6].map(|of| DVec3::from(NOTCHED[of]) + away);
        let corners = corners.map(|v| format!("vertex {} {} {}\n", v.x, v.y, v.z)).concat();
        format!("solid vertex a b\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid\n")
    };
    let [far, near] = [AWAY, DVec3::ZERO].map(|away| umbrage_files::open_bytes("a.stl", text(away)).unwrap());
    assert_same_shape(&far, &near, 0.0, AWAY);

    let binary = |[x, y, z]: [f32; 3]| {
        let mut bytes = vec![0; 80];
        bytes.extend(1_u32.to_le_bytes());
        let corners = [[x, y, z], [x + 1.5, y, z], [x, y + 2.0, z]];
        bytes.extend([0.0; 3].into_iter().chain(corners.as_flattened().iter().copied()).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
        bytes
    };
    let far = umbrage_files::open_bytes("a.stl", binary([5e5, 4e6, 100.0])).unwrap();
    assert_same_shape(
        &far,
        &umbrage_files::open_bytes("a.stl", binary([0.0; 3])).unwrap(),
        0.0,
        DVec3::new(5e5, 4e6, 100.0),
    );
}

#[test]
fn files_of_a_sequence_have_the_origin_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let away = [AWAY, AWAY + 3.0, DVec3::ZERO];
    for (number, away) in away.into_iter().enumerate() {
        fs::write(folder.path().join(format!("a_{number}.obj")), obj(away)).unwrap();
    }
    let scene = umbrage_files::open(folder.path().join("a_%d.obj")).unwrap();
    for (number, away) in away[..2].iter().enumerate() {
        let frame = scene.at(number as f64 / 24.0).unwrap();
        assert_eq!(frame.origin, scene.origin());
        assert_there(&scene, frame.positions[0], Vec3::ZERO, *away);
    }
    assert_eq!(scene.at(2.0 / 24.0).unwrap().positions[0], scene.local_from_world(DVec3::ZERO));
}

#[test]
fn point_caches_move_far_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, away: [f32; 3]| {
        let sample = |shift: f32| TRIANGLE.map(|corner| [0, 1, 2].map(|axis| corner[axis] + away[axis] + shift));
        let mut cache = b"POINTCACHE2\0".to_vec();
        cache.extend([1_i32, 3].into_iter().flat_map(i32::to_le_bytes));
        cache.extend([0.0_f32, 24.0].into_iter().flat_map(f32::to_le_bytes));
        cache.extend(2_i32.to_le_bytes());
        cache.extend([sample(0.0), sample(2.0)].as_flattened().as_flattened().iter().flat_map(|of| of.to_le_bytes()));
        let path = folder.path().join(name);
        fs::write(path.with_extension("obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        fs::write(&path, cache).unwrap();
        umbrage_files::open(path).unwrap()
    };
    let (far, near) = (write("far.pc2", [5e5, 4e6, 0.0]), write("near.pc2", [0.0; 3]));
    for seconds in [0.0, 0.125, 1.0] {
        assert_same_shape(&far, &near, seconds, DVec3::new(5e5, 4e6, 0.0));
    }
}

/// A file whose nodes turn, so that f32 would round their distances: meshes, copies, a skin, a camera and a light below a node
/// that stands on its side and is `away` from its parts.
fn nodes(away: DVec3) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let half = 0.5_f64.sqrt();
    let at = |x: f64, y: f64, z: f64| (away + DVec3::new(x, y, z)).to_array();
    let by_matrix = away + DVec3::new(-1.0, 0.25, 0.5);
    let copies = file.floats(&[[0.0, 0.0, 0.0], [0.5, 0.75, 0.0]]);
    let bind = file.floats(&[[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, -2.0, -3.0, 1.0_f32]]);
    let (positions, weights) = (file.floats(&TRIANGLE), file.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]));
    let joints = file.accessor(crate::builder::U8, "VEC4", 3, &[0; 12]);
    let bent = file.mesh(json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights }), json!({}));
    file.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }, { "type": "spot", "spot": {} }] } });
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]);
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.9, "znear": 0.1 } }));
    file.push("skins", json!({ "joints": [4], "inverseBindMatrices": bind }));
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    file.push("nodes", json!({ "rotation": [-half, 0, 0, half], "children": [1, 2, 3, 4, 5, 6, 7, 8] }));
    file.push("nodes", json!({ "mesh": mesh, "translation": at(0.0, 0.0, 0.0), "rotation": [0, half, 0, half] }));
    let [x, y, z] = by_matrix.to_array();
    file.push("nodes", json!({ "mesh": mesh, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, x, y, z, 1] }));
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": copies } } });
    file.push("nodes", json!({ "mesh": mesh, "translation": at(0.5, 0.5, 0.5), "extensions": instances }));
    file.push("nodes", json!({ "translation": at(1.0, 2.0, 3.0) }));
    file.push("nodes", json!({ "mesh": bent, "skin": 0 }));
    file.push("nodes", json!({ "camera": 0, "translation": at(0.0, 0.5, 4.0) }));
    let light = |number: u32| json!({ "KHR_lights_punctual": { "light": number } });
    file.push("nodes", json!({ "translation": at(3.0, 3.0, 3.0), "extensions": light(0) }));
    file.push("nodes", json!({ "translation": at(-3.0, 3.0, 0.0), "extensions": light(1) }));
    // Only turned: its place stays that of the JSON.
    file.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 0.6, 0.0, 0.8_f32]]);
    let (far, farther) = (at(0.0, 0.5, 4.0), at(0.0, 0.75, 5.0));
    file.animate(6, "translation", "LINEAR", &[0.0, 1.0], &[far, farther].map(|at| at.map(|axis| axis as f32)));
    file
}

#[test]
fn nodes_of_gltf_files_are_composed_in_f64() {
    let [far, near] = [AWAY, DVec3::ZERO].map(|away| nodes(away).open().unwrap());
    // Up is where −z was.
    let away = DVec3::new(AWAY.x, AWAY.z, -AWAY.y);
    for seconds in [0.0, 0.5, 1.0] {
        assert_same_shape(&far, &near, seconds, away);
        let (far_frame, near_frame) = (far.at(seconds).unwrap(), near.at(seconds).unwrap());
        let [camera, expected] = [&far_frame, &near_frame].map(|frame| frame.cameras[0].camera);
        // Keyframes are f32.
        assert!(far.world_from_local(camera.position).distance(expected.position.as_dvec3() + away) < 0.3);
        assert!(camera.forward.abs_diff_eq(expected.forward, 1e-6) && camera.up.abs_diff_eq(expected.up, 1e-6));
        for (light, expected) in far_frame.lights.iter().zip(&near_frame.lights) {
            let [position, expected] = [light, expected].map(|light| match light.source {
                LightSource::Point { position } | LightSource::Spot { position, .. } => position,
                LightSource::Directional { .. } => panic!("a sun"),
            });
            assert_there(&far, position, expected, away);
        }
    }
}

#[test]
fn instances_say_where_they_are_in_the_world() {
    let [far, near] = [AWAY, DVec3::ZERO].map(|away| nodes(away).open().unwrap());
    let [mut far_instances, near_instances] = [&far, &near].map(|scene| Instances::of_scene(scene, 0.5).unwrap());
    assert_eq!(far_instances.origin().to_array(), far.origin());
    let positions = far_instances.triangles().positions.to_vec();
    let away = DVec3::new(AWAY.x, AWAY.z, -AWAY.y);
    for (id, (instance, expected)) in far_instances.all().to_vec().iter().zip(near_instances.all()).enumerate() {
        let [there, expected] = [instance, expected].map(umbrage_scene::Instance::world_from_object);
        assert!((there.translation - expected.translation).distance(away) < 1e-5 || instance.name() == "node 5");
        far_instances.set_transform(id as u32, there);
    }
    for (&moved, &position) in far_instances.triangles().positions.iter().zip(&positions) {
        assert!(moved.abs_diff_eq(position, 1e-6), "{moved} in place of {position}");
    }
}

#[test]
fn grounds_are_at_heights_of_the_world() {
    let text = "v 0 90000 0\nv 1 90000 0\nv 0 90001 1\nf 1 2 3\n";
    let mut scene = umbrage_files::open_bytes("a.obj", text).unwrap();
    assert_eq!(scene.origin()[1], 90_001.0);
    scene.set_ground(Some(umbrage_scene::Ground { height: Some(89_999.0), ..Default::default() }));
    assert_eq!(scene.at(0.0).unwrap().positions[3].y, -2.0);
    assert_eq!(scene.ground().unwrap().height, Some(89_999.0));
}
