//! Material variants, hidden nodes, and animations whose target is a path.

use serde_json::{Value, json};
use umbrage_files::OpenOptions;
use umbrage_rays::{LightSource, Projection};
use umbrage_scene::{Alpha, Error, Scene};

use crate::builder::{Builder, U8};

/// A triangle whose material is red, blue in the variant `sea`, and unchanged in `sand`.
fn with_variants() -> Builder {
    const NAME: &str = "KHR_materials_variants";
    let mut file = Builder::new();
    let mappings = json!([{ "material": 1, "variants": [1] }, { "material": 0, "variants": [0] }]);
    let positions = file.floats(&crate::builder::TRIANGLE);
    let more = json!({ "material": 0, "extensions": { NAME: { "mappings": mappings } } });
    let mesh = file.mesh(json!({ "POSITION": positions }), more);
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("materials", json!({ "name": "red" }));
    file.push("materials", json!({ "name": "blue" }));
    file.json["extensions"] = json!({ NAME: { "variants": [{ "name": "sand" }, { "name": "sea" }] } });
    file.json["extensionsRequired"] = json!([NAME]);
    file
}

fn open_variant(file: &Builder, variant: Option<&str>) -> Result<Scene, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shoe.glb");
    std::fs::write(&path, file.glb()).unwrap();
    umbrage_files::open_with(path, &OpenOptions { variant: variant.map(str::to_owned), ..OpenOptions::default() })
}

#[test]
fn a_variant_has_its_materials() {
    let file = with_variants();
    for (variant, material) in [(None, 0), (Some("sand"), 0), (Some("sea"), 1)] {
        let scene = open_variant(&file, variant).unwrap();
        assert_eq!(scene.variants(), ["sand", "sea"]);
        assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
        assert_eq!(scene.at(0.0).unwrap().mesh.material_of_triangle, [material], "{variant:?}");
    }
    let error = |file: &Builder, variant| open_variant(file, Some(variant)).unwrap_err().to_string();
    let unknown = error(&file, "wood");
    assert!(unknown.contains("shoe.glb: there is no variant `wood`; the file has `sand`, `sea`"), "{unknown}");
    let mut none = Builder::new();
    none.triangle();
    assert!(error(&none, "sea").contains("there is no variant `sea`, as the file has none"));
    let mut broken = with_variants();
    broken.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"] = json!({ "mappings": 5 });
    let text = error(&broken, "sea");
    assert!(text.contains("meshes[0].primitives[0].extensions.KHR_materials_variants: "), "{text}");
    let mut missing = with_variants();
    missing.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
        json!(9);
    assert!(error(&missing, "sea").contains("meshes[0].primitives[0].material: index 9"));
}

/// The target of a channel with a pointer.
fn target(pointer: &str) -> Value {
    json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } })
}

fn hidden() -> Value {
    json!({ "KHR_node_visibility": { "visible": false } })
}

#[test]
fn hidden_nodes_hide_what_is_below_but_no_cameras() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.json["extensionsRequired"] = json!(["KHR_node_visibility", "KHR_lights_punctual"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } });
    let camera = file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }));
    let light = json!({ "KHR_lights_punctual": { "light": 0 }, "KHR_node_visibility": { "visible": true } });
    file.push("nodes", json!({ "mesh": mesh, "children": [1], "extensions": hidden() }));
    file.push("nodes", json!({ "mesh": mesh, "camera": camera, "extensions": light }));
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 0, 7] }));
    let frame = file.at(0.0);
    assert_eq!((frame.mesh.triangles.len(), frame.cameras.len(), frame.positions[0].z), (1, 1, 7.0));
    assert_ne!(&*frame.lights[0].name, "lamp");
    file.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = json!(true);
    let frame = file.at(0.0);
    assert_eq!((frame.mesh.triangles.len(), frame.cameras.len()), (3, 1));
    assert_eq!(&*frame.lights[0].name, "lamp");
}

/// Three triangles. The first and its child blink: hidden at rest, visible from 0.5 s to 1 s.
fn blinking() -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh, "children": [1], "extensions": hidden() }));
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 0, 1] }));
    file.push("nodes", json!({ "mesh": mesh, "translation": [0, 0, 2] }));
    let (input, output) = (file.floats(&[[0.0], [0.5], [1.0]]), file.accessor(U8, "SCALAR", 3, &[0, 1, 0]));
    let channel = json!({ "sampler": 0, "target": target("/nodes/0/extensions/KHR_node_visibility/visible") });
    let sampler = json!({ "input": input, "output": output, "interpolation": "STEP" });
    file.push("animations", json!({ "name": "blink", "channels": [channel], "samplers": [sampler] }));
    file.json["extensionsRequired"] = json!(["KHR_node_visibility", "KHR_animation_pointer"]);
    file
}

