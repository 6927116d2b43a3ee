// Lambert below a GGX microfacet layer: crates/umbrage/src/shade/brdf.rs, which has the sources.

import package::shade::grooves::{grooves_lobe};
import package::shade::layers::{LAYERS, Layers};
import package::shade::microfacet::{BRDF_PI, BRDF_SMOOTHEST, ggx_distribution, half_vector};
import package::shade::specular_albedo::{smith_visibility, specular_albedo};

struct Reflectance {
    // Diffuse albedo.
    diffuse: vec3<f32>,
    // Specular reflectance at normal incidence.
    f0: vec3<f32>,
    // Specular reflectance at grazing angles.
    f90: f32,
    // GGX width: perceptual roughness squared.
    alpha: f32,
    roughness: f32,
}

// The terms of a reflectance that depend on the view alone.
struct ReflectanceView {
    n_v: f32,
    // Directional albedo of the specular layer, and the fraction that it transmits to the diffuse layer.
    specular: vec3<f32>,
    entering: vec3<f32>,
    // Factor for light that bounces several times between microfacets, relative to a single bounce.
    scattered_again: vec3<f32>,
}

// Reflectance of a microfacet for light at this cosine of incidence.
fn reflectance_of_facet(reflectance: Reflectance, seen: ReflectanceView, cosine: f32, layers: Layers) -> vec3<f32> {
    var fresnel = fresnel_schlick(reflectance.f0, reflectance.f90, cosine);
    if LAYERS && layers.film > 0.0 {
        fresnel = mix(fresnel, layers.film_reflected, layers.film);
    }
    return fresnel * seen.scattered_again;
}

// `transmission` is the fraction of the diffuse reflection that is transmitted instead.
fn reflectance_of(base_color: vec3<f32>, metallic: f32, roughness: f32, ior: f32, transmission: f32) -> Reflectance {
    let ratio = (ior - 1.0) / (ior + 1.0);
    let bounded = clamp(roughness, BRDF_SMOOTHEST, 1.0);
    return Reflectance(
        base_color * (1.0 - metallic) * (1.0 - transmission),
        mix(vec3<f32>(ratio * ratio), base_color, metallic),
        1.0,
        bounded * bounded,
        bounded,
    );
}

fn reflectance_view(reflectance: Reflectance, n_v: f32, layers: Layers) -> ReflectanceView {
    let albedo = specular_albedo(reflectance.roughness, n_v);
    var f0 = reflectance.f0;
    var once = reflectance.f0 * albedo.x + albedo.y * reflectance.f90;
    if LAYERS && layers.film > 0.0 {
        f0 = mix(f0, layers.film_reflected, layers.film);
        once = mix(once, layers.film_reflected * (albedo.x + albedo.y), layers.film);
    }
    let scattered_again = 1.0 + f0 * max(1.0 / (albedo.x + albedo.y) - 1.0, 0.0);
    let specular = once * scattered_again;
    if LAYERS && layers.is_there {
        // Coloured mirroring would give the diffuse layer the opposite colour.
        let most = max(specular.x, max(specular.y, specular.z));
        let entering = select(1.0 - specular, vec3<f32>(max(1.0 - most, 0.0)), layers.is_tinting);
        return ReflectanceView(n_v, specular * layers.below, entering * layers.below, scattered_again * layers.below);
    }
    return ReflectanceView(n_v, specular, 1.0 - specular, scattered_again);
}

// Reflected radiance towards `view` for each unit of irradiance from `light`; all three vectors of unit length and
// pointing away from the surface. Zero where `light` is below the horizon of `normal`.
fn reflectance_evaluate(
    reflectance: Reflectance,
    seen: ReflectanceView,
    normal: vec3<f32>,
    view: vec3<f32>,
    light: vec3<f32>,
    layers: Layers,
) -> vec3<f32> {
    let n_l = dot(normal, light);
    if n_l <= 0.0 {
        return vec3<f32>(0.0);
    }
    let half_way = half_vector(normal, view, light);
    let n_h = max(dot(normal, half_way), 0.0);
    var fresnel = fresnel_schlick(reflectance.f0, reflectance.f90, dot(view, half_way));
    let a2 = reflectance.alpha * reflectance.alpha;
    var lobe = ggx_distribution(a2, n_h) * smith_visibility(a2, n_l, seen.n_v);
    if LAYERS && layers.film > 0.0 {
        fresnel = mix(fresnel, layers.film_reflected, layers.film);
    }
    if LAYERS && layers.grooves.is_there {
        lobe = grooves_lobe(layers.grooves, half_way, light, n_h, n_l, seen.n_v);
    }
    return reflectance_diffuse(reflectance, seen) + fresnel * lobe * seen.scattered_again;
}

// Reflected radiance of the diffuse layer for each unit of irradiance.
fn reflectance_diffuse(reflectance: Reflectance, seen: ReflectanceView) -> vec3<f32> {
    return reflectance.diffuse / BRDF_PI * seen.entering;
}

// Reflected radiance under even light from all sides: `irradiance` around the normal, over π, for the diffuse layer and
// `reflected`, the mean radiance around the mirror direction, for the specular one.
fn reflectance_ambient(
    reflectance: Reflectance,
    seen: ReflectanceView,
    irradiance: vec3<f32>,
    reflected: vec3<f32>,
) -> vec3<f32> {
    return reflectance.diffuse / BRDF_PI * irradiance * seen.entering + seen.specular * reflected;
}

fn fresnel_schlick(f0: vec3<f32>, f90: f32, cosine: f32) -> vec3<f32> {
    let missing = 1.0 - clamp(cosine, 0.0, 1.0);
    let squared = missing * missing;
    return f0 + (f90 - f0) * (squared * squared * missing);
}
