// Stages `look` and `look_onward`: choose the direction of ambient occlusion for hits of the camera's rays, and of
// secondary rays: crates/umbrage/src/cpu/onward.rs. The film has a direction for each hit.

import package::dispatch::{Invocation, flat_index};
import package::shade::drawn::{DRAWN_AROUND, drawn_point};
import package::shade::gloss::{facets_round};
import package::shade::hit::{ray_across, triangle_of};
import package::shade::meeting::{meeting_number, meeting_vector};
import package::shade::meeting_words::{
    MEETING_BOUNCES, MEETING_DEPTH, MEETING_PIXEL, MEETING_TRAVELLED, MEETING_VIEW, MEETING_WEIGHTS, MEETING_WORDS,
};
import package::shade::microfacet::{BRDF_PI};
import package::shade::surface::{surface_at, surface_of};
import package::shade::tables::{NO_TRIANGLE, shade_film, shade_sample, shade_seen};
import package::tile_order::{pixel_of_slot};

@compute @workgroup_size(64)
fn look(at: Invocation) {
    let slot = flat_index(at, 64u);
    let size = shade_sample.size_pixels;
    let column_and_row = pixel_of_slot(slot, size.x);
    if slot >= shade_sample.points || any(column_and_row >= size) {
        return;
    }
    let id = shade_seen[slot];
    if id != NO_TRIANGLE {
        let surface = surface_at(id, ray_across(column_and_row));
        let pixel = column_and_row.y * size.x + column_and_row.x;
        shade_film[slot] = vec4<f32>(scattered(surface.normal, drawn_point(pixel, 0u, DRAWN_AROUND)), 0.0);
    }
}

@compute @workgroup_size(64)
fn look_onward(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= shade_sample.points {
        return;
    }
    let word = number * MEETING_WORDS;
    let id = shade_seen[word];
    if id != NO_TRIANGLE {
        let weights = vec2<f32>(meeting_number(word + MEETING_WEIGHTS), meeting_number(word + MEETING_WEIGHTS + 1u));
        let travelled = meeting_number(word + MEETING_TRAVELLED) + meeting_number(word + MEETING_DEPTH);
        let surface = surface_of(id, triangle_of(id), weights, travelled, meeting_vector(word + MEETING_VIEW));
        let point = drawn_point(shade_seen[word + MEETING_PIXEL], shade_seen[word + MEETING_BOUNCES], DRAWN_AROUND);
        shade_film[number] = vec4<f32>(scattered(surface.normal, point), 0.0);
    }
}

// A cosine-distributed unit direction around a normal.
fn scattered(normal: vec3<f32>, point: vec2<f32>) -> vec3<f32> {
    let axes = facets_round(normal, 1.0);
    let turn = 2.0 * BRDF_PI * point.y;
    let radius = sqrt(point.x);
    return axes.right * (radius * cos(turn)) + axes.up * (radius * sin(turn)) + normal * sqrt(max(1.0 - point.x, 0.0));
}
