// The opacity at a point of each of many triangles.

import package::exact::single::{F32_HALF, f32_at_least};
import package::exact::mask::{MaskTexture, mask_interpolated, mask_texels, mask_texture_opacity, mask_opacity};

const CASE_WORDS = 64u;

@compute @workgroup_size(64)
fn opacities(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let texture = MaskTexture(
        case_pair(start), case_pair(start + 2u), case_pair(start + 4u), case_pair(start + 6u), case_pair(start + 8u),
        inputs[start + 10u], start + 24u,
    );
    let barycentric = case_pair(start + 11u);
    let coords = vec2(
        mask_interpolated(case_triple(start + 13u), barycentric),
        mask_interpolated(case_triple(start + 16u), barycentric),
    );
    let vertices = mask_interpolated(case_triple(start + 19u), barycentric);
    let texels = mask_texels(texture, coords);
    let bytes = vec4(
        inputs[texels.indices.x], inputs[texels.indices.y], inputs[texels.indices.z], inputs[texels.indices.w],
    );
    let of_texture = mask_texture_opacity(bytes, texels.part);
    let opacity = mask_opacity(inputs[start + 22u], vertices, of_texture);
    outputs[2u * (start / CASE_WORDS)] = opacity;
    outputs[2u * (start / CASE_WORDS) + 1u] = u32(f32_at_least(opacity, F32_HALF));
}
