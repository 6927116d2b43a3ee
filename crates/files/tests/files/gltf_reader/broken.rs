use proptest::prelude::*;
use serde_json::{Value, json};
use umbrage_files::{Clip, OpenOptions};

use crate::builder::{Builder, U8, open_bytes, open_in};

/// A little of everything: a skinned, morphed and animated triangle, an instanced one, a camera, a light and a texture.
fn everything() -> Builder {
    let mut file = Builder::new();
    let positions = file.floats(&crate::builder::TRIANGLE);
    let normals = file.floats(&[[0.0, 0.0, 1.0]; 3]);
    let joints = file.accessor(U8, "VEC4", 3, &[0; 12]);
    let weights = file.floats(&[[1.0, 0.0, 0.0, 0.0]; 3]);
    let indices = file.indices(&[0, 1, 2]);
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let targets = json!([{ "POSITION": normals }]);
    file.mesh(attributes, json!({ "indices": indices, "targets": targets, "material": 0 }));
    file.triangle();
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": positions } } });
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "children": [1, 2] },
        { "camera": 0, "extensions": light },
        { "mesh": 1, "extensions": instances },
    ]);
    file.json["skins"] = json!([{ "joints": [1] }]);
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let view = file.view(b"not an image");
    file.json["images"] = json!([{ "bufferView": view }]);
    file.json["textures"] = json!([{ "source": 0 }]);
    file.json["materials"] = json!([{ "emissiveTexture": { "index": 0 } }]);
    file.animate(1, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);
    file.animate(0, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    file
}

/// Opens a possibly broken file, poses and checks it if it opens, and returns whether it does.
fn survives(name: &str, bytes: &[u8]) -> bool {
    match open_bytes(name, bytes, Clip::Auto) {
        Ok(scene) => {
            let frame = scene.at(0.5).unwrap();
            assert!(
                frame.mesh.triangles.as_flattened().iter().all(|&vertex| (vertex as usize) < frame.positions.len())
            );
            true
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(name), "{text}");
            false
        }
    }
}

#[test]
fn the_unbroken_file_opens_in_both_forms() {
    assert!(survives("scene.glb", &everything().glb()));
    assert!(survives("scene.gltf", &everything().gltf()));
}

#[test]
fn files_cut_off_anywhere_are_refused() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.animate(0, "scale", "LINEAR", &[0.0], &[[1.0; 3]]);
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("scene.glb", file.glb()), ("scene.gltf", file.gltf())] {
        assert!(open_in(folder.path(), name, &bytes, Clip::Auto).is_ok());
        let path = folder.path().join(name);
        let on_disk = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
        for length in (0..bytes.len()).rev() {
            on_disk.set_len(length as u64).unwrap();
            assert!(umbrage_files::open(&path).is_err(), "{length} of {} bytes", bytes.len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_bytes_never_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)) {
        let mut glb = everything().glb();
        for (place, byte) in &changes {
            let place = place.index(glb.len());
            glb[place] = *byte;
        }
        survives("scene.glb", &glb);
        let mut gltf = everything().gltf();
        for (place, byte) in &changes {
            let place = place.index(gltf.len());
            gltf[place] = *byte;
        }
        survives("scene.gltf", &gltf);
    }

    #[test]
    fn changed_numbers_never_panic(
        place in any::<prop::sample::Index>(),
        number in prop::sample::select(vec![
            json!(-1), json!(0), json!(1), json!(2), json!(7), json!(255), json!(65_536), json!(2_147_483_648_u64),
            json!(4_294_967_295_u64), json!(4_294_967_296_u64), json!(u64::MAX), json!(1e30), json!(1e300), json!(1e-30),
            json!("x"), json!([]), json!({}), json!(null),
        ]),
    ) {
        let mut file = everything();
        let mut numbers = Vec::new();
        paths_of_numbers(&file.json, String::new(), &mut numbers);
        let path = &numbers[place.index(numbers.len())];
        *file.json.pointer_mut(path).unwrap() = number;
        survives("scene.glb", &file.glb());
    }
}

/// The JSON pointers of all numbers.
fn paths_of_numbers(value: &Value, path: String, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path),
        Value::Array(elements) => {
            for (number, element) in elements.iter().enumerate() {
                paths_of_numbers(element, format!("{path}/{number}"), found);
            }
        }
        Value::Object(members) => {
            for (name, member) in members {
                paths_of_numbers(member, format!("{path}/{name}"), found);
            }
        }
        _ => {}
    }
}

