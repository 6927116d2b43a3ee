// The opacity at a place of each of many triangles.

import package::exact::single::{F32_HALF, f32_at_least};
import package::exact::mask::{MaskTexture, mask_interpolated, mask_texels, mask_texture_opacity, mask_opacity};

const CASE_WORDS = 64u;

@compute @workgroup_size(64)
fn opacities(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let start = case_number_of(group, groups, lane) * CASE_WORDS;
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
        inputs[texels.places.x], inputs[texels.places.y], inputs[texels.places.z], inputs[texels.places.w],
    );
    let of_texture = mask_texture_opacity(bytes, texels.part);
    let opacity = mask_opacity(inputs[start + 22u], vertices, of_texture);
    outputs[2u * (start / CASE_WORDS)] = opacity;
    outputs[2u * (start / CASE_WORDS) + 1u] = u32(f32_at_least(opacity, F32_HALF));
}
