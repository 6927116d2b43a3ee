use glam::{Vec2, Vec3, Vec4};
use serde_json::json;
use umbrage_scene::Ground;

use crate::builder::{Builder, I8, I16, TRIANGLE, U8, U16, U32};

/// A file that shows one mesh, of a primitive with these attributes.
fn shown(mut file: Builder, attributes: serde_json::Value, more: serde_json::Value) -> Builder {
    let mesh = file.mesh(attributes, more);
    file.push("nodes", json!({ "mesh": mesh }));
    file
}

/// Five vertices, whose x coordinate is their index.
fn row(file: &mut Builder) -> usize {
    file.floats(&[0.0, 1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]))
}

#[test]
fn strips_and_fans_become_triangles() {
    let mut file = Builder::new();
    let positions = row(&mut file);
    for (mode, expected) in
        [(4, vec![[0, 1, 2]]), (5, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]), (6, vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]])]
    {
        let file = shown(file.clone(), json!({ "POSITION": positions }), json!({ "mode": mode }));
        let scene = file.open().unwrap();
        assert_eq!(scene.at(0.0).unwrap().mesh.triangles, expected, "mode {mode}");
        // Five vertices are no multiple of three.
        assert_eq!(scene.warnings().len(), usize::from(mode == 4), "{:?}", scene.warnings());
    }
}

#[test]
fn points_and_lines_are_read_in_every_mode() {
    let indices = [4, 1, 3, 1, 0];
    for (mode, points, lines) in [
        (0, &[4.0, 1.0, 3.0, 1.0, 0.0][..], &[][..]),
        // The last vertex is without another one.
        (1, &[], &[[4.0, 1.0], [3.0, 1.0]]),
        (2, &[], &[[4.0, 1.0], [1.0, 3.0], [3.0, 1.0], [1.0, 0.0], [0.0, 4.0]]),
        (3, &[], &[[4.0, 1.0], [1.0, 3.0], [3.0, 1.0], [1.0, 0.0]]),
    ] {
        let mut file = Builder::new();
        let (positions, indices) = (row(&mut file), file.indices(&indices));
        let scene = shown(file, json!({ "POSITION": positions }), json!({ "mode": mode, "indices": indices }));
        let scene = scene.open().unwrap();
        let frame = scene.at(0.0).unwrap();
        assert!(frame.mesh.triangles.is_empty() && frame.check().is_ok());
        assert_eq!(frame.positions.len(), if mode == 1 { 3 } else { 4 }, "unused vertices are left out");
        let x = |vertex: u32| frame.positions[vertex as usize].x;
        assert_eq!(frame.mesh.marks.points().iter().map(|&point| x(point)).collect::<Vec<_>>(), points, "mode {mode}");
        assert_eq!(frame.mesh.marks.lines().iter().map(|line| line.map(x)).collect::<Vec<_>>(), lines, "mode {mode}");
        assert_eq!(scene.warnings().len(), usize::from(mode == 1), "{:?}", scene.warnings());
        assert!(scene.has_marks());
    }
}

#[test]
fn indices_of_all_widths_are_read() {
    for (component, bytes) in
        [(U8, vec![4, 2, 0]), (U16, vec![4, 0, 2, 0, 0, 0]), (U32, vec![4, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0])]
    {
        let mut file = Builder::new();
        let positions = row(&mut file);
        let indices = file.accessor(component, "SCALAR", 3, &bytes);
        let frame = shown(file, json!({ "POSITION": positions }), json!({ "indices": indices })).at(0.0);
        let [corners] = frame.mesh.triangles[..] else { panic!("one triangle") };
        assert_eq!(corners.map(|vertex| frame.positions[vertex as usize].x), [4.0, 2.0, 0.0]);
        assert_eq!(frame.positions.len(), 3, "vertices that no triangle uses are left out");
    }
}

