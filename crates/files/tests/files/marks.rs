//! Points and lines: those of files, and those of frames made of them.

use glam::{Vec3, Vec4};
use serde_json::json;
use umbrage_scene::{Frame, MarkRun};

use crate::builder::Builder;
use crate::solids::{frame, open};

/// A PLY text with these elements and rows after five vertices, whose x coordinate is their index.
fn ply(elements: &str, rows: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\n{elements}end_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n2 0 0 0 0 255\n\
         3 0 0 0 0 0\n4 1 2 255 255 255\n{rows}"
    )
    .into_bytes()
}

/// The x coordinates of points and of lines' ends.
fn shown(frame: &Frame) -> (Vec<f32>, Vec<[f32; 2]>) {
    frame.check().expect("a whole frame");
    let x = |vertex: u32| frame.positions[vertex as usize].x;
    let marks = &frame.mesh.marks;
    (marks.points().iter().map(|&point| x(point)).collect(), marks.lines().iter().map(|line| line.map(x)).collect())
}

#[test]
fn vertices_of_a_ply_file_without_faces_are_points() {
    let frame = frame("cloud.ply", &ply("", ""));
    assert_eq!(shown(&frame).0, [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(frame.mesh.colors[1], Vec4::new(0.0, 1.0, 0.0, 1.0));
    assert_eq!((frame.bounds().min, frame.bounds().max), (Vec3::ZERO, Vec3::new(4.0, 1.0, 2.0)));
    // From outside, so that all of them are seen.
    let camera = frame.framing_camera(1.0);
    assert!((frame.bounds().center() - camera.position).dot(camera.forward) > 2.0, "{camera:?}");
}

#[test]
fn points_that_are_nowhere_are_left_out_and_counted() {
    let text = String::from_utf8(ply("", "")).unwrap().replace("\n2 0 0", "\nnan 0 0").replace("\n3 0 0", "\n3 inf 0");
    let (frame, warnings) = open("cloud.ply", text.as_bytes()).unwrap();
    assert_eq!(shown(&frame).0, [0.0, 1.0, 4.0]);
    assert_eq!(warnings, ["left out 2 points with a coordinate that is not finite"]);
}

#[test]
fn edges_of_a_ply_file_are_lines() {
    let edges = "element edge 2\nproperty int vertex1\nproperty uchar red\nproperty int vertex2\n";
    let alone = frame("edges.ply", &ply(edges, "4 7 0\n1 7 1\n"));
    assert_eq!(shown(&alone), (vec![], vec![[4.0, 0.0], [1.0, 1.0]]));
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let beside = frame("edges.ply", &ply(&format!("{edges}{faces}"), "4 7 0\n1 7 1\n3 0 1 4\n"));
    assert_eq!((shown(&beside).1.len(), beside.mesh.triangles.len()), (2, 1));
    let error = open("edges.ply", &ply(edges, "4 7 0\n1 7 5\n")).unwrap_err();
    assert!(error.contains("edge 1: `vertex2`: vertex 5 is not there: the file has 5"), "{error}");
    let unnamed = frame("edges.ply", &ply("element edge 1\nproperty int from\n", "3\n"));
    assert_eq!(shown(&unnamed).0.len(), 5);
}

#[test]
fn points_and_lines_of_an_obj_file_have_materials_and_objects() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nvt 0 0\np 1 -1\no Wire\nusemtl red\nl 1/1 2/1 3 4\nl 2\n\
                p 4\nf 1 2 3\n";
    let (whole, _) = open("a.obj", text.as_bytes()).unwrap();
    assert_eq!(shown(&whole), (vec![0.0, 3.0, 3.0], vec![[0.0, 1.0], [1.0, 2.0], [2.0, 3.0]]));
    let runs: Vec<_> = whole.mesh.marks.runs().collect();
    let [MarkRun { material: none, .. }, MarkRun { points, lines, material: red }] = runs[..] else {
        panic!("{runs:?}")
    };
    assert!(none != red && points.len() == 1 && lines.len() == 3);
    assert_eq!(whole.positions.len(), 4, "texture coordinates make no vertices");
    let scene = umbrage_files::open_bytes("a.obj", text).unwrap();
    let hidden = scene.hiding(&["Wire".to_owned()]).unwrap().at(0.0).unwrap();
    assert_eq!(shown(&hidden), (vec![0.0, 3.0], vec![]));
    // Without anything else, positions are points.
    assert_eq!(shown(&frame("a.obj", b"v 5 0 0\nv 7 0 0\n")).0, [5.0, 7.0]);
    assert!(open("a.obj", b"v 0 0 0\nl 1 2\n").unwrap_err().contains("vertex 2"));
}

#[test]
fn points_of_gltf_nodes_move_come_and_go_with_them() {
    let mut file = Builder::new();
    let positions = file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let colors = file.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let material =
        file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1.0] } }));
    let attributes = json!({ "POSITION": positions, "COLOR_0": colors });
    let points = file.mesh(attributes, json!({ "mode": 0, "material": material }));
    let triangle = file.triangle();
    // Two nodes of the same name.
    file.push("nodes", json!({ "mesh": triangle, "name": "solid" }));
    file.push("nodes", json!({ "mesh": points, "name": "cloud" }));
    file.push("nodes", json!({ "mesh": points, "name": "cloud", "translation": [10.0, 0.0, 0.0] }));
    file.animate(1, "translation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    let scene = file.open().unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    assert_eq!(shown(&scene.at(1.0).unwrap()).0, [5.0, 6.0, 10.0, 11.0]);
    let start = scene.at(0.0).unwrap();
    let run = start.mesh.marks.runs().next().unwrap();
    assert_eq!(start.materials.materials[run.material as usize].base_color.x, 0.5);
    assert_eq!(start.mesh.colors[run.points[1] as usize], Vec4::new(0.0, 1.0, 0.0, 1.0));
    assert_eq!(start.animation_bounds.max.x, 11.0);
    for (name, left) in [("cloud", 0), ("solid", 4)] {
        let hidden = scene.hiding(&[name.to_owned()]).unwrap();
        assert_eq!(shown(&hidden.at(0.0).unwrap()).0.len(), left, "without {name}");
    }
    // The second node is hidden from one second on.
    let input = file.floats(&[[0.0], [1.0]]);
    let output = file.accessor(crate::builder::U8, "SCALAR", 2, &[1, 0]);
    let pointer = json!({ "pointer": "/nodes/1/extensions/KHR_node_visibility/visible" });
    let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": pointer } });
    file.push(
        "animations",
        json!({
            "samplers": [{ "input": input, "output": output, "interpolation": "STEP" }],
            "channels": [{ "sampler": 0, "target": target }]
        }),
    );
    file.json["nodes"][1]["extensions"] = json!({ "KHR_node_visibility": { "visible": true } });
    let scene = file.open().unwrap();
    assert_eq!(shown(&scene.at(0.5).unwrap()).0.len(), 4, "{:?}", scene.warnings());
    assert_eq!(shown(&scene.at(1.0).unwrap()).0, [10.0, 11.0]);
}
