use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Quat, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use umbrage_files::Clip;
use umbrage_rays::{LightSource, Projection};
use umbrage_scene::{Alpha, Material, Scene, TextureUse};

use crate::builder::{Builder, data_uri, open_in};
use crate::solids;

/// A PNG of 2×1 texels: a red one and a blue one.
pub(super) fn png() -> Vec<u8> {
    solids::png([2, 1], png::ColorType::Rgba, &[255, 0, 0, 255, 0, 0, 255, 128])
}

/// A triangle with material 0.
pub(super) fn with_material(material: Value) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("materials", material);
    file
}

/// Adds an image in a buffer view and a texture of it.
pub(super) fn add_texture(file: &mut Builder) {
    let view = file.view(&png());
    let image = file.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    file.push("textures", json!({ "source": image }));
}

pub(super) fn material(file: &Builder) -> Material {
    file.at(0.0).materials.materials[0].clone()
}

#[test]
fn factors_and_extensions_are_read() {
    let file = with_material(json!({
        "name": "glass",
        "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6 },
        "emissiveFactor": [1, 0.5, 0.25],
        "alphaMode": "MASK",
        "alphaCutoff": 0.7,
        "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
            "KHR_materials_ior": { "ior": 1.3 },
            "KHR_materials_transmission": { "transmissionFactor": 0.9 },
            "KHR_materials_volume": { "thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [0.5, 0.6, 0.7] },
            "KHR_materials_unlit": {},
        },
    }));
    let material = material(&file);
    assert_eq!(material.name, "glass");
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((material.metallic, material.roughness), (0.5, 0.6));
    assert_eq!(material.emissive, Vec3::new(4.0, 2.0, 1.0));
    assert_eq!(material.alpha, Alpha::Mask { cutoff: 0.7 });
    assert!(material.double_sided && material.unlit);
    assert_eq!((material.ior, material.transmission), (1.3, 0.9));
    assert_eq!((material.volume.thickness, material.volume.attenuation_distance), (2.0, 3.0));
    assert_eq!(material.volume.attenuation_color, Vec3::new(0.5, 0.6, 0.7));
}

#[test]
fn a_material_without_anything_is_the_default() {
    let material = material(&with_material(json!({})));
    assert_eq!(material, Material { metallic: 1.0, ..Material::default() });
}

#[test]
fn textures_are_decoded_once_for_each_reading() {
    let mut file = with_material(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 0 } },
        "normalTexture": { "index": 0, "scale": 0.5 },
        "occlusionTexture": { "index": 1, "strength": 0.25, "texCoord": 1 },
        "emissiveTexture": { "index": 0 },
    }));
    add_texture(&mut file);
    let sampler = file.push("samplers", json!({ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }));
    file.push("textures", json!({ "source": 0, "sampler": sampler }));
    let frame = file.at(0.0);
    let material = &frame.materials.materials[0];
    let texture = |texture_use: &Option<TextureUse>| texture_use.unwrap().texture;
    let color = texture(&material.base_color_texture);
    let linear = texture(&material.metallic_roughness_texture);
    assert_eq!(texture(&material.emissive_texture), color);
    assert_eq!(texture(&material.normal_texture), linear);
    let nearest = texture(&material.occlusion_texture);
    assert_eq!(frame.materials.textures.len(), 3);
    assert_eq!(material.occlusion_texture.unwrap().tex_coord_set, 1);
    assert_eq!((material.normal_scale, material.occlusion_strength), (0.5, 0.25));
    // The second texel's opacity is 128 of 255 in either colour space.
    let sampled = |texture: u32, u: f32| frame.materials.textures[texture as usize].sample(Vec2::new(u, 0.5), 1.0);
    assert_eq!(sampled(color, 0.25), Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(sampled(nearest, 0.6), Vec4::new(0.0, 0.0, 1.0, 128.0 / 255.0));
    // Linear filtering mixes over the edge of the image, where it is repeated; nearest and clamped doesn't.
    assert_eq!(sampled(linear, 0.0).truncate(), Vec3::new(0.5, 0.0, 0.5));
    assert_eq!(sampled(nearest, 1.2), Vec4::new(0.0, 0.0, 1.0, 128.0 / 255.0));
}

