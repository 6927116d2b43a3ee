use std::f32::consts::FRAC_PI_2;

use glam::{Mat4, Quat, Vec3, Vec4};
use serde_json::json;
use umbrage_scene::{Frame, Scene};

use crate::builder::{Builder, I16, TRIANGLE, U8, U16};

#[track_caller]
fn assert_close(actual: Vec3, expected: Vec3) {
    assert!((actual - expected).length() < 1e-5, "{actual}, not {expected}");
}

/// One triangle with a normal towards +x and a tangent towards +y.
fn with_normals(file: &mut Builder) -> usize {
    let positions = file.floats(&TRIANGLE);
    let normals = file.floats(&[[1.0, 0.0, 0.0]; 3]);
    let tangents = file.floats(&[[0.0, 1.0, 0.0, 1.0]; 3]);
    file.mesh(json!({ "POSITION": positions, "NORMAL": normals, "TANGENT": tangents }), json!({}))
}

#[test]
fn scale_comes_first_then_rotation_then_translation() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let quarter = Quat::from_rotation_z(FRAC_PI_2).to_array();
    file.push("nodes", json!({ "mesh": mesh, "translation": [10, 0, 0], "rotation": quarter, "scale": [2, 3, 1] }));
    let frame = file.at(0.0);
    assert_close(frame.positions[1], Vec3::new(10.0, 2.0, 0.0));
    assert_close(frame.positions[2], Vec3::new(7.0, 0.0, 0.0));
}

#[test]
fn nodes_are_inside_their_parents() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let matrix = Mat4::from_rotation_x(FRAC_PI_2).to_cols_array();
    // Children come before their parents in the file.
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 1, 0] }));
    file.push("nodes", json!({ "children": [0], "matrix": matrix }));
    file.push("nodes", json!({ "children": [1], "scale": [1, 1, 5] }));
    let frame = file.at(0.0);
    // (0, 1, 0), rotated to (0, 0, 1), scaled to (0, 0, 5).
    assert_close(frame.positions[0], Vec3::new(0.0, 0.0, 5.0));
    assert_close(frame.positions[2], Vec3::new(0.0, 0.0, 10.0));
}

#[test]
fn fronts_of_mirrored_nodes_stay_fronts() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("nodes", json!({ "mesh": mesh, "scale": [-1, 1, 1] }));
    // Mirrored twice, and in a mirror that moves.
    file.push("nodes", json!({ "children": [3], "scale": [1, -2, 1] }));
    file.push("nodes", json!({ "mesh": mesh, "scale": [-1, 1, 1] }));
    file.push("nodes", json!({ "children": [5], "scale": [1, 1, -1e-20] }));
    file.push("nodes", json!({ "mesh": mesh, "scale": [1e-20, 1e-20, 1] }));
    file.animate(4, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [0.0, 0.0, 4.0]]);
    file.push("scenes", json!({ "nodes": [0, 1, 2, 4] }));
    let frame = file.at(0.5);
    let normals = frame.mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|vertex| frame.positions[vertex as usize].as_dvec3());
        (b - a).cross(c - a).z.signum()
    });
    // As the file's own front, towards z; turned away where the mirror turns z.
    assert_eq!(normals.collect::<Vec<_>>(), [1.0, 1.0, 1.0, -1.0]);
}

#[test]
fn a_moving_parent_moves_what_is_below() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 1, 0] }));
    file.push("nodes", json!({ "children": [0], "scale": [2, 2, 2] }));
    file.animate(1, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [4.0, 0.0, 0.0]]);
    assert_close(file.at(0.5).positions[0], Vec3::new(2.0, 2.0, 0.0));
}

#[test]
fn only_the_default_scene_is_shown() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    for x in 0..4 {
        file.push("nodes", json!({ "mesh": mesh, "translation": [x, 0, 0] }));
    }
    file.json["nodes"][2]["children"] = json!([3]);
    let xs = |file: &Builder| file.at(0.0).positions.iter().step_by(3).map(|position| position.x).collect::<Vec<_>>();
    assert_eq!(xs(&file), [0.0, 1.0, 2.0, 5.0], "without scenes all nodes are shown");
    file.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [2] }, {}]);
    assert_eq!(xs(&file), [0.0], "the first scene stands in for the default one");
    file.json["scene"] = json!(1);
    assert_eq!(xs(&file), [2.0, 5.0]);
    file.json["scene"] = json!(2);
    assert!(xs(&file).is_empty());
    file.json["scene"] = json!(3);
    assert!(file.error().contains("scene: index 3 is out of range: `scenes` has 3"), "{}", file.error());
}

