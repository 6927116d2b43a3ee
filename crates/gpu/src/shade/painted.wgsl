// A material's layers at a point, textures included: crates/umbrage/src/shade/layer_paint.rs.

import package::shade::brdf::{Reflectance};
import package::shade::coat::{coat_of};
import package::shade::facet::{Facet, bend, bent_by_texture, on_the_side_of_the_ray, texel_at};
import package::shade::film::{film_reflected};
import package::shade::grooves::{grooves_mean_roughness, grooves_of};
import package::shade::layers::{Layers};
import package::shade::sheen::{sheen_below, sheen_of};
import package::shade::tables::{
    LAYER_COAT, LAYER_FILM, LAYER_GROOVES, LAYER_SHEEN, LAYER_SPECULAR, TEXTURE_COAT, TEXTURE_COAT_NORMAL,
    TEXTURE_COAT_ROUGHNESS, TEXTURE_FILM, TEXTURE_FILM_THICKNESS, TEXTURE_GROOVES, TEXTURE_SHEEN_COLOR,
    TEXTURE_SHEEN_ROUGHNESS, TEXTURE_SPECULAR, TEXTURE_SPECULAR_COLOR, shade_materials,
};

// A thicker film's interference averages out for the eye.
const THICKEST_NANOMETERS: f32 = 1e5;

// The reflectance with the material's strength and colour of dielectric reflection.
fn specular_at(
    material: u32,
    facet: Facet,
    plain: Reflectance,
    base_color: vec3<f32>,
    metallic: f32,
) -> Reflectance {
    var reflectance = plain;
    if (shade_materials[material].layer_bits & LAYER_SPECULAR) == 0u {
        return reflectance;
    }
    let factor = shade_materials[material].layers.specular * texel_at(material, TEXTURE_SPECULAR, facet).w;
    let weight = clamp(factor, 0.0, 1.0);
    let color = shade_materials[material].layers.specular_color * texel_at(material, TEXTURE_SPECULAR_COLOR, facet).xyz;
    let ior = shade_materials[material].ior;
    let ratio = (ior - 1.0) / (ior + 1.0);
    let dielectric = min(max(color, vec3<f32>(0.0)) * (ratio * ratio), vec3<f32>(1.0)) * weight;
    reflectance.f0 = mix(dielectric, base_color, metallic);
    reflectance.f90 = mix(weight, 1.0, metallic);
    return reflectance;
}

// `smooth_one` is the normal on the front of the surface without bumps, `normal` the shading normal.
fn layers_at(
    material: u32,
    facet: Facet,
    smooth_one: vec3<f32>,
    normal: vec3<f32>,
    reflectance: Reflectance,
) -> Layers {
    let bits = shade_materials[material].layer_bits;
    let factors = shade_materials[material].layers;
    var layers: Layers;
    layers.is_there = true;
    layers.is_tinting = (bits & (LAYER_SPECULAR | LAYER_FILM)) != 0u;
    layers.below_coat = 1.0;
    layers.roughness = reflectance.roughness;
    if (bits & LAYER_GROOVES) != 0u {
        let used = shade_materials[material].textures[TEXTURE_GROOVES];
        let texel = texel_at(material, TEXTURE_GROOVES, facet);
        let direction = select(texel.xy * 2.0 - 1.0, vec2<f32>(1.0, 0.0), used.levels == 0u);
        let turn = factors.stretch_turn;
        let turned =
            vec3<f32>(direction.x * turn.x - direction.y * turn.y, direction.x * turn.y + direction.y * turn.x, 0.0);
        let along = bend(facet, used.tex_coord_set, turned, smooth_one);
        let strength = clamp(factors.stretch * texel.z, 0.0, 1.0);
        layers.grooves = grooves_of(along, strength, reflectance.roughness, normal, facet.view);
        if layers.grooves.is_there {
            layers.roughness = grooves_mean_roughness(layers.grooves);
        }
    }
    if (bits & LAYER_FILM) != 0u {
        let part = texel_at(material, TEXTURE_FILM_THICKNESS, facet).y;
        let nanometers = mix(factors.film_nanometers.x, factors.film_nanometers.y, part);
        let n_v = max(dot(normal, facet.view), 1e-4);
        let bounded = clamp(nanometers, 0.0, THICKEST_NANOMETERS);
        layers.film = clamp(factors.film * texel_at(material, TEXTURE_FILM, facet).x, 0.0, 1.0);
        layers.film_reflected = film_reflected(factors.film_ior, bounded, reflectance.f0, n_v);
    }
    if (bits & LAYER_COAT) != 0u {
        let texel = texel_at(material, TEXTURE_COAT_NORMAL, facet);
        let scale = factors.coat_normal_scale;
        let bent = bent_by_texture(material, TEXTURE_COAT_NORMAL, scale, facet, texel, smooth_one);
        let factor = clamp(factors.coat * texel_at(material, TEXTURE_COAT, facet).x, 0.0, 1.0);
        let roughness = factors.coat_roughness * texel_at(material, TEXTURE_COAT_ROUGHNESS, facet).y;
        layers.has_coat = true;
        layers.coat = coat_of(factor, roughness, on_the_side_of_the_ray(facet, smooth_one, bent), facet.view);
        layers.below_coat = 1.0 - layers.coat.part;
    }
    layers.below = layers.below_coat;
    if (bits & LAYER_SHEEN) != 0u {
        let color = factors.sheen_color * texel_at(material, TEXTURE_SHEEN_COLOR, facet).xyz;
        let roughness = factors.sheen_roughness * texel_at(material, TEXTURE_SHEEN_ROUGHNESS, facet).w;
        layers.has_sheen = true;
        layers.sheen = sheen_of(clamp(color, vec3<f32>(0.0), vec3<f32>(1.0)), roughness, normal, facet.view);
        layers.below *= sheen_below(layers.sheen);
    }
    return layers;
}
