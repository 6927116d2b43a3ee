use glam::{Affine2, Vec2, Vec3};
use serde_json::{Value, json};
use umbrage_scene::{
    Anisotropy, Clearcoat, ColorSpace, Iridescence, Layers, Material, Sheen, Specular, Texture, TextureUse,
};

use super::look::{add_texture, material, with_material};

fn layers(extensions: &Value) -> Option<Layers> {
    let mut file = with_material(json!({ "extensions": extensions }));
    add_texture(&mut file);
    material(&file).layers.map(|layers| *layers)
}

/// The use of texture 0 (colours) or 1 (quantities) by materials.
fn moved(texture: u32) -> Option<TextureUse> {
    let image_from_mesh = Affine2::from_translation(Vec2::new(0.5, 0.25));
    Some(TextureUse { tex_coord_set: 1, image_from_mesh, ..TextureUse::new(texture) })
}

#[test]
fn factors_and_textures_of_all_layers_are_read() {
    let extensions = json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "texCoord": 1 } });
    let texture = json!({ "index": 0, "extensions": extensions });
    let mut normals = texture.clone();
    normals["scale"] = json!(0.5);
    let json = json!({
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": texture,
            "specularColorFactor": [2, 1, 0.5], "specularColorTexture": texture,
        },
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.25, "clearcoatTexture": texture,
            "clearcoatRoughnessFactor": 0.75, "clearcoatRoughnessTexture": texture, "clearcoatNormalTexture": normals,
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.1, 0.2, 0.3], "sheenColorTexture": texture,
            "sheenRoughnessFactor": 0.4, "sheenRoughnessTexture": texture,
        },
        "KHR_materials_anisotropy": { "anisotropyStrength": 0.6, "anisotropyRotation": 1.5, "anisotropyTexture": texture },
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.7, "iridescenceTexture": texture, "iridescenceIor": 1.8,
            "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 900,
            "iridescenceThicknessTexture": texture,
        },
    });
    let mut file = with_material(json!({ "extensions": json }));
    add_texture(&mut file);
    let names = json.as_object().expect("an object").keys().collect::<Vec<_>>();
    file.json["extensionsUsed"] = json!(names);
    file.json["extensionsRequired"] = json!(names);
    let scene = file.open().expect("all of these are supported");
    assert_eq!(scene.warnings(), [""; 0]);
    let frame = scene.at(0.0).expect("a frame");
    let spaces: Vec<_> = frame.materials.textures.iter().map(Texture::space).collect();
    let color = spaces.iter().position(|&space| space == ColorSpace::Srgb).expect("one of colours") as u32;
    assert_eq!(spaces.len(), 2);
    let (color, quantity) = (moved(color), moved(1 - color));
    let expected = Layers {
        specular: Specular { factor: 0.5, texture: quantity, color: Vec3::new(2.0, 1.0, 0.5), color_texture: color },
        clearcoat: Clearcoat {
            factor: 0.25,
            texture: quantity,
            roughness: 0.75,
            roughness_texture: quantity,
            normal_texture: quantity,
            normal_scale: 0.5,
        },
        sheen: Sheen {
            color: Vec3::new(0.1, 0.2, 0.3),
            color_texture: color,
            roughness: 0.4,
            roughness_texture: quantity,
        },
        anisotropy: Anisotropy { strength: 0.6, rotation_radians: 1.5, texture: quantity },
        iridescence: Iridescence {
            factor: 0.7,
            texture: quantity,
            ior: 1.8,
            thickness_minimum_nanometers: 200.0,
            thickness_maximum_nanometers: 900.0,
            thickness_texture: quantity,
        },
    };
    assert_eq!(frame.materials.materials[0].layers.as_deref(), Some(&expected));
}

#[test]
fn layers_have_the_extensions_defaults() {
    let coat = layers(&json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1 } }));
    let clearcoat = Clearcoat { factor: 1.0, ..Clearcoat::default() };
    assert_eq!(coat, Some(Layers { clearcoat, ..Layers::default() }));
    let film = layers(&json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1 } }));
    let iridescence = film.expect("a film").iridescence;
    assert_eq!((iridescence.ior, iridescence.thickness_maximum_nanometers), (1.3, 400.0));
    // Extensions that are empty or have no visible effect make no layer.
    let off = json!({
        "KHR_materials_specular": {},
        "KHR_materials_clearcoat": { "clearcoatRoughnessFactor": 0.5 },
        "KHR_materials_sheen": { "sheenRoughnessFactor": 0.5 },
        "KHR_materials_anisotropy": { "anisotropyRotation": 1 },
        "KHR_materials_iridescence": { "iridescenceIor": 2 },
    });
    assert_eq!(layers(&off), None);
    assert_eq!(Material::default().layers, None);
}

#[test]
fn what_is_broken_in_a_layer_is_named() {
    let error = |extensions: Value| with_material(json!({ "extensions": extensions })).error();
    let text = error(json!({ "KHR_materials_sheen": { "sheenColorFactor": "red" } }));
    assert!(text.contains("materials[0].extensions.KHR_materials_sheen"), "{text}");
    let missing =
        error(json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatTexture": { "index": 7 } } }));
    assert!(missing.contains("KHR_materials_clearcoat.clearcoatTexture.index: index 7"), "{missing}");
    let infinite = error(json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1, "iridescenceIor": 1e300 } }));
    assert!(infinite.contains("materials[0]: one of its numbers is not finite"), "{infinite}");
}