#[test]
fn normals_stay_at_right_angles_whatever_the_scale() {
    let mut file = Builder::new();
    let positions = file.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let normals = file.floats(&[Vec3::ONE.normalize().to_array(); 3]);
    let mesh = file.mesh(json!({ "POSITION": positions, "NORMAL": normals }), json!({}));
    for scale in [[1.0, 2.0, 3.0], [-1.0, 2.0, 3.0], [1e-12, 2e-12, 3e-12], [1e12, -1e12, 1e12]] {
        let mut file = file.clone();
        file.push("nodes", json!({ "mesh": mesh, "scale": scale }));
        let frame = file.at(0.0);
        let [a, b, c] = frame.positions[..] else { panic!("three corners") };
        let normal = frame.normals[0];
        assert!((normal.length() - 1.0).abs() < 1e-6, "{scale:?}");
        assert!(normal.dot((b - a).normalize()).abs() < 1e-5, "{scale:?}");
        assert!(normal.dot((c - a).normalize()).abs() < 1e-5, "{scale:?}");
        // A mirror keeps the normal on the side away from the origin, on which it was.
        assert!(normal.dot(a.normalize()) > 0.0, "{scale:?}");
    }
}

#[test]
fn a_flattened_surface_has_the_normal_of_its_plane() {
    let mut file = Builder::new();
    let positions = file.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let normals = file.floats(&[Vec3::ONE.normalize().to_array(); 3]);
    let mesh = file.mesh(json!({ "POSITION": positions, "NORMAL": normals }), json!({}));
    file.push("nodes", json!({ "mesh": mesh, "scale": [1, 1, 0] }));
    assert_eq!(file.at(0.0).normals, [Vec3::Z; 3]);
    file.json["nodes"][0]["scale"] = json!([0, 0, 0]);
    assert_eq!(file.at(0.0).normals, [Vec3::ZERO; 3]);
}

#[test]
fn mirroring_turns_the_sign_of_tangents() {
    let mut file = Builder::new();
    let mesh = with_normals(&mut file);
    file.push("nodes", json!({ "mesh": mesh, "scale": [-2, 1, 1] }));
    let frame = file.at(0.0);
    assert_eq!(frame.normals[0], Vec3::NEG_X);
    assert_eq!(frame.tangents[0], Vec4::new(0.0, 1.0, 0.0, -1.0));
    // The bitangent was x × y = z, which the mirror leaves alone.
    let bitangent = frame.normals[0].cross(frame.tangents[0].truncate()) * frame.tangents[0].w;
    assert_eq!(bitangent, Vec3::Z);
}

/// A triangle that follows two joints: node 1 at the origin, and node 2 one above it, which turns by a quarter.
fn skinned() -> Builder {
    let mut file = Builder::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]]);
    let normals = file.floats(&[[1.0, 0.0, 0.0]; 3]);
    let joints = file.accessor(U8, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    // The last vertex's weights add up to four.
    let weights = file.floats(&[[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0], [2.0, 2.0, 0.0, 0.0]]);
    let mesh = file
        .mesh(json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights }), json!({}));
    // The mesh's own place counts for nothing.
    file.push("nodes", json!({ "mesh": mesh, "skin": 0, "translation": [100, 100, 100], "scale": [9, 9, 9] }));
    file.push("nodes", json!({ "children": [2] }));
    file.push("nodes", json!({ "translation": [0, 1, 0], "rotation": Quat::from_rotation_z(FRAC_PI_2).to_array() }));
    let bind = [Mat4::IDENTITY.to_cols_array(), Mat4::from_translation(Vec3::NEG_Y).to_cols_array()];
    let bind = file.floats(&bind);
    file.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": bind }));
    file
}

#[test]
fn skinned_vertices_follow_their_joints() {
    let frame = skinned().at(0.0);
    assert_close(frame.positions[0], Vec3::ZERO);
    // One above joint 1, which turns up to the left.
    assert_close(frame.positions[1], Vec3::new(-1.0, 1.0, 0.0));
    assert_close(frame.normals[1], Vec3::Y);
    // Halfway between (1, 1, 0) where joint 0 has it and (0, 2, 0) where joint 1 has it.
    assert_close(frame.positions[2], Vec3::new(0.5, 1.5, 0.0));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_close(frame.normals[2], Vec3::new(half, half, 0.0));
}

#[test]
fn without_inverse_bind_matrices_joints_apply_as_they_are() {
    let mut file = skinned();
    file.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    // (0, 2, 0) turned to (−2, 0, 0) and raised by one.
    assert_close(file.at(0.0).positions[1], Vec3::new(-2.0, 1.0, 0.0));
}

