// Whether a point of a masked triangle is there, as the CPU decides it, bit for bit.

import package::exact::mask::{mask_interpolated, mask_opacity, mask_texels, mask_texture_opacity};
import package::exact::single::{F32_ONE, f32_at_least};
import package::mask::table::{MASKS_HAS_VERTEX_OPACITY, mask_bytes, mask_material, mask_texture_at, mask_vertices};
import stage::{masks};

// `barycentric` are the bits of the weights of the second and third vertex; a triangle is its four words.
fn is_there_exactly(triangle: vec4<u32>, barycentric: vec2<u32>, is_shadow: bool) -> bool {
    let material = mask_material(triangle.w);
    var of_vertices = F32_ONE;
    if masks[MASKS_HAS_VERTEX_OPACITY] == 1u {
        of_vertices = mask_interpolated(mask_vertices(triangle, 4u), barycentric);
    }
    var of_texture = F32_ONE;
    if masks[material + 3u] == 1u {
        let first = 2u * masks[material + 4u];
        let coords = vec2<u32>(
            mask_interpolated(mask_vertices(triangle, first), barycentric),
            mask_interpolated(mask_vertices(triangle, first + 1u), barycentric));
        let texels = mask_texels(mask_texture_at(material + 8u), coords);
        of_texture = mask_texture_opacity(mask_bytes(texels.indices), texels.part);
    }
    let opacity = mask_opacity(masks[material], of_vertices, of_texture);
    return f32_at_least(opacity, masks[material + select(1u, 2u, is_shadow)]);
}
