//! Tests that the structs that Rust writes are those that the shading kernels read.

use super::tables::DevelopSettings;
use super::{ShadeLayers, ShadeLight, ShadeMaterial, ShadeSample, ShadeScene, ShadeSurroundings, ShadeTexture, Texels};
use crate::layout::{differences, layout, module, other_constants};
use crate::link::link;

#[test]
fn structs_are_those_of_the_shaders() {
    let tables = module(&link("shade::texture"));
    let layouts = [
        layout!(ShadeSample {
            position,
            projection,
            right,
            half_height,
            up,
            footprint,
            forward,
            footprint_per_depth,
            offset_pixels,
            size_pixels,
            miss_depth,
            words_per_light,
            is_first_sample,
            is_first_layer,
            is_last_layer,
            first_plane,
            through_plane,
            flat_plane,
            first_row,
            image_height,
            bounces,
            least_contribution,
            ways_plane,
            ways_count,
            tints_word,
            first_pixel,
            number,
            points,
            looks_around,
        }),
        layout!(ShadeSurroundings { irradiance, color, kind, panorama_size, panorama_levels, panorama_word }),
        layout!(ShadeScene {
            surroundings,
            material_word,
            normal_word,
            tangent_word,
            color_word,
            tex_coord_words,
            light_count,
            sky_light_count,
        }),
        layout!(ShadeLight { position, kind, direction, range, emitted, outer_cosine, cosine_span }),
        layout!(ShadeMaterial {
            base_color,
            emissive,
            metallic,
            roughness,
            ior,
            transmission,
            normal_scale,
            occlusion_strength,
            is_blended,
            is_unlit,
            catches_shadows,
            bounds_volume,
            dispersion,
            attenuation_distance,
            mask_cutoff,
            attenuation_color,
            layer_bits,
            layers,
            textures,
        }),
        layout!(ShadeLayers {
            specular_color,
            specular,
            sheen_color,
            sheen_roughness,
            coat,
            coat_roughness,
            coat_normal_scale,
            stretch,
            stretch_turn,
            film,
            film_ior,
            film_nanometers,
        }),
        layout!(ShadeTexture {
            matrix,
            translation,
            size,
            wrap,
            levels,
            levels_word,
            tex_coord_set,
            is_nearest,
            is_srgb,
        }),
    ];
    for of_rust in layouts {
        assert_eq!(differences(&tables, &of_rust), [""; 0]);
    }
    let develop = module(&link("shade::develop"));
    let of_rust = layout!(DevelopSettings { weight, exposure, tone_map, width, height, row_pixels, flat_plane });
    assert_eq!(differences(&develop, &of_rust), [""; 0]);
}

#[test]
fn constants_are_those_of_the_shaders() {
    let tables = module(&link("shade::texture"));
    let constants = [
        ("NO_WORD", ShadeScene::NO_WORD),
        ("NO_TRIANGLE", umbrage_rays::SeenPixels::NONE),
        ("PROJECTION_PERSPECTIVE", ShadeSample::PERSPECTIVE),
        ("PROJECTION_ORTHOGRAPHIC", ShadeSample::ORTHOGRAPHIC),
        ("SURROUNDINGS_COLOR", ShadeSurroundings::COLOR),
        ("SURROUNDINGS_SKY", ShadeSurroundings::SKY),
        ("SURROUNDINGS_IMAGE", ShadeSurroundings::IMAGE),
        ("LIGHT_POINT", ShadeLight::POINT),
        ("LIGHT_SPOT", ShadeLight::SPOT),
        ("LIGHT_DIRECTIONAL", ShadeLight::DIRECTIONAL),
        ("LIGHT_FLAT", ShadeLight::FLAT),
        ("MOST_LIGHTS", ShadeLight::MOST as u32),
        ("TEXTURE_BASE_COLOR", ShadeMaterial::BASE_COLOR as u32),
        ("TEXTURE_METALLIC_ROUGHNESS", ShadeMaterial::METALLIC_ROUGHNESS as u32),
        ("TEXTURE_NORMAL", ShadeMaterial::NORMAL as u32),
        ("TEXTURE_OCCLUSION", ShadeMaterial::OCCLUSION as u32),
        ("TEXTURE_EMISSIVE", ShadeMaterial::EMISSIVE as u32),
        ("TEXTURE_TRANSMISSION", ShadeMaterial::TRANSMISSION as u32),
        ("TEXTURE_SPECULAR", ShadeMaterial::SPECULAR as u32),
        ("TEXTURE_SPECULAR_COLOR", ShadeMaterial::SPECULAR_COLOR as u32),
        ("TEXTURE_COAT", ShadeMaterial::COAT as u32),
        ("TEXTURE_COAT_ROUGHNESS", ShadeMaterial::COAT_ROUGHNESS as u32),
        ("TEXTURE_COAT_NORMAL", ShadeMaterial::COAT_NORMAL as u32),
        ("TEXTURE_SHEEN_COLOR", ShadeMaterial::SHEEN_COLOR as u32),
        ("TEXTURE_SHEEN_ROUGHNESS", ShadeMaterial::SHEEN_ROUGHNESS as u32),
        ("TEXTURE_GROOVES", ShadeMaterial::GROOVES as u32),
        ("TEXTURE_FILM", ShadeMaterial::FILM as u32),
        ("TEXTURE_FILM_THICKNESS", ShadeMaterial::FILM_THICKNESS as u32),
        ("LAYER_SPECULAR", ShadeLayers::SPECULAR),
        ("LAYER_COAT", ShadeLayers::COAT),
        ("LAYER_SHEEN", ShadeLayers::SHEEN),
        ("LAYER_GROOVES", ShadeLayers::GROOVES),
        ("LAYER_FILM", ShadeLayers::FILM),
        ("WRAP_REPEAT", ShadeTexture::REPEAT),
        ("WRAP_MIRRORED_REPEAT", ShadeTexture::MIRRORED_REPEAT),
        ("WRAP_CLAMP_TO_EDGE", ShadeTexture::CLAMP_TO_EDGE),
        ("LINEAR_FROM_SRGB_WORD", Texels::LINEAR_FROM_SRGB_WORD),
        ("SPECULAR_ALBEDO_WORD", Texels::SPECULAR_ALBEDO_WORD),
        ("SPECULAR_ALBEDO_SIDE", Texels::ALBEDO_SIDE as u32),
        ("SHEEN_ALBEDO_WORD", Texels::SHEEN_ALBEDO_WORD),
    ];
    assert_eq!(other_constants(&tables, &constants), [""; 0]);
    let develop = module(&link("shade::develop"));
    let constants = [("TONE_MAP_NEUTRAL", DevelopSettings::NEUTRAL), ("TONE_MAP_CLIP", DevelopSettings::CLIP)];
    assert_eq!(other_constants(&develop, &constants), [""; 0]);
    assert_eq!(other_constants(&tables, &[("NO_SUCH_CONSTANT", 0), ("NO_WORD", 0)]), ["NO_SUCH_CONSTANT", "NO_WORD"]);
}