#[test]
fn required_extensions_that_are_unknown_are_refused_by_name() {
    let mut file = everything();
    file.json["extensionsRequired"] = json!(["KHR_texture_transform", "EXT_lights_image_based"]);
    let error = file.error();
    assert!(
        error.contains("scene.glb: the glTF extension `EXT_lights_image_based`, which the file requires"),
        "{error}"
    );
    // Extensions without visible effect may be required; if only used, they cause no warning.
    file.json["extensionsRequired"] = json!(["KHR_xmp_json_ld"]);
    let warnings = file.open().unwrap().warnings().to_vec();
    assert!(warnings[0].contains("`KHR_xmp_json_ld`, which changes nothing in a picture"), "{warnings:?}");
    file.json["extensionsRequired"] = json!([]);
    file.json["extensionsUsed"] = json!(["KHR_xmp_json_ld", "KHR_materials_subsurface", "KHR_texture_transform"]);
    let warnings = file.open().unwrap().warnings().to_vec();
    assert_eq!(warnings.iter().filter(|warning| warning.contains("extension")).count(), 1, "{warnings:?}");
    assert!(warnings[0].contains("`KHR_materials_subsurface`"));
}

#[test]
fn hierarchies_with_rings_or_two_parents_are_refused() {
    let with_children = |children: [&[usize]; 3]| {
        let mut file = Builder::new();
        for children in children {
            file.push("nodes", json!({ "children": children }));
        }
        file.error()
    };
    let ring = with_children([&[], &[2], &[1]]);
    assert!(ring.contains("nodes[1]: the node is below itself"), "{ring}");
    let own_child = with_children([&[0], &[], &[]]);
    assert!(own_child.contains("nodes[0]: the node is below itself"), "{own_child}");
    let two_parents = with_children([&[2], &[2], &[]]);
    assert!(two_parents.contains("nodes[1].children[0]: node 2 is a child of node 0 already"), "{two_parents}");
    let twice = with_children([&[1, 1], &[], &[]]);
    assert!(twice.contains("nodes[0].children[1]"), "{twice}");
    let missing = with_children([&[3], &[], &[]]);
    assert!(missing.contains("nodes[0].children[0]: index 3 is out of range: `nodes` has 3"), "{missing}");
}

