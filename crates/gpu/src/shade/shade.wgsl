// Adds each pixel's radiance at the current sample to the film: crates/umbrage/src/cpu/shade.rs.
//
// A dispatch takes one layer of surfaces. Layers come front to back: what those so far let through is kept for each
// pixel, and after the last one the surroundings are seen through them.

import package::dispatch::{Invocation, flat_index};
import package::shade::brdf::{reflectance_ambient, reflectance_diffuse, reflectance_evaluate, reflectance_view};
import package::shade::hit::{ray_across, ray_direction};
import package::shade::irradiance::{arriving_light};
import package::shade::layers::{LAYERS, layers_ambient, layers_lit, layers_scattered, layers_surrounding};
import package::shade::surface::{Surface, surface_at};
import package::shade::surroundings::{surroundings_are_flat, surroundings_irradiance, surroundings_radiance};
import package::shade::tables::{
    NO_TRIANGLE, NO_WORD, shade_film, shade_lights, shade_lit, shade_sample, shade_scene, shade_seen,
};
import package::tile_order::{pixel_of_slot};

// In place of no light at all, so that the darkest surfaces are whole.
const LEAST_IRRADIANCE: f32 = 1e-30;
// So that sums are finite.
const MOST_IRRADIANCE: f32 = 1e30;

@compute @workgroup_size(64)
fn shade(at: Invocation) {
    let slot = flat_index(at, 64u);
    let size = shade_sample.size_pixels;
    let column_and_row = pixel_of_slot(slot, size.x);
    if any(column_and_row >= size) {
        return;
    }
    let pixel = column_and_row.y * size.x + column_and_row.x;
    let across = ray_across(column_and_row);
    let id = shade_seen[slot];
    var color = vec3<f32>(0.0);
    // What of it is shown as it is, and of how much of the pixel.
    var flat_color = vec4<f32>(0.0);
    var through = vec3<f32>(1.0);
    if shade_sample.is_first_layer == 0u {
        through = shade_film[shade_sample.through_plane + pixel].xyz;
    }
    // Whether what is behind is seen, rather than the surroundings alone.
    var is_through = any(through != vec3<f32>(0.0));
    // Normal and depth.
    var first = vec4<f32>(0.0, 0.0, 0.0, shade_sample.miss_depth);
    if id != NO_TRIANGLE && max(through.x, max(through.y, through.z)) > 0.0 {
        let surface = surface_at(id, across);
        if surface.catches_shadows {
            through *= caught_light(surface, slot);
            is_through = false;
        } else {
            let part = through * surface.opacity;
            color = reflected(surface, slot) * part;
            if surface.is_unlit {
                flat_color = vec4<f32>(color, mean(part));
            }
            through *= mix(vec3<f32>(1.0), surface.transmitted, surface.opacity);
            is_through = any(through != vec3<f32>(0.0));
        }
        first = vec4<f32>(surface.normal, surface.depth);
    }
    if !is_through && shade_sample.is_last_layer == 0u {
        shade_seen[slot] = NO_TRIANGLE;
    }
    var coverage = 0.0;
    if shade_sample.is_last_layer != 0u {
        if any(through != vec3<f32>(0.0)) {
            let around = surroundings_radiance(ray_direction(across)) * through;
            color += around;
            if surroundings_are_flat() {
                flat_color += vec4<f32>(around, mean(through));
            }
        }
        coverage = 1.0 - mean(through);
    } else {
        shade_film[shade_sample.through_plane + pixel] = vec4<f32>(through, 0.0);
    }
    if shade_sample.is_first_layer != 0u && shade_sample.is_first_sample != 0u {
        shade_film[pixel] = vec4<f32>(color, coverage);
        if shade_sample.first_plane != NO_WORD {
            shade_film[shade_sample.first_plane + pixel] = first;
        }
    } else {
        shade_film[pixel] += vec4<f32>(color, coverage);
    }
    if shade_sample.flat_plane != NO_WORD {
        let is_start = shade_sample.is_first_layer != 0u && shade_sample.is_first_sample != 0u;
        let before = select(shade_film[shade_sample.flat_plane + pixel], vec4<f32>(0.0), is_start);
        shade_film[shade_sample.flat_plane + pixel] = before + flat_color;
    }
}

fn mean(color: vec3<f32>) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

// Radiance that a surface sends along the ray, by itself and from the lights that reach it.
fn reflected(surface: Surface, slot: u32) -> vec3<f32> {
    if surface.is_unlit {
        return surface.base_color;
    }
    let normal = surface.normal;
    let view = surface.view;
    let n_v = dot(normal, view);
    let irradiance = ambient_irradiance(normal);
    var ambient = reflectance_ambient(
        surface.reflectance,
        reflectance_view(surface.reflectance, max(n_v, 0.0), surface.layers),
        irradiance,
        layers_surrounding(surface.layers, surface.reflectance.roughness, normal, view),
    );
    var emitted = surface.emitted;
    if LAYERS && surface.layers.is_there {
        ambient += layers_ambient(surface.layers, view, irradiance);
        emitted *= surface.layers.below_coat;
    }
    let seen = reflectance_view(surface.reflectance, max(n_v, 1e-4), surface.layers);
    var radiance = emitted + ambient * surface.ambient_occlusion;
    for (var light = 0u; light < shade_scene.light_count; light++) {
        if !is_lit(light, slot) {
            continue;
        }
        let arriving = arriving_light(shade_lights[light], surface.corner, surface.from_corner);
        // Light from behind the triangle lights its other side, whatever the bent normal says.
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

// Which part of its light reaches a surface of which only shadows are seen: crates/umbrage/src/cpu/caught.rs.
fn caught_light(surface: Surface, slot: u32) -> vec3<f32> {
    var light_sum = ambient_irradiance(surface.normal) + vec3<f32>(LEAST_IRRADIANCE);
    // The sky's lights have as much in all.
    var all_light = surroundings_irradiance(surface.normal) + vec3<f32>(LEAST_IRRADIANCE);
    for (var light = 0u; light < shade_scene.light_count; light++) {
        let arriving = arriving_light(shade_lights[light], surface.corner, surface.from_corner);
        let facing = arriving.irradiance * dot(surface.normal, arriving.towards);
        let irradiance = clamp(facing, vec3<f32>(0.0), vec3<f32>(MOST_IRRADIANCE));
        if !is_of_sky(light) {
            all_light += irradiance;
        }
        if is_lit(light, slot) && dot(surface.geometric_normal, arriving.towards) > 0.0 {
            light_sum += irradiance;
        }
    }
    return light_sum / all_light;
}

// From all around, unless it comes by lights.
fn ambient_irradiance(normal: vec3<f32>) -> vec3<f32> {
    if shade_scene.sky_light_count > 0u {
        return vec3<f32>(0.0);
    }
    return surroundings_irradiance(normal);
}

// Whether a light is that from all around in one direction.
fn is_of_sky(light: u32) -> bool {
    return light + shade_scene.sky_light_count >= shade_scene.light_count;
}

fn is_lit(light: u32, slot: u32) -> bool {
    let word = shade_lit[light * shade_sample.words_per_light + slot / 32u];
    return ((word >> (slot % 32u)) & 1u) == 1u;
}