#[test]
fn an_index_beyond_the_vertices_is_refused() {
    let mut file = Builder::new();
    let positions = row(&mut file);
    let indices = file.indices(&[0, 1, 5]);
    let error = shown(file, json!({ "POSITION": positions }), json!({ "indices": indices })).error();
    assert!(error.contains("meshes[0].primitives[0].indices: element 2 is vertex 5, but there are 5"), "{error}");
}

#[test]
fn quantized_positions_and_normals_are_scaled() {
    // Component type, bytes of 100 or of the type's extremes, whether normalized, and the value expected.
    for (component, low, normalized, expected) in [
        (I8, vec![0x80_u8], true, -1.0),
        (I8, vec![127], true, 1.0),
        (I8, vec![100], false, 100.0),
        (U8, vec![255], true, 1.0),
        (U8, vec![100], false, 100.0),
        (I16, vec![0, 0x80], true, -1.0),
        (I16, vec![0xFF, 0x7F], true, 1.0),
        (I16, vec![0x9C, 0xFF], false, -100.0),
        (U16, vec![0xFF, 0xFF], true, 1.0),
        (U16, vec![0x10, 0x27], false, 10_000.0),
    ] {
        let mut file = Builder::new();
        // A stride of 8 or of 4 bytes, with the x of vertex 1 set.
        let stride = if low.len() == 1 { 4 } else { 8 };
        let mut bytes = vec![0; 3 * stride];
        bytes[stride..stride + low.len()].copy_from_slice(&low);
        let positions = file.accessor(component, "VEC3", 3, &bytes);
        file.json["accessors"][positions]["normalized"] = json!(normalized);
        file.json["bufferViews"][0]["byteStride"] = json!(stride);
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let mesh = file.mesh(json!({ "POSITION": positions }), json!({}));
        file.push("nodes", json!({ "mesh": mesh, "scale": [0.5, 1, 1], "translation": [3, 0, 0] }));
        assert_eq!(file.at(0.0).positions[1].x, expected * 0.5 + 3.0, "{component} {normalized}");
    }
}

#[test]
fn interleaved_attributes_are_read_by_their_stride_and_offset() {
    let mut file = Builder::new();
    let mut bytes = vec![0xEE; 4];
    for (number, position) in TRIANGLE.iter().enumerate() {
        let floats = [position[0], position[1], position[2], 0.0, 0.0, 2.0, number as f32, 0.5];
        bytes.extend(floats.iter().flat_map(|value| value.to_le_bytes()));
    }
    let view = file.view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(32);
    let mut attribute = |offset: usize, kind: &str| {
        let accessor =
            json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "type": kind, "count": 3 });
        file.push("accessors", accessor)
    };
    let (positions, normals, coords) = (attribute(4, "VEC3"), attribute(16, "VEC3"), attribute(28, "VEC2"));
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coords });
    let frame = shown(file, attributes, json!({})).at(0.0);
    assert_eq!(frame.positions, TRIANGLE.map(Vec3::from_array));
    assert_eq!(frame.normals, [Vec3::Z; 3], "normals are made of unit length");
    assert_eq!(frame.mesh.tex_coords[0], [0.0, 1.0, 2.0].map(|u| Vec2::new(u, 0.5)));
    assert!(frame.mesh.tex_coords[1].is_empty() && frame.mesh.colors.is_empty() && frame.tangents.is_empty());
}

#[test]
fn sparse_accessors_replace_elements() {
    for with_base in [true, false] {
        let mut file = Builder::new();
        let positions = file.floats(&TRIANGLE);
        let places = file.view(&[0, 2]);
        let values: Vec<u8> =
            [7.0_f32, 8.0, 9.0, -1.0, -2.0, -3.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        let values = file.view(&values);
        file.json["accessors"][positions]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": places, "componentType": U8 },
            "values": { "bufferView": values },
        });
        if !with_base {
            file.json["accessors"][positions].as_object_mut().unwrap().remove("bufferView");
        }
        let frame = shown(file, json!({ "POSITION": positions }), json!({})).at(0.0);
        let middle = if with_base { Vec3::X } else { Vec3::ZERO };
        assert_eq!(frame.positions, [Vec3::new(7.0, 8.0, 9.0), middle, Vec3::new(-1.0, -2.0, -3.0)]);
    }
}

