// Clear coat: crates/umbrage/src/shade/coat.rs, which has the sources.

import package::shade::microfacet::{BRDF_SMOOTHEST, ggx_distribution, half_vector};
import package::shade::specular_albedo::{smith_visibility, specular_albedo};

struct Coat {
    normal: vec3<f32>,
    n_v: f32,
    a2: f32,
    roughness: f32,
    // Fraction of the light that it takes from the layers below.
    part: f32,
}

const COAT_F0: f32 = 0.04;

fn coat_of(factor: f32, roughness: f32, normal: vec3<f32>, view: vec3<f32>) -> Coat {
    let cosine = dot(normal, view);
    let missing = 1.0 - min(abs(cosine), 1.0);
    let squared = missing * missing;
    let bounded = clamp(roughness, BRDF_SMOOTHEST, 1.0);
    let alpha = bounded * bounded;
    let part = factor * (COAT_F0 + (1.0 - COAT_F0) * (squared * squared * missing));
    return Coat(normal, max(cosine, 1e-4), alpha * alpha, bounded, part);
}

// Reflected radiance for each unit of irradiance of a surface that faces the light.
fn coat_lit(coat: Coat, view: vec3<f32>, light: vec3<f32>) -> f32 {
    let n_l = dot(coat.normal, light);
    if n_l <= 0.0 {
        return 0.0;
    }
    let n_h = max(dot(coat.normal, half_vector(coat.normal, view, light)), 0.0);
    return coat.part * (ggx_distribution(coat.a2, n_h) * smith_visibility(coat.a2, n_l, coat.n_v) * n_l);
}

// Whether it is smooth enough for sharp reflections of the surroundings.
fn coat_is_mirror(coat: Coat) -> bool {
    return coat.roughness <= BRDF_SMOOTHEST && coat.part > 0.0;
}

// Weight of the radiance from its mirror direction.
fn coat_albedo(coat: Coat) -> f32 {
    let albedo = specular_albedo(coat.roughness, coat.n_v);
    return coat.part * (albedo.x + albedo.y);
}
