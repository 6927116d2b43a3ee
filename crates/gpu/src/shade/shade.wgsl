// Adds each pixel's radiance at the current sample to the film: crates/umbrage/src/cpu/shade.rs.
//
// A dispatch takes one layer of surfaces. Layers come front to back: the film keeps each pixel's transmittance so far,
// and after the last layer the surroundings are seen through it.

import package::dispatch::{Invocation, flat_index};
import package::shade::hit::{ray_across, ray_direction};
import package::onward::media::{Media};
import package::shade::reflected::{caught_light, reflected};
import package::shade::surface::{surface_at};
import package::shade::surroundings::{surroundings_are_flat, surroundings_radiance};
import package::shade::tables::{NO_TRIANGLE, NO_WORD, shade_film, shade_sample, shade_seen};
import package::shade::ways::{Route, Ways, keep_ways, passing_at, ways_of};
import package::tile_order::{pixel_of_slot};

// Whether visible surfaces spawn secondary rays, so that surfaces behind them aren't another layer.
override FOLLOWS: bool = false;

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
    // The part of the colour that is shown without tone mapping, and the fraction of the pixel that it covers.
    var flat_color = vec4<f32>(0.0);
    var through = vec3<f32>(1.0);
    if shade_sample.is_first_layer == 0u {
        through = shade_film[shade_sample.through_plane + pixel].xyz;
    }
    // Whether surfaces behind are seen, rather than the surroundings alone.
    var is_through = any(through != vec3<f32>(0.0));
    // Normal and depth.
    var first = vec4<f32>(0.0, 0.0, 0.0, shade_sample.miss_depth);
    var ways: Ways;
    var material = 0u;
    if id != NO_TRIANGLE && max(through.x, max(through.y, through.z)) > 0.0 {
        let surface = surface_at(id, across);
        if surface.catches_shadows {
            through *= caught_light(surface, slot);
            is_through = false;
        } else {
            let part = through * surface.opacity;
            if FOLLOWS {
                ways = ways_of(surface, Route(through, 0u, 0.0, pixel, Media()));
                material = surface.material;
            }
            color = reflected(surface, slot, ways) * part;
            if surface.is_unlit {
                flat_color = vec4<f32>(color, mean(part));
            }
            if FOLLOWS {
                through = ways.passing;
            } else {
                through *= passing_at(surface);
            }
            is_through = any(through != vec3<f32>(0.0));
        }
        first = vec4<f32>(surface.normal, surface.depth);
    }
    if FOLLOWS {
        keep_ways(ways, material, first.w, pixel, size.x * size.y);
    }
    if !is_through && shade_sample.is_last_layer == 0u {
        shade_seen[slot] = NO_TRIANGLE;
    }
    var coverage = 0.0;
    if shade_sample.is_last_layer != 0u {
        // The ways of a followed, transparent surface lead to the surroundings too.
        if any(through != vec3<f32>(0.0)) && ways.bits == 0u {
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
