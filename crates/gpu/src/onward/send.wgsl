// Stage `send`: writes the secondary rays of a generation's hits.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, F64_ZERO};
import package::exact::vector::{f64_vector_from_f32_bits};
import package::rays::records::{
    NO_TRIANGLE, RAY_DIRECTION, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORD_OWN, RECORD_TAG, record_start,
};
import package::rays::write::{put_number, put_vector};
import package::onward::media::{Media, media_across};
import package::onward::path::{OnwardPath};
import package::onward::points::{POINT_PIXEL, POINT_T, POINT_TRIANGLE, POINT_WORDS, point_number, read_exact_point};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, way_at, way_bits};
import package::onward::way::{
    ALL_WAYS, GLOSSY_WAYS, WAY_ALL_COLORS, WAY_BEHIND, WAY_CROSSES, WAY_FRONT, WAY_MIRROR, WAY_RED,
};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> points: array<u32>;
@group(0) @binding(4) var<storage, read_write> records: array<u32>;
@group(0) @binding(5) var<storage, read_write> paths: array<OnwardPath>;
// Of the generation that spawns them; the camera's rays have no paths yet.
@group(0) @binding(6) var<storage, read> records_before: array<u32>;
@group(0) @binding(7) var<storage, read> paths_before: array<OnwardPath>;

const SEND_INFINITE = F64(0u, 0x7ff00000u);
// Limits on surfaces in a row: from the first number on, rays with a throughput below this end; from the second on, all
// rays do.
override MANY_LAYERS: u32;
override LEAST_PART: f32;
override MOST_LAYERS: u32;

@compute @workgroup_size(64)
fn send(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= onward_step.count {
        return;
    }
    let index = index_in_planes(number);
    if index == NOWHERE {
        return;
    }
    let bits = way_bits(index);
    if bits == 0u {
        return;
    }
    var before: OnwardPath;
    var blur = 0.0;
    if onward_step.is_first == 0u {
        before = paths_before[number];
    }
    if onward_step.ways == GLOSSY_WAYS {
        blur = way_at(index, ALL_WAYS).x;
    }
    before.pixel = points[number * POINT_WORDS + POINT_PIXEL];
    var ray = starts[number];
    let first = way_at(index, 0u);
    let second = way_at(index, 1u);
    if (bits & WAY_MIRROR) != 0u {
        start_at(number, ray, before, Start(first.xyz, first.w, second.xyz, before.media, blur));
        ray += 1u;
    }
    if onward_step.ways < ALL_WAYS {
        return;
    }
    let third = way_at(index, 2u);
    let across = media_across(before.media, u32(third.w), (bits & WAY_FRONT) != 0u);
    if (bits & WAY_BEHIND) != 0u {
        var path = before;
        path.through = third.xyz;
        path.layers += 1u;
        if (bits & WAY_CROSSES) != 0u {
            path.media = across;
        }
        go_straight_on(number, ray, path);
        ray += 1u;
    }
    if (bits & WAY_ALL_COLORS) != 0u {
        start_at(number, ray, before, Start(way_at(index, 3u).xyz, first.w, way_at(index, 4u).xyz, across, blur));
        ray += 1u;
    }
    for (var color = 0u; color < 3u; color++) {
        if (bits & (WAY_RED << color)) != 0u {
            let refracted = way_at(index, 3u + color);
            var through = vec3<f32>(0.0);
            through[color] = refracted.w;
            start_at(number, ray, before, Start(refracted.xyz, first.w, through, across, blur));
            ray += 1u;
        }
    }
}

// The start of a ray at a point of a triangle.
struct Start {
    direction: vec3<f32>,
    // Length of the path from there to the camera.
    travelled: f32,
    // Throughput to the camera.
    through: vec3<f32>,
    media: Media,
    blur: f32,
}

fn start_at(number: u32, ray: u32, before: OnwardPath, start: Start) {
    let point = read_exact_point(number);
    let word = record_start(ray);
    put_vector(word, point.position);
    put_vector(word + RAY_DIRECTION, f64_vector_from_f32_bits(bitcast<vec3<u32>>(start.direction)));
    put_number(word + RAY_T_MIN, F64_ZERO);
    put_number(word + RAY_T_MAX, SEND_INFINITE);
    put_number(word + RAY_ERROR, point.error);
    records[word + RECORD_OWN] = points[number * POINT_WORDS + POINT_TRIANGLE];
    records[word + RECORD_TAG] = before.pixel;
    paths[ray] = 
        OnwardPath(start.through, start.travelled, start.media, before.pixel, before.bounces + 1u, 0u, start.blur);
}

// The same ray from behind its hit.
fn go_straight_on(number: u32, ray: u32, path: OnwardPath) {
    let word = record_start(ray);
    let word_before = record_start(number);
    for (var index = 0u; index < RAY_T_MIN; index++) {
        records[word + index] = records_before[word_before + index];
    }
    // Then the interval is empty.
    let through = max(path.through.x, max(path.through.y, path.through.z));
    let is_last = path.layers >= MOST_LAYERS || (path.layers >= MANY_LAYERS && through < LEAST_PART);
    var t = point_number(number * POINT_WORDS + POINT_T);
    if is_last {
        t = SEND_INFINITE;
    }
    put_number(word + RAY_T_MIN, t);
    put_number(word + RAY_T_MAX, SEND_INFINITE);
    put_number(word + RAY_ERROR, F64_ZERO);
    records[word + RECORD_OWN] = NO_TRIANGLE;
    records[word + RECORD_TAG] = path.pixel;
    paths[ray] = path;
}
