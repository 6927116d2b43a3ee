// Exact mask test of a point of a masked triangle: bit for bit the CPU's answer.

import package::exact::mask::{mask_interpolated, mask_opacity, mask_texels, mask_texture_opacity};
import package::exact::single::{F32_ONE, f32_at_least};
import package::mask::table::{MASKS_HAS_VERTEX_OPACITY, mask_bytes, mask_material, mask_texture_at, mask_vertices};
import stage::{masks};

// `barycentric` are the bits of the weights of the second and third vertex; a triangle is its four words.
fn is_there_exactly(triangle: vec4<u32>, barycentric: vec2<u32>, is_shadow: bool) -> bool {
    let material = mask_material(triangle.w);
    let has_vertices = masks[MASKS_HAS_VERTEX_OPACITY] == 1u;
    let has_texture = masks[material + 3u] == 1u;
    let first = 2u * masks[material + 4u];
    var of_vertices = F32_ONE;
    var coords: vec2<u32>;
    // The texture's two coordinates, then the vertices' opacity: in one loop, since mixing compiles slowly.
    for (var turn = 0u; turn < 3u; turn++) {
        let is_opacity = turn == 2u;
        if select(has_texture, has_vertices, is_opacity) {
            let word = select(first + turn, 4u, is_opacity);
            let value = mask_interpolated(mask_vertices(triangle, word), barycentric);
            of_vertices = select(of_vertices, value, is_opacity);
            coords = select(vec2(coords.y, value), coords, is_opacity);
        }
    }
    var of_texture = F32_ONE;
    if has_texture {
        let texels = mask_texels(mask_texture_at(material + 8u), coords);
        of_texture = mask_texture_opacity(mask_bytes(texels.indices), texels.part);
    }
    let opacity = mask_opacity(masks[material], of_vertices, of_texture);
    return f32_at_least(opacity, masks[material + select(1u, 2u, is_shadow)]);
}
