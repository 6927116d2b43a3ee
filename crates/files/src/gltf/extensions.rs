//! The supported glTF extensions, and warnings or errors for the others.

use std::path::Path;

use gltf::json::Root;
use umbrage_scene::Error;

use crate::texture::{AVIF_LEFT_OUT, READS_AVIF};

/// Extensions that this reader supports, some approximately.
const SUPPORTED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions without effect on a picture: meaning, physics, sound and interaction.
const UNSEEN: &[&str] = &[
    "AGI_articulations",
    "AGI_stk_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "KHR_audio_emitter",
    "KHR_audio_graph",
    "KHR_collision_shapes",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_audio_emitter",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "OMI_audio_emitter",
    "OMI_collider",
    "OMI_physics_body",
    "OMI_physics_shape",
    "OMI_seat",
    "OMI_spawn_point",
    "VRMC_node_constraint",
    "VRMC_springBone",
    "VRMC_vrm",
];

/// Read where there is a decoder.
pub(super) const AVIF: &str = "EXT_texture_avif";

/// Advice about a file that requires [`AVIF`], in a build without a decoder.
const AVIF_ADVICE: &str = if cfg!(target_family = "wasm") {
    "convert its textures to PNG: `npx @gltf-transform/cli png --formats avif FILE OUT.glb`"
} else {
    AVIF_LEFT_OUT
};

/// Compares the extensions that a file uses and requires with the supported ones.
///
/// # Errors
/// Where the file requires an extension that isn't read and that affects the picture.
pub(super) fn check(path: &Path, json: &Root, warnings: &mut Vec<String>) -> Result<(), Error> {
    let is_in = |list: &[&str], name: &String| list.contains(&name.as_str());
    let is_read = |name: &String| is_in(SUPPORTED, name) || (READS_AVIF && name == AVIF);
    for name in &json.extensions_required {
        if is_in(UNSEEN, name) {
            warnings.push(format!("the file requires the glTF extension `{name}`, which changes nothing in a picture"));
        } else if !is_read(name) {
            let what = format!("the glTF extension `{name}`, which the file requires,");
            let advice = if name == AVIF { AVIF_ADVICE } else { "export the scene without it" };
            return Err(Error::unsupported(path, what, advice));
        }
    }
    for name in json.extensions_used.iter().filter(|name| !is_read(name) && !is_in(UNSEEN, name)) {
        let is_compiled_out = name == AVIF && cfg!(not(target_family = "wasm"));
        let reason = if is_compiled_out { format!(": {AVIF_LEFT_OUT}") } else { String::new() };
        warnings.push(format!("the glTF extension `{name}` is not supported and was left out{reason}"));
    }
    Ok(())
}
