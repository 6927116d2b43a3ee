// Textures with their smaller copies: crates/scene/src/texture.rs.

import package::shade::tables::{LINEAR_FROM_SRGB_WORD, ShadeTexture, shade_texels};
import package::wrap::{wrapped};

// The linear colour at `coords` in the image, averaged over about `footprint_texels` texels of the full image.
fn texture_at(texture: ShadeTexture, coords: vec2<f32>, footprint_texels: f32) -> vec4<f32> {
    let lod = min(log2(max(footprint_texels, 1.0)), f32(texture.levels - 1u));
    if texture.is_nearest != 0u {
        return texture_level_at(texture, u32(floor(lod + 0.5)), coords);
    }
    let finer = u32(lod);
    let part = lod - f32(finer);
    // A loop rather than two calls: drivers copy every call's code.
    var color = vec4<f32>(0.0);
    for (var step = 0u; step < 2u; step++) {
        let share = select(part, 1.0 - part, step == 0u);
        if share > 0.0 {
            color += share * texture_level_at(texture, finer + step, coords);
        }
    }
    return color;
}

fn texture_level_at(texture: ShadeTexture, level: u32, coords: vec2<f32>) -> vec4<f32> {
    let size = max(texture.size >> vec2<u32>(level), vec2<u32>(1u));
    let first = shade_texels[texture.levels_word + level];
    var position = coords * vec2<f32>(size);
    if texture.is_nearest == 0u {
        position -= 0.5;
    }
    let corner = floor(position);
    let part = select(position - corner, vec2<f32>(0.0), texture.is_nearest != 0u);
    var color = vec4<f32>(0.0);
    for (var step = 0u; step < 4u; step++) {
        let right = vec2<u32>(step & 1u, step >> 1u);
        let share = select(1.0 - part, part, right == vec2<u32>(1u));
        if share.x * share.y > 0.0 {
            let at = vec2<i32>(corner) + vec2<i32>(right);
            let x = wrapped(at.x, size.x, texture.wrap.x);
            let y = wrapped(at.y, size.y, texture.wrap.y);
            color += share.x * share.y * texture_decoded(shade_texels[first + y * size.x + x], texture.is_srgb);
        }
    }
    return color;
}

// The linear colour and the opacity, 0 … 1, of a texel.
fn texture_decoded(texel: u32, is_srgb: u32) -> vec4<f32> {
    let quantities = unpack4x8unorm(texel);
    if is_srgb == 0u {
        return quantities;
    }
    return vec4<f32>(
        linear_from_srgb(texel & 255u),
        linear_from_srgb((texel >> 8u) & 255u),
        linear_from_srgb((texel >> 16u) & 255u),
        quantities.w,
    );
}

fn linear_from_srgb(byte: u32) -> f32 {
    return bitcast<f32>(shade_texels[LINEAR_FROM_SRGB_WORD + byte]);
}