#[test]
fn texture_transforms_are_scale_then_rotation_then_offset() {
    let transform = json!({ "offset": [0.5, 0.25], "rotation": FRAC_PI_2, "scale": [2, 4], "texCoord": 1 });
    let extension = json!({ "KHR_texture_transform": transform });
    let mut file = with_material(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "extensions": extension } },
        "normalTexture": { "index": 0, "extensions": extension },
    }));
    add_texture(&mut file);
    let material = material(&file);
    let texture = material.base_color_texture.unwrap();
    assert_eq!(texture.tex_coord_set, 1);
    // The extension's matrix for a quarter turn: u' = v, v' = −u. (1, 0) is scaled to (2, 0) and turned to (0, −2).
    for (mesh, image) in [([0.0, 0.0], [0.5, 0.25]), ([1.0, 0.0], [0.5, -1.75]), ([0.0, 1.0], [4.5, 0.25])] {
        let coords = texture.image_coords([Vec2::NAN, Vec2::from_array(mesh)]);
        assert!((coords - Vec2::from_array(image)).length() < 1e-6, "{mesh:?} to {coords}");
    }
    assert_eq!(material.normal_texture.unwrap().image_from_mesh, texture.image_from_mesh);
}

#[test]
fn images_come_from_files_and_data_uris() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.png"), png()).unwrap();
    for uri in ["a%20b.png".to_owned(), data_uri(&png())] {
        let mut file = with_material(json!({ "emissiveTexture": { "index": 0 } }));
        file.push("images", json!({ "uri": uri }));
        file.push("textures", json!({ "source": 0 }));
        let scene = open_in(folder.path(), "scene.glb", &file.glb(), Clip::Auto).unwrap();
        assert_eq!(scene.at(0.0).unwrap().materials.textures[0].size(), [2, 1]);
        assert!(scene.warnings().is_empty());
    }
}

#[test]
fn images_that_cannot_be_used_are_left_away_with_a_warning() {
    let broken = |image: Value| {
        let mut file = with_material(json!({
            "emissiveTexture": { "index": 0 },
            "normalTexture": { "index": 1 },
        }));
        file.push("images", image);
        file.push("textures", json!({ "source": 0 }));
        add_texture(&mut file);
        let scene = file.open().unwrap();
        let frame = scene.at(0.0).unwrap();
        let material = &frame.materials.materials[0];
        assert_eq!(material.emissive_texture, None);
        assert_eq!(frame.materials.textures[material.normal_texture.unwrap().texture as usize].size(), [2, 1]);
        scene.warnings()[0].clone()
    };
    assert!(broken(json!({ "uri": "missing.png" })).contains("missing.png"));
    assert!(broken(json!({ "uri": "http://host/a.png" })).contains("`http:`"));
    assert!(broken(json!({ "uri": data_uri(b"\xABKTX 20\xBB\r\n\x1A\n") })).contains("images[0]: not a usable image"));
    assert!(broken(json!({ "uri": data_uri(&png()[..40]) })).contains("images[0]"));
    assert!(broken(json!({})).contains("images[0]: it has neither"));
    assert!(broken(json!({ "bufferView": 99 })).contains("images[0].bufferView: index 99"));
}

#[test]
fn textures_without_a_plain_image_are_left_away_with_a_warning() {
    let mut file = with_material(json!({ "emissiveTexture": { "index": 0 } }));
    file.push("textures", json!({ "extensions": { "MSFT_texture_dds": { "source": 0 } } }));
    file.json["extensionsUsed"] = json!(["MSFT_texture_dds"]);
    let scene = file.open().unwrap();
    assert_eq!(scene.warnings().len(), 2, "{:?}", scene.warnings());
    assert!(scene.warnings()[0].contains("`MSFT_texture_dds`"));
    assert!(scene.warnings()[1].contains("textures[0]"));
    let mut file = with_material(json!({ "emissiveTexture": { "index": 0, "texCoord": 2 } }));
    add_texture(&mut file);
    assert!(file.open().unwrap().warnings()[0].contains("not 2"));
    let missing = with_material(json!({ "emissiveTexture": { "index": 3 } }));
    assert!(missing.error().contains("materials[0].emissiveTexture.index: index 3"), "{}", missing.error());
}