#[test]
fn animations_hide_and_show_nodes() {
    let scene = blinking().open().unwrap();
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    assert_eq!((scene.animations().len(), scene.duration_seconds()), (1, 1.0));
    let depths = |seconds: f64| {
        let frame = scene.at(seconds).unwrap();
        frame.check().unwrap();
        assert_eq!(frame.mesh.part_of_triangle.len(), frame.mesh.triangles.len());
        frame.mesh.triangles.iter().map(|corners| frame.positions[corners[0] as usize].z).collect::<Vec<_>>()
    };
    for (seconds, visible) in
        [(0.0, &[2.0][..]), (0.49, &[2.0]), (0.5, &[0.0, 1.0, 2.0]), (0.99, &[0.0, 1.0, 2.0]), (1.0, &[2.0])]
    {
        assert_eq!(depths(seconds), visible, "at {seconds} s");
    }
    // Objects that hide and show keep their number.
    let objects = |seconds: f64| {
        let mesh = scene.at(seconds).unwrap().mesh;
        assert_eq!(mesh.objects.names().iter().map(|name| &**name).collect::<Vec<_>>(), ["node 0", "node 1", "node 2"]);
        (0..mesh.triangles.len() as u32).map(|triangle| mesh.objects.of_triangle(triangle).unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((objects(0.0), objects(0.5)), (vec![2], vec![0, 1, 2]));
    // While visibility doesn't change, the mesh is the same, and needn't be prepared anew.
    let mesh = |seconds: f64| scene.at(seconds).unwrap().mesh;
    assert!(std::sync::Arc::ptr_eq(&mesh(0.1), &mesh(0.2)) && std::sync::Arc::ptr_eq(&mesh(0.6), &mesh(0.7)));
    let at_rest = blinking().open_clip(umbrage_files::Clip::Rest).unwrap();
    assert_eq!(at_rest.at(0.7).unwrap().mesh.triangles.len(), 1);
}

#[test]
fn pointers_to_transforms_are_as_plain_channels() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.animate(0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0_f32; 3], [0.0, 0.0, 6.0]]);
    file.json["animations"][0]["channels"][0]["target"] = target("/nodes/0/translation");
    let other = json!({ "sampler": 0, "target": target("/materials/0/doubleSided") });
    file.json["animations"][0]["channels"].as_array_mut().unwrap().push(other);
    file.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    assert_eq!(file.at(0.5).positions[0].z, 3.0);
    let warnings = file.open().unwrap().warnings().to_vec();
    let left_out = "animations[0].channels[1] was left out: what it moves, `/materials/0/doubleSided`, is not animated";
    assert_eq!(warnings, [left_out]);
    file.json["animations"][0]["channels"][0]["target"] = target("/nodes/5/translation");
    assert!(file.error().contains("animations[0].channels[0].target.node: index 5"), "{}", file.error());
    let mut file = blinking();
    file.json["animations"][0]["channels"][0]["target"] = target("/nodes/9/extensions/KHR_node_visibility/visible");
    assert!(file.error().contains("animations[0].channels[0].target: index 9"), "{}", file.error());
    file = blinking();
    file.json["animations"][0]["channels"][0]["sampler"] = json!(4);
    assert!(file.error().contains("animations[0].channels[0].sampler: index 4"), "{}", file.error());
}

