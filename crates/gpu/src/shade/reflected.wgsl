// Radiance that surfaces send along a ray: crates/umbrage/src/cpu/met.rs.

import package::shade::brdf::{reflectance_ambient, reflectance_diffuse, reflectance_evaluate, reflectance_view};
import package::shade::irradiance::{arriving_light};
import package::shade::layers::{LAYERS, layers_ambient, layers_lit, layers_scattered, layers_surrounding};
import package::shade::ways::{Ways};
import package::shade::surface::{Surface};
import package::shade::surroundings::{surroundings_irradiance};
import package::shade::tables::{NO_WORD, shade_lights, shade_lit, shade_sample, shade_scene};

// Added to all light, so that a surface without any light counts as fully lit.
const LEAST_IRRADIANCE: f32 = 1e-30;
// Clamp that keeps sums finite.
const MOST_IRRADIANCE: f32 = 1e30;

// Radiance that a surface sends along the ray: emission and direct light, without followed rays.
fn reflected(surface: Surface, slot: u32, ways: Ways) -> vec3<f32> {
    if surface.is_unlit {
        return surface.base_color;
    }
    let normal = surface.normal;
    let view = surface.view;
    if ways.is_inside {
        return emitted_at(surface);
    }
    let n_v = dot(normal, view);
    let irradiance = ambient_irradiance(normal, slot);
    var around = vec3<f32>(0.0);
    if !ways.is_of_surface {
        around = layers_surrounding(surface.layers, surface.reflectance.roughness, normal, view);
    }
    let seen_around = reflectance_view(surface.reflectance, max(n_v, 0.0), surface.layers);
    var ambient = reflectance_ambient(surface.reflectance, seen_around, irradiance, around);
    if LAYERS && surface.layers.is_there {
        ambient += layers_ambient(surface.layers, view, irradiance, ways.is_of_coat);
    }
    let seen = reflectance_view(surface.reflectance, max(n_v, 1e-4), surface.layers);
    var radiance = emitted_at(surface) + ambient * surface.ambient_occlusion;
    for (var light = 0u; light < shade_scene.light_count; light++) {
        if !is_lit(light, slot) {
            continue;
        }
        var arriving = arriving_light(shade_lights[light], surface.corner, surface.from_corner);
        arriving.irradiance *= tint_of(light, slot);
        // Light from behind the triangle lights its other side, for any bent normal.
        if dot(surface.geometric_normal, arriving.towards) > 0.0 {
            let irradiance = arriving.irradiance * max(dot(normal, arriving.towards), 0.0);
            if is_of_sky(light) {
                var scattered = reflectance_diffuse(surface.reflectance, seen);
                if LAYERS && surface.layers.is_there {
                    scattered += layers_scattered(surface.layers);
                }
                radiance += scattered * irradiance;
            } else {
                let layers = surface.layers;
                let towards = arriving.towards;
                radiance += reflectance_evaluate(surface.reflectance, seen, normal, view, towards, layers) * irradiance;
                if LAYERS && layers.is_there {
                    radiance += layers_lit(layers, view, towards) * arriving.irradiance;
                }
            }
        }
    }
    return radiance;
}

fn emitted_at(surface: Surface) -> vec3<f32> {
    if LAYERS && surface.layers.is_there {
        return surface.emitted * surface.layers.below_coat;
    }
    return surface.emitted;
}

// Fraction of its light that reaches a shadow catcher: crates/umbrage/src/cpu/caught.rs.
fn caught_light(surface: Surface, slot: u32) -> vec3<f32> {
    var light_sum = ambient_irradiance(surface.normal, slot) + vec3<f32>(LEAST_IRRADIANCE);
    // The sky's lights have the same total.
    var all_light = surroundings_irradiance(surface.normal) + vec3<f32>(LEAST_IRRADIANCE);
    for (var light = 0u; light < shade_scene.light_count; light++) {
        let arriving = arriving_light(shade_lights[light], surface.corner, surface.from_corner);
        let facing = arriving.irradiance * dot(surface.normal, arriving.towards);
        let irradiance = clamp(facing, vec3<f32>(0.0), vec3<f32>(MOST_IRRADIANCE));
        if !is_of_sky(light) {
            all_light += irradiance;
        }
        if is_lit(light, slot) && dot(surface.geometric_normal, arriving.towards) > 0.0 {
            light_sum += irradiance * tint_of(light, slot);
        }
    }
    return light_sum / all_light;
}

// Ambient irradiance; zero if lights carry it, or if a near surface occludes it.
fn ambient_irradiance(normal: vec3<f32>, slot: u32) -> vec3<f32> {
    if shade_scene.sky_light_count > 0u {
        return vec3<f32>(0.0);
    }
    let irradiance = surroundings_irradiance(normal);
    if shade_sample.looks_around == 0u {
        return irradiance;
    }
    // Its visibility has the mask behind those of all lights.
    if !is_lit(shade_scene.light_count, slot) {
        return vec3<f32>(0.0);
    }
    return irradiance * tint_of(shade_scene.light_count, slot);
}

// Whether a light carries the sky's light from one direction.
fn is_of_sky(light: u32) -> bool {
    return light + shade_scene.sky_light_count >= shade_scene.light_count;
}

fn is_lit(light: u32, slot: u32) -> bool {
    let word = shade_lit[light * shade_sample.words_per_light + slot / 32u];
    return ((word >> (slot % 32u)) & 1u) == 1u;
}

// Transmittance of surfaces between a light and a lit point, for red, green and blue.
fn tint_of(light: u32, slot: u32) -> vec3<f32> {
    if shade_sample.tints_word == NO_WORD {
        return vec3<f32>(1.0);
    }
    let word = shade_sample.tints_word + 2u * (light * shade_sample.words_per_light * 32u + slot);
    return vec3<f32>(unpack2x16unorm(shade_lit[word]), unpack2x16unorm(shade_lit[word + 1u]).x);
}