#[test]
fn errors_name_the_place() {
    let at = |path: &str, value: Value| {
        let mut file = everything();
        *file.json.pointer_mut(path).unwrap() = value;
        file.error()
    };
    for (path, value, expected) in [
        ("/nodes/0/mesh", json!(5), "nodes[0].mesh: index 5 is out of range: `meshes` has 2 elements"),
        ("/nodes/0/skin", json!(5), "nodes[0].skin: index 5"),
        ("/nodes/1/camera", json!(5), "nodes[1].camera: index 5"),
        ("/skins/0/joints/0", json!(5), "skins[0].joints[0]: index 5"),
        ("/accessors/0/bufferView", json!(99), "accessors[0].bufferView: index 99"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer: index 1"),
        ("/bufferViews/0/byteLength", json!(99_999), "bufferViews[0]: 99999 bytes from byte 0 on reach beyond"),
        ("/accessors/0/count", json!(4_000_000_000_u64), "accessors[0]: 4000000000 elements of 12 bytes"),
        ("/accessors/0/componentType", json!(5124), "accessors[0]: componentType or type"),
        ("/accessors/0/type", json!("VEC2"), "accessors[0]: its elements don't have 3 components"),
        ("/textures/0/source", json!(3), "textures[0].source: index 3"),
        ("/meshes/0/primitives/0/indices", json!(77), "meshes[0].primitives[0].indices: index 77"),
        ("/asset/version", json!("3.0"), "glTF 3.0 is not supported"),
        ("/asset/version", json!("1.0"), "glTF 1.0 is not supported"),
        ("/animations/0/channels/0/target/node", json!(9), "animations[0].channels[0].target.node: index 9"),
    ] {
        let error = at(path, value);
        assert!(error.contains(expected), "{path}: {error}");
    }
}

#[test]
fn json_that_is_broken_is_refused_with_its_line() {
    let error = open_bytes("a.gltf", b"{\n  \"asset\": { \"version\": \"2.0\" },\n  \"nodes\": [,]\n}", Clip::Auto)
        .unwrap_err();
    assert!(error.to_string().contains("a.gltf: JSON: ") && error.to_string().contains("line 3"), "{error}");
    assert!(open_bytes("a.gltf", b"", Clip::Auto).is_err());
    assert!(open_bytes("a.gltf", "[".repeat(100_000).as_bytes(), Clip::Auto).is_err());
    let marked = [b"\xEF\xBB\xBF".as_slice(), &everything().gltf()].concat();
    assert!(survives("a.gltf", &marked), "a byte order mark is skipped");
}

#[test]
fn chunks_of_a_glb_are_checked() {
    let glb = everything().glb();
    let changed = |at: usize, word: u32| {
        let mut glb = glb.clone();
        glb[at..at + 4].copy_from_slice(&word.to_le_bytes());
        open_bytes("a.glb", &glb, Clip::Auto).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(changed(4, 1).unwrap_err().contains("version 1 of GLB"));
    assert!(changed(8, u32::MAX).unwrap_err().contains("cut off"));
    assert!(changed(8, 0).unwrap_err().contains("there is no JSON chunk"));
    assert!(changed(12, u32::MAX).unwrap_err().contains("byte 12"));
    assert!(changed(16, 0).unwrap_err().contains("there is no JSON chunk"));
    // Chunks of unknown kinds are skipped.
    let mut longer = glb.clone();
    longer.extend_from_slice(&[4, 0, 0, 0]);
    longer.extend_from_slice(b"MORE\0\0\0\0");
    let length = (longer.len() as u32).to_le_bytes();
    longer[8..12].copy_from_slice(&length);
    assert!(survives("a.glb", &longer));
}

#[test]
fn chunks_without_padding_are_read_with_a_warning() {
    let file = everything();
    let mut json = file.json.clone();
    json["buffers"] = json!([{ "byteLength": file.bytes.len() }]);
    for blanks in 0..4 {
        let text = format!("{json}{}", " ".repeat(blanks));
        let (text, binary) = (text.as_bytes(), &file.bytes[..]);
        let words = [2, (28 + text.len() + binary.len()) as u32, text.len() as u32].map(u32::to_le_bytes).concat();
        let length = (binary.len() as u32).to_le_bytes();
        let glb = [b"glTF", &words[..], b"JSON", text, &length, b"BIN\0", binary].concat();
        let scene = open_bytes("a.glb", &glb, Clip::Auto).unwrap();
        assert_eq!(scene.at(0.0).unwrap().positions.len(), 12);
        let is_warned = scene.warnings().iter().any(|warning| warning.contains("is not padded to four"));
        assert_eq!(is_warned, !text.len().is_multiple_of(4), "{:?}", scene.warnings());
    }
}

#[test]
fn extras_may_be_anything() {
    for extras in [json!(42), json!("text"), json!([1, 2]), json!(null), json!({ "a": { "b": true } })] {
        let mut file = everything();
        for pointer in ["", "/asset", "/nodes/0", "/meshes/0/primitives/0", "/materials/0", "/skins/0", "/accessors/0"]
        {
            file.json.pointer_mut(pointer).unwrap()["extras"] = extras.clone();
        }
        assert_eq!(file.at(0.5).positions, everything().at(0.5).positions, "{extras}");
    }
    // The error behind them is reported.
    let mut file = everything();
    file.json["asset"]["extras"] = json!(42);
    file.json["nodes"][0]["mesh"] = json!("first");
    assert!(file.error().contains("first"), "{}", file.error());
}

#[test]
fn whole_numbers_may_have_a_fraction_or_an_exponent() {
    let file = everything();
    let text = String::from_utf8(file.gltf()).unwrap();
    let written = |count: &str| text.replace("\"count\":3", &format!("\"count\":{count}")).into_bytes();
    for count in ["3.0", "3e0", "0.3E+1", "30e-1"] {
        assert_ne!(written(count), text.as_bytes());
        assert!(survives("a.gltf", &written(count)), "{count}");
    }
    for count in ["3.5", "-3.0", "3e99"] {
        assert!(!survives("a.gltf", &written(count)), "{count}");
    }
}

#[test]
fn files_whose_names_differ_in_case_alone_are_found_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = everything();
    let mut json = file.json.clone();
    json["buffers"] = json!([{ "byteLength": file.bytes.len(), "uri": "Scene%20A.BIN" }]);
    std::fs::write(folder.path().join("scene a.bin"), &file.bytes).unwrap();
    let scene = open_in(folder.path(), "a.gltf", json.to_string().as_bytes(), Clip::Auto).unwrap();
    let warning = "`Scene A.BIN` is not there; `scene a.bin` was read";
    assert!(scene.warnings().iter().any(|found| found.starts_with(warning)), "{:?}", scene.warnings());
}

#[test]
fn buffers_come_from_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = everything();
    let open = |uri: &str, length: usize| {
        let mut json = file.json.clone();
        json["buffers"] = json!([{ "byteLength": length, "uri": uri }]);
        let opened = open_in(folder.path(), "a.gltf", json.to_string().as_bytes(), Clip::Auto);
        opened.map(|_| ()).map_err(|error| error.to_string())
    };
    std::fs::write(folder.path().join("a b.bin"), &file.bytes).unwrap();
    std::fs::write(folder.path().join("100%.bin"), &file.bytes).unwrap();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    assert_eq!(open("a%20b.bin", file.bytes.len()), Ok(()));
    assert_eq!(open("100%.bin", file.bytes.len()), Ok(()), "a per cent sign without digits");
    let error = |uri: &str| open(uri, file.bytes.len()).unwrap_err();
    assert!(open("a%20b.bin", file.bytes.len() + 1).unwrap_err().contains("buffers[0]: byteLength is"));
    assert!(error("missing.bin").contains("buffers[0].uri: ") && error("missing.bin").contains("missing.bin"));
    assert!(error("folder").contains("not a regular file"));
    for (uri, cause) in [
        ("https://host/a.bin", "`https:`"),
        ("C:\\a.bin", "`C:`"),
        ("/a.bin", "outside of the scene's folder"),
        ("%2fetc/a.bin", "outside"),
        ("\\\\host\\a.bin", "outside"),
        ("../a.bin", "outside"),
        ("folder/%2e%2e%2f../a.bin", "outside"),
        ("data:nothing", "comma"),
        ("data:;base64,Zm9?", "base64"),
        ("data:;base64,Z", "base64"),
        ("a%FF", "UTF-8"),
        ("", "empty"),
    ] {
        assert!(error(uri).contains(cause), "{uri}: {}", error(uri));
    }
}