#[test]
fn sparse_places_must_rise_within_range() {
    for places in [[0_u8, 3], [2, 1], [1, 1]] {
        let mut file = Builder::new();
        let positions = file.floats(&TRIANGLE);
        let places = file.view(&places);
        let values = file.view(&[0; 24]);
        file.json["accessors"][positions]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": places, "componentType": U8 },
            "values": { "bufferView": values },
        });
        let error = shown(file, json!({ "POSITION": positions }), json!({})).error();
        assert!(error.contains("accessors[0].sparse.indices"), "{error}");
    }
}

#[test]
fn colors_of_three_and_four_components_are_read() {
    let mut file = Builder::new();
    let positions = file.floats(&TRIANGLE);
    // Each colour is padded to four bytes.
    let colors = file.accessor(U8, "VEC3", 3, &[255, 0, 51, 0, 0, 0, 0, 0, 255, 255, 255, 0]);
    file.json["accessors"][colors]["normalized"] = json!(true);
    file.json["bufferViews"][1]["byteStride"] = json!(4);
    let attributes = json!({ "POSITION": positions, "COLOR_0": colors });
    let frame = shown(file.clone(), attributes, json!({})).at(0.0);
    assert_eq!(frame.mesh.colors, [Vec4::new(1.0, 0.0, 0.2, 1.0), Vec4::new(0.0, 0.0, 0.0, 1.0), Vec4::ONE]);
    let colors = file.floats(&[[0.5; 4], [0.25; 4], [2.0; 4]]);
    let frame = shown(file.clone(), json!({ "POSITION": positions, "COLOR_0": colors }), json!({})).at(0.0);
    assert_eq!(frame.mesh.colors, [Vec4::splat(0.5), Vec4::splat(0.25), Vec4::splat(2.0)]);
    let white = file.floats(&[[1.0; 4]; 3]);
    let frame = shown(file, json!({ "POSITION": positions, "COLOR_0": white }), json!({})).at(0.0);
    assert!(frame.mesh.colors.is_empty(), "all white is as good as none");
}

#[test]
fn parts_without_an_attribute_get_its_neutral_value() {
    let mut file = Builder::new();
    let bare = file.triangle();
    let positions = file.floats(&TRIANGLE);
    let normals = file.floats(&[[0.0, 0.0, 1.0], [0.0; 3], [f32::NAN, 0.0, 0.0]]);
    let tangents = file.floats(&[[2.0, 0.0, 0.0, -1.0], [0.0, 3.0, 0.0, 1.0], [0.0; 4]]);
    let coords = file.floats(&[[0.5; 2]; 3]);
    let colors = file.floats(&[[0.5; 3]; 3]);
    let full = file.mesh(
        json!({ "POSITION": positions, "NORMAL": normals, "TANGENT": tangents, "TEXCOORD_1": coords, "COLOR_0": colors }),
        json!({}),
    );
    file.push("nodes", json!({ "mesh": bare }));
    file.push("nodes", json!({ "mesh": full }));
    let frame = file.at(0.0);
    let zero = Vec3::ZERO;
    assert_eq!(frame.normals, [zero, zero, zero, Vec3::Z, zero, zero], "unusable normals become zero");
    assert_eq!(frame.tangents[..3], [Vec4::ZERO; 3]);
    assert_eq!(frame.tangents[3..], [Vec4::new(1.0, 0.0, 0.0, -1.0), Vec4::new(0.0, 1.0, 0.0, 1.0), Vec4::ZERO]);
    assert!(frame.mesh.tex_coords[0].is_empty());
    assert_eq!(frame.mesh.tex_coords[1][..3], [Vec2::ZERO; 3]);
    assert_eq!(frame.mesh.colors[2..4], [Vec4::ONE, Vec3::splat(0.5).extend(1.0)]);
}