#[test]
fn eight_influences_are_blended() {
    let mut file = skinned();
    let joints = file.accessor(U16, "VEC4", 3, &[0, 0, 1, 0, 0, 0, 0, 0].repeat(3));
    let weights = file.accessor(U8, "VEC4", 3, &[0, 255, 0, 0].repeat(3));
    file.json["accessors"][weights]["normalized"] = json!(true);
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = json!(joints);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_1"] = json!(weights);
    // Vertex 0 follows joint 0 and joint 1 equally: (0, 0, 0), and (0, −1, 0) turned to (1, 0, 0) and raised by one.
    assert_close(file.at(0.0).positions[0], Vec3::new(0.5, 0.5, 0.0));
}

#[test]
fn vertices_without_weights_follow_the_first_joint() {
    let mut file = skinned();
    let weights = file.floats(&[[0.0; 4], [f32::NAN, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let scene = file.open().unwrap();
    assert!(scene.warnings()[0].contains("2 vertices without usable weights"), "{:?}", scene.warnings());
    assert_close(scene.at(0.0).unwrap().positions[0], Vec3::ZERO);
}

#[test]
fn joints_that_the_skin_lacks_are_refused() {
    let mut file = skinned();
    file.json["skins"][0]["joints"] = json!([1]);
    let error = file.error();
    assert!(error.contains("skins[0]: a vertex of mesh 0 follows joint 1, but there are 1"), "{error}");
    let mut file = skinned();
    file.json["skins"][0]["joints"] = json!([1, 2, 1]);
    assert!(file.error().contains("2 matrices for 3 joints"), "{}", file.error());
    let mut file = skinned();
    file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    assert!(file.error().contains("there is JOINTS_0 but no WEIGHTS_0"));
}

/// A triangle with a normal towards +z, and a target that moves corner 1 and tips its normal.
fn morphing() -> Builder {
    let mut file = Builder::new();
    let positions = file.floats(&TRIANGLE);
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 3]);
    let tangents = file.floats(&[[1.0, 0.0, 0.0, -1.0]; 3]);
    let places = file.view(&[1]);
    let mut sparse = |values: [f32; 3]| {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let values = file.view(&bytes);
        let sparse = json!({
            "count": 1,
            "indices": { "bufferView": places, "componentType": U8 },
            "values": { "bufferView": values },
        });
        file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse }))
    };
    let target = json!({
        "POSITION": sparse([0.0, 0.0, 4.0]),
        "NORMAL": sparse([4.0, 0.0, -3.0]),
        "TANGENT": sparse([-1.0, 0.0, -1.0]),
    });
    let mesh = file
        .mesh(json!({ "POSITION": positions, "NORMAL": normals, "TANGENT": tangents }), json!({ "targets": [target] }));
    file.json["meshes"][0]["weights"] = json!([0.5]);
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 0, 1] }));
    file.push("nodes", json!({ "mesh": mesh, "weights": [1.0] }));
    file
}

#[test]
fn morph_targets_move_vertices_before_the_node_does() {
    let frame = morphing().at(0.0);
    assert_close(frame.positions[0], Vec3::new(0.0, 0.0, 1.0));
    assert_close(frame.positions[1], Vec3::new(1.0, 0.0, 3.0));
    assert_close(frame.normals[0], Vec3::Z);
    // (2, 0, −0.5), at unit length.
    assert_close(frame.normals[1], Vec3::new(2.0, 0.0, -0.5).normalize());
    assert_close(frame.tangents[1].truncate(), Vec3::new(0.5, 0.0, -0.5).normalize());
    assert_eq!(frame.tangents[1].w, -1.0);
}

#[test]
fn weights_of_a_node_come_before_those_of_its_mesh() {
    let frame = morphing().at(0.0);
    assert_close(frame.positions[4], Vec3::new(1.0, 0.0, 4.0));
    assert_close(frame.normals[4], Vec3::new(4.0, 0.0, -2.0).normalize());
}

