// The specular layer's table and shadowing: crates/umbrage/src/shade/albedo.rs.

import package::shade::tables::{SPECULAR_ALBEDO_SIDE, SPECULAR_ALBEDO_WORD, shade_texels};

// Scale and bias of f0 in the directional albedo of a GGX layer.
fn specular_albedo(roughness: f32, n_v: f32) -> vec2<f32> {
    let position = clamp(vec2<f32>(n_v, roughness), vec2<f32>(0.0), vec2<f32>(1.0)) * f32(SPECULAR_ALBEDO_SIDE - 1u);
    let lower = min(vec2<u32>(position), vec2<u32>(SPECULAR_ALBEDO_SIDE - 2u));
    let part = position - vec2<f32>(lower);
    let row = lower.y * SPECULAR_ALBEDO_SIDE + lower.x;
    let upper = mix(specular_albedo_entry(row), specular_albedo_entry(row + 1u), part.x);
    let next = row + SPECULAR_ALBEDO_SIDE;
    return mix(upper, mix(specular_albedo_entry(next), specular_albedo_entry(next + 1u), part.x), part.y);
}

fn specular_albedo_entry(index: u32) -> vec2<f32> {
    let word = SPECULAR_ALBEDO_WORD + 2u * index;
    return vec2<f32>(bitcast<f32>(shade_texels[word]), bitcast<f32>(shade_texels[word + 1u]));
}

// Height-correlated Smith shadowing over 4 (n·l)(n·v), `a2` being the squared GGX width.
fn smith_visibility(a2: f32, n_l: f32, n_v: f32) -> f32 {
    let masking = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2);
    let shadowing = n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    return 0.5 / (masking + shadowing);
}
