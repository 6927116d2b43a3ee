// Sheen of fibres that stand up from cloth: crates/umbrage/src/shade/sheen.rs, which has the sources.

import package::shade::microfacet::{BRDF_PI, half_vector};
import package::shade::tables::{SHEEN_ALBEDO_WORD, SPECULAR_ALBEDO_SIDE, shade_texels};

struct Sheen {
    normal: vec3<f32>,
    color: vec3<f32>,
    // Albedo of white fibres.
    albedo: f32,
    // Exponent of the squared sine between normal and half vector.
    exponent: f32,
    // Normalisation of the distribution, over 4 n·v.
    scale: f32,
    // One more than the masking of the view.
    of_view: f32,
    masking: SheenMasking,
}

// The fit of the fibres' masking: the curve's parameters, and twice the curve at one half.
struct SheenMasking {
    curve: array<f32, 5>,
    middle: f32,
}

const SHEEN_STRAIGHTEST: f32 = 0.1;
// For the widest and the narrowest distribution.
const SHEEN_WIDEST: array<f32, 5> = array<f32, 5>(21.5473, 3.82987, 0.19823, -1.97760, -4.32054);
const SHEEN_NARROWEST: array<f32, 5> = array<f32, 5>(25.3245, 3.32435, 0.16801, -1.27393, -4.85967);

fn sheen_of(color: vec3<f32>, factor: f32, normal: vec3<f32>, view: vec3<f32>) -> Sheen {
    let roughness = clamp(factor, SHEEN_STRAIGHTEST, 1.0);
    let n_v = clamp(dot(normal, view), 1e-4, 1.0);
    let whole = sheen_table_albedo(roughness, n_v);
    let albedo = min(whole, 1.0);
    let alpha = roughness * roughness;
    var masking: SheenMasking;
    for (var number = 0u; number < 5u; number++) {
        masking.curve[number] = mix(SHEEN_WIDEST[number], SHEEN_NARROWEST[number], (1.0 - alpha) * (1.0 - alpha));
    }
    masking.middle = 2.0 * sheen_curve_at(masking, 0.5);
    let scale = (1.0 / alpha + 2.0) / (8.0 * BRDF_PI * n_v);
    return Sheen(
        normal,
        color * (albedo / whole),
        albedo,
        0.5 / alpha,
        scale,
        1.0 + sheen_masking_at(masking, n_v),
        masking,
    );
}

// Reflected radiance for each unit of irradiance of a surface that faces the light.
fn sheen_lit(sheen: Sheen, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let n_l = min(dot(sheen.normal, light), 1.0);
    if n_l <= 0.0 {
        return vec3<f32>(0.0);
    }
    let n_h = dot(sheen.normal, half_vector(sheen.normal, view, light));
    let power = pow(max(1.0 - n_h * n_h, 1.2e-38), sheen.exponent);
    return sheen.color * (sheen.scale * power / (sheen.of_view + sheen_masking_at(sheen.masking, n_l)));
}

// Fraction of light that it leaves to the layers below.
fn sheen_below(sheen: Sheen) -> f32 {
    return 1.0 - max(sheen.color.x, max(sheen.color.y, sheen.color.z)) * sheen.albedo;
}

fn sheen_curve_at(masking: SheenMasking, x: f32) -> f32 {
    let curve = masking.curve;
    return curve[0] / (1.0 + curve[1] * pow(max(x, 1.2e-38), curve[2])) + curve[3] * x + curve[4];
}

fn sheen_masking_at(masking: SheenMasking, cosine: f32) -> f32 {
    let at = sheen_curve_at(masking, min(cosine, 1.0 - cosine));
    return exp(select(masking.middle - at, at, cosine < 0.5));
}

// Directional albedo of white fibres.
fn sheen_table_albedo(roughness: f32, n_v: f32) -> f32 {
    let position = clamp(vec2<f32>(sqrt(n_v), roughness), vec2<f32>(0.0), vec2<f32>(1.0));
    let scaled = position * f32(SPECULAR_ALBEDO_SIDE - 1u);
    let lower = min(vec2<u32>(scaled), vec2<u32>(SPECULAR_ALBEDO_SIDE - 2u));
    let part = scaled - vec2<f32>(lower);
    let row = lower.y * SPECULAR_ALBEDO_SIDE + lower.x;
    let next = row + SPECULAR_ALBEDO_SIDE;
    let upper = mix(sheen_table_entry(row), sheen_table_entry(row + 1u), part.x);
    return mix(upper, mix(sheen_table_entry(next), sheen_table_entry(next + 1u), part.x), part.y);
}

fn sheen_table_entry(index: u32) -> f32 {
    return bitcast<f32>(shade_texels[SHEEN_ALBEDO_WORD + index]);
}