#[test]
fn files_outside_of_the_folder_are_read_where_that_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = everything();
    std::fs::write(folder.path().join("a.bin"), &file.bytes).unwrap();
    file.json["buffers"] = json!([{ "byteLength": file.bytes.len(), "uri": "../a.bin" }]);
    std::fs::create_dir(folder.path().join("scene")).unwrap();
    let path = folder.path().join("scene/a.gltf");
    std::fs::write(&path, file.json.to_string()).unwrap();
    let error = umbrage_files::open(&path).unwrap_err().to_string();
    assert!(error.contains("--allow-outside"), "{error}");
    let options = OpenOptions { allow_outside: true, ..OpenOptions::default() };
    umbrage_files::open_with(&path, &options).expect("a trusted scene");
}

#[test]
#[cfg(unix)]
fn pipes_are_refused_before_they_wait() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = everything();
    file.json["buffers"] = json!([{ "byteLength": file.bytes.len(), "uri": "pipe.ply" }]);
    let made = std::process::Command::new("mkfifo").arg(folder.path().join("pipe.ply")).status();
    assert!(made.expect("mkfifo").success());
    let error = open_in(folder.path(), "a.gltf", file.json.to_string().as_bytes(), Clip::Auto).unwrap_err();
    assert!(error.to_string().ends_with("pipe.ply: not a regular file"), "{error}");
    let error = umbrage_files::open(folder.path().join("pipe.ply")).unwrap_err();
    assert!(error.to_string().ends_with("pipe.ply: not a regular file"), "{error}");
}

#[test]
fn data_uris_have_as_many_bytes_as_they_spell() {
    let mut file = everything();
    // The base64 is that of RFC 4648 §10; padding may be missing.
    for (uri, bytes) in [
        ("data:;base64,", 0),
        ("data:;base64,Zg==", 1),
        ("data:;base64,Zm8=", 2),
        ("data:;base64,Zm8", 2),
        ("data:;base64,Zm9v", 3),
        ("data:application/octet-stream;base64,Zm9vYg", 4),
        ("data:text/plain,a%00b", 3),
    ] {
        file.json["buffers"] = json!([{ "byteLength": 99, "uri": uri }]);
        let error = open_bytes("a.gltf", file.json.to_string().as_bytes(), Clip::Auto).unwrap_err().to_string();
        assert!(error.contains(&format!("there are only {bytes} bytes")), "{uri}: {error}");
    }
}

