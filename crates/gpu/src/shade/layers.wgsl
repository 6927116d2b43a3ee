// Layers that few materials have, as seen from one side: crates/umbrage/src/shade/layers.rs.

import package::shade::coat::{Coat, coat_albedo, coat_lit};
import package::shade::grooves::{Grooves, grooves_mirrored};
import package::shade::microfacet::{BRDF_PI};
import package::shade::sheen::{Sheen, sheen_lit};
import package::shade::surroundings::{surroundings_blurred};

// Whether any material has layers.
override LAYERS: bool = false;

struct Layers {
    is_there: bool,
    // Whether its specular reflection has a colour of its own.
    is_tinting: bool,
    has_sheen: bool,
    has_coat: bool,
    // Fraction of the specular reflection that a film colours, and the reflectance there.
    film: f32,
    film_reflected: vec3<f32>,
    grooves: Grooves,
    sheen: Sheen,
    coat: Coat,
    // Fraction of light that sheen and coat together leave to the layers below, and the fraction that the coat alone leaves.
    below: f32,
    below_coat: f32,
    // Perceptual roughness of the specular layer; with grooves, that of an isotropic highlight of the same area.
    roughness: f32,
}

// Reflectance of the top layers, for each unit of irradiance of a surface that faces the light.
fn layers_lit(layers: Layers, view: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    var reflected = vec3<f32>(0.0);
    if layers.has_sheen {
        reflected += sheen_lit(layers.sheen, view, light) * layers.below_coat;
    }
    if layers.has_coat {
        reflected += coat_lit(layers.coat, view, light);
    }
    return reflected;
}

// Radiance that the top layers scatter, for each unit of ambient irradiance.
fn layers_scattered(layers: Layers) -> vec3<f32> {
    if !layers.has_sheen {
        return vec3<f32>(0.0);
    }
    return layers.sheen.color * (layers.sheen.albedo * layers.below_coat / BRDF_PI);
}

// Reflection of the surroundings by the top layers, for this irradiance; without the coat if its reflection is followed.
fn layers_ambient(layers: Layers, view: vec3<f32>, irradiance: vec3<f32>, is_coat_followed: bool) -> vec3<f32> {
    var reflected = layers_scattered(layers) * irradiance;
    if layers.has_coat && !is_coat_followed {
        let around = surroundings_blurred(reflect(-view, layers.coat.normal), layers.coat.roughness);
        reflected += coat_albedo(layers.coat) * around;
    }
    return reflected;
}

// Mean radiance around the direction that stands for all light mirrored by the specular layer.
fn layers_surrounding(layers: Layers, roughness: f32, normal: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    if LAYERS && layers.grooves.is_there {
        return surroundings_blurred(grooves_mirrored(layers.grooves, normal, view), layers.grooves.roughness);
    }
    return surroundings_blurred(reflect(-view, normal), roughness);
}