#[test]
fn sparse_targets_follow_vertices_when_others_are_left_out() {
    let mut file = morphing();
    // Vertex 0 of four is not used; the target's vertex 1 becomes vertex 0.
    let positions = file.floats(&[[9.0, 9.0, 9.0], TRIANGLE[0], TRIANGLE[1], TRIANGLE[2]]);
    let indices = file.indices(&[1, 2, 3]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"] = json!({ "POSITION": positions });
    primitive["indices"] = json!(indices);
    primitive["targets"][0] = json!({ "POSITION": primitive["targets"][0]["POSITION"] });
    let target = file.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"].as_u64().unwrap() as usize;
    file.json["accessors"][target]["count"] = json!(4);
    let frame = file.at(0.0);
    assert_eq!(frame.positions.len(), 6);
    assert_close(frame.positions[3], Vec3::new(0.0, 0.0, 4.0));
    assert_close(frame.positions[4], Vec3::X);
}

#[test]
fn a_skinned_mesh_is_morphed_first() {
    let mut file = skinned();
    let deltas = file.floats(&[[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": deltas }]);
    file.json["meshes"][0]["weights"] = json!([1.0]);
    // Two above joint 1.
    assert_close(file.at(0.0).positions[1], Vec3::new(-2.0, 1.0, 0.0));
}

#[test]
fn instances_are_placed_inside_their_node() {
    let mut file = Builder::new();
    let mesh = with_normals(&mut file);
    let translations = file.floats(&[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    let quarter = (std::f32::consts::FRAC_1_SQRT_2 * 32_767.0).round() as i16;
    let rotations: Vec<u8> =
        [0, 0, 0, 32_767, 0, 0, quarter, quarter].iter().flat_map(|value: &i16| value.to_le_bytes()).collect();
    let rotations = file.accessor(I16, "VEC4", 2, &rotations);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = file.floats(&[[1.0; 3], [3.0; 3]]);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 0 });
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    file.push("nodes", json!({ "mesh": mesh, "scale": [2, 2, 2], "extensions": instancing }));
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let frame = file.at(0.0);
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_close(frame.positions[1], Vec3::new(4.0, 0.0, 0.0));
    // (1, 0, 0), scaled to 3, turned to y, raised by 2, scaled by 2.
    assert_close(frame.positions[4], Vec3::new(0.0, 10.0, 0.0));
    assert_close(frame.normals[4], Vec3::Y);
    let few = file.floats(&[[0.0; 3]]);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(few);
    assert!(file.error().contains("1 elements where 2 are needed"), "{}", file.error());
}

#[test]
fn many_vertices_are_posed_in_pieces() {
    // More vertices than one thread is given, in parts of which the ends don't meet those of the pieces.
    let mut file = Builder::new();
    let points: Vec<[f32; 3]> = (0..9999).map(|number| [number as f32, 1.0, 2.0]).collect();
    let positions = file.floats(&points);
    let deltas: Vec<[f32; 3]> = (0..9999).map(|number| [0.0, 0.0, number as f32]).collect();
    let deltas = file.floats(&deltas);
    let mesh = file.mesh(json!({ "POSITION": positions }), json!({ "targets": [{ "POSITION": deltas }] }));
    for y in 0..3 {
        file.push("nodes", json!({ "mesh": mesh, "translation": [0, y, 0], "weights": [y] }));
    }
    let frame = file.at(0.0);
    for (number, position) in frame.positions.iter().enumerate() {
        let (node, vertex) = (number / 9999, number % 9999);
        let expected = Vec3::new(vertex as f32, 1.0 + node as f32, 2.0 + (node * vertex) as f32);
        assert_eq!(*position, expected, "{number}");
    }
    assert_eq!(frame.mesh.triangles[3333], [9999, 10_000, 10_001]);
    assert_eq!(frame.mesh.triangles.len(), 9999);
}

#[test]
fn scenes_are_posed_by_many_threads_at_once() {
    fn shared<T: Send + Sync>(_: &T) {}
    let mut file = skinned();
    file.animate(2, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [0.0, 8.0, 0.0]]);
    let scene: Scene = file.open().unwrap();
    shared(&scene);
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let scene = &scene;
            scope.spawn(move || {
                let mut frame = Frame::default();
                for step in 0..200 {
                    let seconds = f64::from((step * 7 + thread) % 16) / 16.0;
                    scene.pose(seconds, &mut frame).unwrap();
                    assert_close(frame.positions[1], Vec3::new(-1.0, 8.0 * seconds as f32, 0.0));
                }
            });
        }
    });
}

#[test]
fn deep_hierarchies_are_walked() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    const DEPTH: usize = 20_000;
    let nodes: Vec<_> = (1..DEPTH).map(|child| json!({ "children": [child], "translation": [0, 0, 0.5] })).collect();
    file.json["nodes"] = json!(nodes);
    file.push("nodes", json!({ "mesh": mesh }));
    file.animate(0, "translation", "LINEAR", &[0.0], &[[0.0, 0.0, 0.5]]);
    let scene = file.open().unwrap();
    assert_eq!(scene.world_from_local(scene.at(0.0).unwrap().positions[0]).z, 0.5 * (DEPTH - 1) as f64);
}