#[test]
fn specular_glossiness_is_approximated() {
    let glossy =
        json!({ "diffuseFactor": [0.1, 0.2, 0.3, 1], "glossinessFactor": 0.75, "diffuseTexture": { "index": 0 } });
    let mut file = with_material(json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": glossy } }));
    file.json["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    add_texture(&mut file);
    let scene = file.open().unwrap();
    assert!(scene.warnings()[0].contains("approximated"), "{:?}", scene.warnings());
    let material = material(&file);
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 1.0));
    assert_eq!((material.metallic, material.roughness), (0.0, 0.25));
    assert!(material.base_color_texture.is_some());
}

/// A triangle, and one light on a node that is turned by a quarter around y, scaled and at (1, 2, 3).
fn lit(light: Value) -> Scene {
    let mut file = Builder::new();
    let mesh = file.triangle();
    let quarter = Quat::from_rotation_y(FRAC_PI_2).to_array();
    file.push("nodes", json!({ "mesh": mesh }));
    file.push(
        "nodes",
        json!({
            "translation": [1, 2, 3],
            "rotation": quarter,
            "scale": [5, 6, 7],
            "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }),
    );
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": Value::Array(vec![light]) } });
    file.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    file.open().unwrap()
}

#[test]
fn lights_shine_from_their_nodes() {
    let position = Vec3::new(1.0, 2.0, 3.0);
    let frame =
        lit(json!({ "type": "point", "color": [1, 0.5, 0], "intensity": 30, "range": 9, "name": "lamp" })).at(0.0);
    let light = &frame.unwrap().lights[0];
    assert_eq!(light.source, LightSource::Point { position });
    assert_eq!((light.color, light.intensity, light.range), (Vec3::new(1.0, 0.5, 0.0), 30.0, Some(9.0)));
    assert_eq!(&*light.name, "lamp");

    let frame = lit(json!({ "type": "directional" })).at(0.0).unwrap();
    let LightSource::Directional { direction } = frame.lights[0].source else { panic!("directional") };
    assert!((direction - Vec3::NEG_X).length() < 1e-6, "{direction}");
    assert_eq!((frame.lights[0].color, frame.lights[0].intensity, frame.lights[0].range), (Vec3::ONE, 1.0, None));

    let spot = json!({ "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } });
    let frame = lit(spot).at(0.0).unwrap();
    let LightSource::Spot { position: at, direction, inner_radians, outer_radians } = frame.lights[0].source else {
        panic!("spot")
    };
    assert_eq!((at, inner_radians, outer_radians), (position, 0.25, 0.5));
    assert!((direction - Vec3::NEG_X).length() < 1e-6);
    assert_eq!(frame.lights.len(), 1);
}

#[test]
fn impossible_cones_are_mended_with_a_warning() {
    for (cone, outer) in [
        (json!({ "innerConeAngle": 0.7, "outerConeAngle": 0.5 }), 0.5),
        (json!({ "innerConeAngle": -1, "outerConeAngle": 0.5 }), 0.5),
        (json!({ "outerConeAngle": 3 }), FRAC_PI_2),
        (json!({ "outerConeAngle": 0 }), FRAC_PI_4),
    ] {
        let scene = lit(json!({ "type": "spot", "spot": cone }));
        let LightSource::Spot { inner_radians, outer_radians, .. } = scene.at(0.0).unwrap().lights[0].source else {
            panic!("spot")
        };
        assert_eq!(outer_radians, outer);
        assert!((0.0..outer).contains(&inner_radians), "{inner_radians}");
        assert!(scene.warnings()[0].contains("mended"), "{:?}", scene.warnings());
    }
    let plain = lit(json!({ "type": "spot", "spot": {} }));
    assert!(plain.warnings().is_empty());
    assert!(lit(json!({ "type": "area" })).warnings()[0].contains("light 0 was left out"));
}

#[test]
fn numbers_out_of_range_are_brought_there_with_a_warning() {
    let scene = lit(json!({ "type": "point", "color": [1, -0.5, 0], "intensity": -30, "range": -9 }));
    let light = &scene.at(0.0).unwrap().lights[0];
    assert_eq!((light.color, light.intensity, light.range), (Vec3::X, 0.0, None));
    let warnings = scene.warnings();
    assert!(warnings[0].contains("light 0 has a negative colour or intensity, which was taken as 0"), "{warnings:?}");
    assert!(warnings[1].contains("the range of light 0 is not above 0 and was left out"), "{warnings:?}");

    let file = with_material(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [2, -1, 0.5, 1], "metallicFactor": 1.5, "roughnessFactor": -0.5 },
        "emissiveFactor": [3, -1, 0],
        "extensions": { "KHR_materials_ior": { "ior": 0.5 }, "KHR_materials_transmission": { "transmissionFactor": 1 } },
    }));
    let material = material(&file);
    assert_eq!(material.base_color, Vec4::new(1.0, 0.0, 0.5, 1.0));
    assert_eq!((material.metallic, material.roughness, material.ior), (1.0, 0.0, 1.0));
    assert_eq!((material.emissive, material.transmission), (Vec3::new(3.0, 0.0, 0.0), 1.0));
    let scene = file.open().unwrap();
    assert_eq!(scene.warnings().len(), 6, "{:?}", scene.warnings());
    assert_eq!(scene.warnings()[0], "materials[0]: the metalness of 1.5 is out of range and was taken as 1");
}

/// A camera on a node like this.
fn seen(camera: Value, mut node: Value) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    node["camera"] = json!(0);
    file.push("nodes", node);
    file.push("nodes", json!({ "mesh": mesh }));
    file.push("cameras", camera);
    file
}