#[test]
fn attributes_of_another_length_are_refused() {
    let mut file = Builder::new();
    let positions = file.floats(&TRIANGLE);
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 4]);
    let error = shown(file, json!({ "POSITION": positions, "NORMAL": normals }), json!({})).error();
    assert!(
        error.contains("meshes[0].primitives[0].attributes.NORMAL: accessors[1] has 4 elements where 3"),
        "{error}"
    );
}

#[test]
fn a_primitive_without_positions_is_left_out_with_a_warning() {
    let mut file = Builder::new();
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 3]);
    let scene = shown(file, json!({ "NORMAL": normals }), json!({})).open().unwrap();
    assert!(scene.at(0.0).unwrap().mesh.triangles.is_empty());
    assert!(scene.warnings()[0].contains("meshes[0].primitives[0] was left out"));
}

#[test]
fn positions_that_are_not_finite_stay_and_are_warned_about() {
    let mut file = Builder::new();
    let positions = file.floats(&[[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    let scene = shown(file, json!({ "POSITION": positions }), json!({})).open().unwrap();
    assert!(scene.warnings()[0].contains("2 vertices have a position that is not finite"), "{:?}", scene.warnings());
    assert_eq!(scene.at(0.0).unwrap().positions.len(), 3);
}

#[test]
fn materials_follow_their_triangles() {
    let mut file = Builder::new();
    let positions = file.floats(&TRIANGLE);
    let attributes = json!({ "POSITION": positions });
    for name in ["red", "blue"] {
        file.push("materials", json!({ "name": name, "pbrMetallicRoughness": { "metallicFactor": 0.25 } }));
    }
    file.push(
        "meshes",
        json!({ "primitives": [
            { "attributes": attributes, "material": 1 },
            { "attributes": attributes },
            { "attributes": attributes, "material": 0 },
        ] }),
    );
    file.push("nodes", json!({ "mesh": 0 }));
    let frame = file.at(0.0);
    assert_eq!(frame.mesh.material_of_triangle, [1, 2, 0]);
    let [red, blue, default] = &frame.materials.materials[..] else { panic!("two materials and the default") };
    assert_eq!([red.name.as_str(), blue.name.as_str(), default.name.as_str()], ["red", "blue", ""]);
    assert_eq!((default.metallic, default.roughness), (1.0, 1.0));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(9);
    assert!(file.error().contains("meshes[0].primitives[0].material: index 9 is out of range"));
}

#[test]
fn objects_are_nodes_by_their_names_or_their_meshes() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("nodes", json!({ "mesh": mesh, "name": "wheel" }));
    file.push("nodes", json!({ "mesh": mesh, "name": "" }));
    file.push("nodes", json!({ "mesh": mesh, "name": "wheel" }));
    let names = |file: &Builder| {
        let mesh = &file.at(0.0).mesh;
        let of = |triangle| mesh.objects.names()[mesh.objects.of_triangle(triangle).unwrap() as usize].to_string();
        (0..mesh.triangles.len() as u32).map(of).collect::<Vec<_>>()
    };
    assert_eq!(names(&file), ["node 0", "wheel", "node 2", "wheel"]);
    file.json["meshes"][0]["name"] = json!("disk");
    assert_eq!(names(&file), ["disk", "wheel", "disk", "wheel"]);
}

#[test]
fn a_ground_is_an_object_of_its_own() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh, "name": "wheel" }));
    let mut scene = file.open().unwrap();
    scene.set_ground(Some(Ground::default()));
    let objects = &scene.at(0.0).unwrap().mesh.objects;
    let of: Vec<_> =
        (0..3).map(|triangle| &*objects.names()[objects.of_triangle(triangle).unwrap() as usize]).collect();
    assert_eq!(of, ["wheel", "ground", "ground"]);
}
