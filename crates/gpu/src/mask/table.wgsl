// Opacity masks: tables in `masks`, which a stage declares as a buffer of u32.
//
// Words of the header: start of vertices, of bytes of opacity, and of materials; whether vertices have an opacity of
// their own. `mask/mod.rs` writes them.

import package::exact::mask::{MaskTexture};
import package::mask::flags::{TRIANGLE_MATERIAL};
import stage::{masks};

const MASKS_VERTICES: u32 = 0u;
const MASKS_OPACITIES: u32 = 1u;
const MASKS_MATERIALS: u32 = 2u;
const MASKS_HAS_VERTEX_OPACITY: u32 = 3u;
const MASK_MATERIAL_WORDS: u32 = 20u;
const MASK_VERTEX_WORDS: u32 = 5u;

// Of a material: its own opacity, the cutoffs of camera and shadow rays, whether it has a texture, and the set of
// texture coordinates; then the texture.
fn mask_material(triangle: u32) -> u32 {
    return masks[MASKS_MATERIALS] + (triangle & TRIANGLE_MATERIAL) * MASK_MATERIAL_WORDS;
}

fn mask_pair(word: u32) -> vec2<u32> {
    return vec2<u32>(masks[word], masks[word + 1u]);
}

fn mask_texture_at(word: u32) -> MaskTexture {
    return MaskTexture(
        mask_pair(word), mask_pair(word + 2u), mask_pair(word + 4u), mask_pair(word + 6u), mask_pair(word + 8u),
        masks[word + 10u], masks[word + 11u]);
}

fn mask_vertex(vertex: u32, word: u32) -> u32 {
    return masks[masks[MASKS_VERTICES] + vertex * MASK_VERTEX_WORDS + word];
}

fn mask_vertices(triangle: vec4<u32>, word: u32) -> vec3<u32> {
    return vec3<u32>(
        mask_vertex(triangle.x, word), mask_vertex(triangle.y, word), mask_vertex(triangle.z, word));
}

fn mask_byte(index: u32) -> u32 {
    return (masks[masks[MASKS_OPACITIES] + index / 4u] >> (8u * (index & 3u))) & 0xffu;
}

fn mask_bytes(indices: vec4<u32>) -> vec4<u32> {
    return vec4<u32>(mask_byte(indices.x), mask_byte(indices.y), mask_byte(indices.z), mask_byte(indices.w));
}