#[test]
fn a_missing_file_is_an_error() {
    let error = umbrage_files::open("nowhere/scene.glb").unwrap_err().to_string();
    assert!(error.contains("nowhere"), "{error}");
}

#[test]
fn absurd_expansions_are_refused_before_memory_is_taken() {
    // A thousand copies of each of 300,000 copies.
    let mut file = Builder::new();
    let positions = file.floats(&[[0.0; 3]; 1000]);
    let indices = file.indices(&(0..999).collect::<Vec<_>>());
    let mesh = file.mesh(json!({ "POSITION": positions }), json!({ "indices": indices }));
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": positions } } });
    file.json["nodes"] = json!(vec![json!({ "mesh": mesh, "extensions": instances }); 1000]);
    assert!(file.error().contains("triangles, which is more than"), "{}", file.error());
    // Zeros without bytes.
    let mut file = Builder::new();
    let zeros = file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 1_u64 << 40 }));
    let mesh = file.mesh(json!({ "POSITION": zeros }), json!({}));
    file.push("nodes", json!({ "mesh": mesh }));
    assert!(file.error().contains("there are no bytes for its 1099511627776 elements"), "{}", file.error());
    // A keyframe for every zero, in a hundred channels.
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    let many = file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 1 << 20 }));
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "scale" } });
    file.push("animations", json!({ "channels": vec![channel; 100], "samplers": [{ "input": many, "output": many }] }));
    assert!(file.error().contains("keyframes"), "{}", file.error());
}

#[test]
fn lights_and_cameras_that_are_nowhere_name_their_node() {
    let scene = |thing: Value, scale: f32| {
        let mut file = Builder::new();
        let mesh = file.triangle();
        file.push("nodes", json!({ "children": [1], "scale": [scale, scale, scale] }));
        let mut node = json!({ "mesh": mesh, "name": "far", "translation": [0, 1e20, 0] });
        node.as_object_mut().unwrap().extend(thing.as_object().unwrap().clone());
        file.push("nodes", node);
        file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }));
        let lights = json!([{ "type": "point", "intensity": 1 }, { "type": "directional", "intensity": 1e39 }]);
        file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
        file
    };
    let light = |index: u32| json!({ "extensions": { "KHR_lights_punctual": { "light": index } } });
    for (thing, words) in [
        (json!({ "camera": 0 }), "the camera `far`: its position or an axis is not finite"),
        (light(0), "the light `far`: its position is not finite"),
        (light(1), "the light `far`: its colour or intensity is not finite"),
    ] {
        let error = scene(thing.clone(), 1e20).error();
        assert!(error.contains(&format!("scene.glb: nodes[1]: at 0 seconds, of {words}")), "{error}");
        // At rest its position is finite.
        let mut file = scene(thing.clone(), 1.0);
        file.animate(0, "scale", "LINEAR", &[0.0, 1.0], &[[1.0; 3], [1e25; 3]]);
        let error = file.error();
        assert!(error.contains("scene.glb: nodes[1]: at 0") && error.contains(words), "{error}");
    }
    scene(light(0), 1.0).at(0.0).check().expect("a light that is somewhere");
}

#[test]
fn numbers_of_materials_are_finite() {
    let scene = |material: Value| {
        let mut file = Builder::new();
        let mesh = file.triangle();
        file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
        file.push("nodes", json!({ "mesh": mesh }));
        file.push("materials", material);
        file
    };
    let error = scene(json!({ "pbrMetallicRoughness": { "roughnessFactor": 1e39 } })).error();
    assert!(error.contains("scene.glb: materials[0]: one of its numbers is not finite"), "{error}");
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 1e30 } });
    let frame = scene(json!({ "emissiveFactor": [1e30, 0, 1], "extensions": strength })).at(0.0);
    assert_eq!(frame.materials.materials[0].emissive.to_array(), [f32::MAX, 0.0, 1e30]);
}

#[test]
fn scenes_as_large_as_numbers_are_lit_from_somewhere() {
    let mut file = Builder::new();
    let positions = file.floats(&[[-3e38, -3e38, -3e38], [3e38, -3e38, 0.0], [0.0, 3e38, 3e38]]);
    let mesh = file.mesh(json!({ "POSITION": positions }), json!({}));
    file.push("nodes", json!({ "mesh": mesh }));
    file.at(0.0).check().expect("a light that is somewhere");
    file.push("nodes", json!({ "camera": 0 }));
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }));
    file.at(0.0).check().expect("a light beside the camera");
}
