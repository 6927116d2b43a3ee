// What few materials have beyond metal, colour and roughness, as it is seen from one side: crates/umbrage/src/shade/layers.rs.

import package::shade::coat::{Coat, coat_albedo, coat_lit};
import package::shade::grooves::{Grooves, grooves_mirrored};
import package::shade::microfacet::{BRDF_PI};
import package::shade::sheen::{Sheen, sheen_lit};
import package::shade::surroundings::{surroundings_blurred};

// Whether any material has layers.
override LAYERS: bool = false;

struct Layers {
    is_there: bool,
    // Whether it mirrors in a colour of its own.
    is_tinting: bool,
    has_sheen: bool,
    has_coat: bool,
    // How much of what is mirrored a film colours, and what it makes of it.
    film: f32,
    film_reflected: vec3<f32>,
    grooves: Grooves,
    sheen: Sheen,
    coat: Coat,
    // What sheen and coat leave of the light of what is below them, and what the coat alone does.
    below: f32,
    below_coat: f32,
    // Perceptual roughness of the specular layer; with grooves, of a round highlight that covers as much.
    roughness: f32,
}

// What the layers on top reflect of a light, for each unit that it sends to surfaces that face it.
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

// What the layers on top scatter of light from all around, for each unit of irradiance.
fn layers_scattered(layers: Layers) -> vec3<f32> {
    if !layers.has_sheen {
        return vec3<f32>(0.0);
    }
    return layers.sheen.color * (layers.sheen.albedo * layers.below_coat / BRDF_PI);
}

// What the layers on top reflect of what is around the scene, of which so much comes to the surface; without the coat where
// that is followed.
fn layers_ambient(layers: Layers, view: vec3<f32>, irradiance: vec3<f32>, is_coat_followed: bool) -> vec3<f32> {
    var reflected = layers_scattered(layers) * irradiance;
    if layers.has_coat && !is_coat_followed {
        let around = surroundings_blurred(reflect(-view, layers.coat.normal), layers.coat.roughness);
        reflected += coat_albedo(layers.coat) * around;
    }
    return reflected;
}

// The mean radiance around where light comes from that stands for all that the specular layer mirrors.
fn layers_surrounding(layers: Layers, roughness: f32, normal: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    if LAYERS && layers.grooves.is_there {
        return surroundings_blurred(grooves_mirrored(layers.grooves, normal, view), layers.grooves.roughness);
    }
    return surroundings_blurred(reflect(-view, normal), roughness);
}