#[test]
fn lights_and_cameras_are_animated() {
    let mut file = Builder::new();
    file.triangle();
    let spot = json!({ "type": "spot", "intensity": 5, "spot": { "outerConeAngle": 0.5 } });
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }, spot] } });
    let cameras = [
        json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }),
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9 } }),
    ];
    for (number, camera) in cameras.into_iter().enumerate() {
        file.push("cameras", camera);
        let light = json!({ "KHR_lights_punctual": { "light": number } });
        file.push("nodes", json!({ "camera": number, "extensions": light }));
    }
    let input = file.floats(&[[0.0], [1.0]]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    let red = file.floats(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let lights = "/extensions/KHR_lights_punctual/lights";
    for (pointer, output) in [
        (format!("{lights}/0/color"), red),
        (format!("{lights}/0/range"), file.floats(&[[4.0], [8.0]])),
        (format!("{lights}/1/intensity"), file.floats(&[[5.0], [15.0]])),
        (format!("{lights}/1/spot/outerConeAngle"), file.floats(&[[0.5], [1.5]])),
        (format!("{lights}/1/spot/innerConeAngle"), file.floats(&[[0.25], [0.75]])),
        ("/cameras/0/perspective/yfov".to_owned(), file.floats(&[[0.5], [1.5]])),
        ("/cameras/1/orthographic/ymag".to_owned(), file.floats(&[[2.0], [4.0]])),
    ] {
        channels.push(json!({ "sampler": samplers.len(), "target": target(&pointer) }));
        samplers.push(json!({ "input": input, "output": output }));
    }
    file.push("animations", json!({ "channels": channels, "samplers": samplers }));
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_animation_pointer"]);
    let scene = file.open().unwrap();
    assert!(scene.warnings().iter().all(|warning| warning.contains("no triangles")), "{:?}", scene.warnings());
    let frame = scene.at(0.5).unwrap();
    let [point, spot] = frame.lights.as_slice() else { panic!("two lights") };
    assert_eq!((point.color.to_array(), point.range, point.intensity), ([0.5, 0.5, 0.0], Some(6.0), 1.0));
    let LightSource::Spot { inner_radians, outer_radians, .. } = spot.source else { panic!("a spot") };
    assert_eq!((spot.intensity, inner_radians, outer_radians), (10.0, 0.5, 1.0));
    let projections: Vec<_> = frame.cameras.iter().map(|named| named.camera.projection).collect();
    let perspective = Projection::Perspective { tan_half_height: 0.5_f32.tan() };
    assert_eq!(projections, [perspective, Projection::Orthographic { half_height: 3.0 }]);
    file.json["animations"][0]["channels"][0]["sampler"] = json!(2);
    assert!(
        file.error().contains("animations[0].samplers[2]") || file.error().contains("accessors["),
        "{}",
        file.error()
    );
}

#[test]
fn materials_are_animated() {
    let mut file = Builder::new();
    let positions = file.floats(&crate::builder::TRIANGLE);
    let mesh = file.mesh(json!({ "POSITION": positions }), json!({ "material": 1 }));
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("materials", json!({ "emissiveFactor": [0.5, 0.5, 0.5] }));
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 4 } });
    file.push("materials", json!({ "alphaMode": "MASK", "emissiveFactor": [1, 1, 1], "extensions": strength }));
    let input = file.floats(&[[0.0], [1.0]]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for (path, output) in [
        ("emissiveFactor", file.floats(&[[1.0, 1.0, 1.0], [0.0, 0.5, 1.0]])),
        ("pbrMetallicRoughness/baseColorFactor", file.floats(&[[1.0, 1.0, 1.0, 1.0], [0.0, 0.5, 1.0, 0.5]])),
        ("pbrMetallicRoughness/roughnessFactor", file.floats(&[[1.0], [0.0]])),
        ("alphaCutoff", file.floats(&[[0.25], [0.75]])),
        ("extensions/KHR_materials_ior/ior", file.floats(&[[1.0], [2.0]])),
    ] {
        channels.push(json!({ "sampler": samplers.len(), "target": target(&format!("/materials/1/{path}")) }));
        samplers.push(json!({ "input": input, "output": output }));
    }
    file.push("animations", json!({ "channels": channels, "samplers": samplers }));
    file.json["extensionsRequired"] = json!(["KHR_animation_pointer", "KHR_materials_emissive_strength"]);
    let scene = file.open().unwrap();
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let material = |seconds: f64, number: usize| scene.at(seconds).unwrap().materials.materials[number].clone();
    let half = material(0.5, 1);
    assert_eq!(half.emissive.to_array(), [2.0, 3.0, 4.0], "times the strength");
    assert_eq!(half.base_color.to_array(), [0.5, 0.75, 1.0, 0.75]);
    assert_eq!((half.roughness, half.ior, half.alpha), (0.5, 1.5, Alpha::Mask { cutoff: 0.5 }));
    assert_eq!(material(0.5, 0), material(0.0, 0));
    assert_eq!(material(0.0, 1).emissive.to_array(), [4.0; 3]);
    file.json["animations"][0]["channels"][0]["target"] = target("/materials/2/emissiveFactor");
    assert!(file.error().contains("animations[0].channels[0].target: index 2"), "{}", file.error());
}

/// All of these in one file as other programs might write it.
#[test]
fn a_file_with_variants_and_pointers_is_as_the_plain_one() {
    let (file, plain) = (super::compressed::scene("variants"), super::compressed::scene("plain"));
    assert!(file.warnings().is_empty(), "{:?}", file.warnings());
    assert_eq!(file.variants(), ["clay", "blue"]);
    assert_eq!(file.duration_seconds(), plain.duration_seconds());
    for (seconds, triangles) in [(0.1, 160), (0.3, 144), (0.9, 160)] {
        let (file, plain) = (file.at(seconds).unwrap(), plain.at(seconds).unwrap());
        assert_eq!(file.mesh.triangles.len(), triangles, "at {seconds} s");
        assert_eq!(file.positions, plain.positions, "at {seconds} s");
    }
    let frame = file.at(0.25).unwrap();
    let [clay, paper] = frame.materials.materials.as_slice() else { panic!("two materials") };
    assert_eq!(paper.base_color.to_array(), [0.9, 0.1, 0.1, 1.0]);
    assert_eq!(clay.base_color_texture.unwrap().image_from_mesh.translation.to_array(), [0.25, 0.0]);
    assert_eq!(frame.lights[0].color.to_array(), [1.0, 0.8, 0.6]);
    let projection = Projection::Perspective { tan_half_height: 0.2_f32.tan() };
    assert_eq!(frame.cameras[0].camera.projection, projection);
}
