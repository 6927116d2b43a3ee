// Anisotropic highlights: crates/umbrage/src/shade/grooves.rs, which has the sources.

import package::shade::microfacet::{BRDF_PI};

struct Grooves {
    is_there: bool,
    // Unit vectors along the surface, in the direction of the stretch and across it.
    along: vec3<f32>,
    across: vec3<f32>,
    // GGX widths in these directions.
    alpha_along: f32,
    alpha_across: f32,
    strength: f32,
    // Perceptual roughness across the stretch.
    roughness: f32,
    // Length of the view in the ellipse of the widths.
    view: f32,
}

// Minimum squared length of a vector that has a direction.
const GROOVES_LEAST_SQUARED: f32 = 1e-37;

fn grooves_of(direction: vec3<f32>, strength: f32, roughness: f32, normal: vec3<f32>, view: vec3<f32>) -> Grooves {
    var grooves: Grooves;
    let flat = direction - normal * dot(direction, normal);
    let squared = dot(flat, flat);
    grooves.is_there = squared > GROOVES_LEAST_SQUARED;
    if !grooves.is_there {
        return grooves;
    }
    grooves.along = flat * inverseSqrt(squared);
    grooves.across = cross(normal, grooves.along);
    grooves.alpha_across = roughness * roughness;
    grooves.alpha_along = mix(grooves.alpha_across, 1.0, strength * strength);
    grooves.strength = strength;
    grooves.roughness = roughness;
    grooves.view = grooves_length(grooves, view, max(dot(normal, view), 1e-4));
    return grooves;
}

// Perceptual roughness of an isotropic highlight that covers the same area.
fn grooves_mean_roughness(grooves: Grooves) -> f32 {
    return sqrt(sqrt(grooves.alpha_along * grooves.alpha_across));
}

// Distribution times visibility.
fn grooves_lobe(grooves: Grooves, half_way: vec3<f32>, light: vec3<f32>, n_h: f32, n_l: f32, n_v: f32) -> f32 {
    let area = grooves.alpha_along * grooves.alpha_across;
    let scaled = vec3<f32>(
        grooves.alpha_across * dot(grooves.along, half_way),
        grooves.alpha_along * dot(grooves.across, half_way),
        area * n_h,
    );
    let width = area / dot(scaled, scaled);
    return area * width * width / BRDF_PI * 0.5 / (n_l * grooves.view + n_v * grooves_length(grooves, light, n_l));
}

// Length of a direction in the ellipse of the widths.
fn grooves_length(grooves: Grooves, direction: vec3<f32>, cosine: f32) -> f32 {
    let along = grooves.alpha_along * dot(grooves.along, direction);
    let across = grooves.alpha_across * dot(grooves.across, direction);
    return sqrt(along * along + across * across + cosine * cosine);
}

// The single direction that stands for all mirrored light.
fn grooves_mirrored(grooves: Grooves, normal: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    var bent = grooves_unit(cross(cross(grooves.across, view), grooves.across), normal);
    let straight = 1.0 - grooves.strength * (1.0 - grooves.roughness);
    let squared = straight * straight;
    bent = grooves_unit(mix(bent, normal, squared * squared), normal);
    return reflect(-view, bent);
}

fn grooves_unit(vector: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let squared = dot(vector, vector);
    if squared <= GROOVES_LEAST_SQUARED {
        return otherwise;
    }
    return vector * inverseSqrt(squared);
}
