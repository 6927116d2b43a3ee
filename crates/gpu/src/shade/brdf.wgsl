// Lambert below a GGX microfacet layer: crates/umbrage/src/shade/brdf.rs, which says where it comes from.

import package::shade::specular_albedo::{smith_visibility, specular_albedo};

const BRDF_PI: f32 = 3.14159265358979;
// Below this perceptual roughness a point light's highlight is narrower than a pixel and flickers.
const BRDF_SMOOTHEST: f32 = 0.045;

struct Reflectance {
    // Diffuse albedo.
    diffuse: vec3<f32>,
    // Specular reflectance at normal incidence.
    f0: vec3<f32>,
    // GGX width: perceptual roughness squared.
    alpha: f32,
    roughness: f32,
}

// What of a reflectance depends on the view alone.
struct ReflectanceView {
    n_v: f32,
    // Directional albedo of the specular layer: what it reflects doesn't reach the diffuse one.
    specular: vec3<f32>,
    // What light that bounces several times between microfacets adds to the single bounce, as a factor.
    scattered_again: vec3<f32>,
}

// `transmission` is the part of the diffuse reflection that passes through instead.
fn reflectance_of(base_color: vec3<f32>, metallic: f32, roughness: f32, ior: f32, transmission: f32) -> Reflectance {
    let ratio = (ior - 1.0) / (ior + 1.0);
    let bounded = clamp(roughness, BRDF_SMOOTHEST, 1.0);
    return Reflectance(
        base_color * (1.0 - metallic) * (1.0 - transmission),
        mix(vec3<f32>(ratio * ratio), base_color, metallic),
        bounded * bounded,
        bounded,
    );
}

fn reflectance_view(reflectance: Reflectance, n_v: f32) -> ReflectanceView {
    let albedo = specular_albedo(reflectance.roughness, n_v);
    let scattered_again = 1.0 + reflectance.f0 * max(1.0 / (albedo.x + albedo.y) - 1.0, 0.0);
    return ReflectanceView(n_v, (reflectance.f0 * albedo.x + albedo.y) * scattered_again, scattered_again);
}

// Reflected radiance towards `view` for each unit of irradiance from `light`; all three vectors of unit length and
// pointing away from the surface. Zero where `light` is below the horizon of `normal`.
fn reflectance_evaluate(
    reflectance: Reflectance,
    seen: ReflectanceView,
    normal: vec3<f32>,
    view: vec3<f32>,
    light: vec3<f32>,
) -> vec3<f32> {
    let n_l = dot(normal, light);
    if n_l <= 0.0 {
        return vec3<f32>(0.0);
    }
    let between = view + light;
    let squared = dot(between, between);
    var half_way = normal;
    if squared > 0.0 {
        half_way = between * inverseSqrt(squared);
    }
    let n_h = max(dot(normal, half_way), 0.0);
    let fresnel = fresnel_schlick(reflectance.f0, dot(view, half_way));
    let a2 = reflectance.alpha * reflectance.alpha;
    let specular = fresnel * (ggx_distribution(a2, n_h) * smith_visibility(a2, n_l, seen.n_v));
    return reflectance_diffuse(reflectance, seen) + specular * seen.scattered_again;
}

// Reflected radiance of the diffuse layer for each unit of irradiance.
fn reflectance_diffuse(reflectance: Reflectance, seen: ReflectanceView) -> vec3<f32> {
    return reflectance.diffuse / BRDF_PI * (1.0 - seen.specular);
}

// Reflected radiance under even light from all sides: `irradiance` around the normal, over π, for the diffuse layer and
// `reflected`, the mean radiance around the mirror direction, for the specular one.
fn reflectance_ambient(
    reflectance: Reflectance,
    specular: vec3<f32>,
    irradiance: vec3<f32>,
    reflected: vec3<f32>,
) -> vec3<f32> {
    return reflectance.diffuse / BRDF_PI * irradiance * (1.0 - specular) + specular * reflected;
}

fn ggx_distribution(a2: f32, n_h: f32) -> f32 {
    let d = n_h * n_h * (a2 - 1.0) + 1.0;
    return a2 / (BRDF_PI * d * d);
}

fn fresnel_schlick(f0: vec3<f32>, cosine: f32) -> vec3<f32> {
    let missing = 1.0 - clamp(cosine, 0.0, 1.0);
    let squared = missing * missing;
    return f0 + (1.0 - f0) * (squared * squared * missing);
}