#[test]
fn cameras_look_along_their_nodes() {
    let perspective = json!({ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } });
    let quarter = Quat::from_rotation_y(FRAC_PI_2).to_array();
    let node = json!({ "name": "view", "translation": [1, 2, 3], "rotation": quarter, "scale": [2, 3, 4] });
    let mut file = seen(perspective, node);
    file.animate(0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [8.0, 0.0, 0.0]]);
    let frame = file.at(0.5);
    let camera = frame.cameras[0].camera;
    assert_eq!(&*frame.cameras[0].name, "view");
    assert_eq!(camera.position, Vec3::new(4.0, 0.0, 0.0));
    for (axis, expected) in [(camera.right, Vec3::NEG_Z), (camera.up, Vec3::Y), (camera.forward, Vec3::NEG_X)] {
        assert!((axis - expected).length() < 1e-6, "{axis}, not {expected}");
    }
    assert_eq!(camera.projection, Projection::Perspective { tan_half_height: 0.5_f32.tan() });
}

#[test]
fn camera_axes_stay_at_right_angles() {
    let orthographic =
        json!({ "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 3, "znear": 0, "zfar": 9 } });
    let sheared = [2.0, 1.0, 0.0, 0.0, 0.0, 1.0, 3.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    for matrix in [sheared, [0.0; 16]] {
        let frame = seen(orthographic.clone(), json!({ "matrix": matrix })).at(0.0);
        let camera = frame.cameras[0].camera;
        assert_eq!(camera.projection, Projection::Orthographic { half_height: 3.0 });
        let axes = [camera.right, camera.up, camera.forward];
        for (first, axis) in axes.iter().enumerate() {
            for (second, other) in axes.iter().enumerate() {
                let expected = if first == second { 1.0 } else { 0.0 };
                assert!((axis.dot(*other) - expected).abs() < 1e-6, "{axes:?}");
            }
        }
    }
}

#[test]
fn cameras_that_see_nothing_are_left_out() {
    for camera in [
        json!({ "type": "perspective", "perspective": { "yfov": 0, "znear": 0.1 } }),
        json!({ "type": "perspective", "perspective": { "yfov": 3.2, "znear": 0.1 } }),
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 0, "znear": 0, "zfar": 9 } }),
        json!({ "type": "perspective" }),
        json!({ "type": "fisheye" }),
    ] {
        let scene = seen(camera, json!({})).open().unwrap();
        assert!(scene.at(0.0).unwrap().cameras.is_empty());
        assert!(scene.warnings()[0].contains("cameras[0] was left out"), "{:?}", scene.warnings());
    }
}
