// Microfacets, invisible mirrors with normals in GGX's distribution: crates/umbrage/src/shade/gloss.rs, which has the
// sources.

import package::shade::layers::{LAYERS, Layers};
import package::shade::microfacet::{BRDF_PI};

struct Facets {
    // Unit vectors along the surface, and its normal.
    right: vec3<f32>,
    up: vec3<f32>,
    normal: vec3<f32>,
    // GGX widths along the first two.
    widths: vec2<f32>,
}

// Isotropic microfacets around a unit normal.
fn facets_round(normal: vec3<f32>, alpha: f32) -> Facets {
    let side = select(1.0, -1.0, normal.z < 0.0);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return Facets(
        vec3<f32>(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3<f32>(b, side + normal.y * normal.y * a, -normal.y),
        normal,
        vec2<f32>(alpha),
    );
}

// Microfacets of a surface with this GGX width, or with grooves.
fn facets_of(normal: vec3<f32>, alpha: f32, layers: Layers) -> Facets {
    if LAYERS && layers.grooves.is_there {
        let widths = vec2<f32>(layers.grooves.alpha_along, layers.grooves.alpha_across);
        return Facets(layers.grooves.along, layers.grooves.across, normal, widths);
    }
    return facets_round(normal, alpha);
}

// GGX width of an isotropic surface with the same spread.
fn facets_mean_width(facets: Facets) -> f32 {
    return sqrt(facets.widths.x * facets.widths.y);
}

// Samples a microfacet's normal in proportion to those visible from a unit direction on the side of the normal.
fn facets_visible(facets: Facets, view: vec3<f32>, point: vec2<f32>) -> vec3<f32> {
    let scale = vec3<f32>(facets.widths, 1.0);
    let seen = facets_inside(facets, view);
    let stretched = normalize(vec3<f32>(seen.xy, max(seen.z, 0.0)) * scale);
    let height = (1.0 - point.y) * (1.0 + stretched.z) - stretched.z;
    let turn = 2.0 * BRDF_PI * point.x;
    let radius = sqrt(max(1.0 - height * height, 0.0));
    let half_way = (vec3<f32>(radius * cos(turn), radius * sin(turn), height) + stretched) * scale;
    let squared = dot(half_way, half_way);
    let facet = select(vec3<f32>(0.0, 0.0, 1.0), half_way * inverseSqrt(max(squared, 1e-37)), squared > 1e-37);
    return facets.right * facet.x + facets.up * facet.y + facets.normal * facet.z;
}

// Smith's masking-shadowing G2 over the masking G1 of the view: the fraction of light from visible facets that isn't
// shadowed.
fn facets_unshadowed(facets: Facets, view: vec3<f32>, light: vec3<f32>) -> f32 {
    let before = 1.0 + facets_hidden(facets, view);
    return before / (before + facets_hidden(facets, light));
}

// The same for light that is transmitted through facets.
fn facets_unshadowed_behind(facets: Facets, light: vec3<f32>) -> f32 {
    return 1.0 / (1.0 + facets_hidden(facets, light));
}

fn facets_hidden(facets: Facets, way: vec3<f32>) -> f32 {
    let inside = facets_inside(facets, way);
    let squared = clamp(inside.z * inside.z, 1e-12, 1.0);
    var across = facets.widths.x * facets.widths.x * (1.0 - squared);
    if facets.widths.x != facets.widths.y {
        let scaled = inside.xy * facets.widths;
        across = dot(scaled, scaled);
    }
    return 0.5 * (sqrt(1.0 + across / squared) - 1.0);
}

fn facets_inside(facets: Facets, way: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(way, facets.right), dot(way, facets.up), dot(way, facets.normal));
}
