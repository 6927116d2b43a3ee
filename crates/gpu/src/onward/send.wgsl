// Stage `send`: the rays that go on from what a generation has met.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, F64_ZERO};
import package::exact::vector::{f64_vector_from_f32_bits};
import package::kdtree::records::{
    NO_TRIANGLE, RAY_DIRECTION, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORD_OWN, RECORD_TAG, record_start,
};
import package::kdtree::write::{put_number, put_vector};
import package::onward::media::{Media, media_across};
import package::onward::path::{OnwardPath};
import package::onward::points::{POINT_PIXEL, POINT_T, POINT_TRIANGLE, POINT_WORDS, point_number, read_exact_point};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, way_at, way_bits};
import package::onward::way::{
    WAY_ALL_COLORS, WAY_BEHIND, WAY_CROSSES, WAY_FRONT, WAY_MIRROR, WAY_RED,
};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> points: array<u32>;
@group(0) @binding(4) var<storage, read_write> records: array<u32>;
@group(0) @binding(5) var<storage, read_write> paths: array<OnwardPath>;
// Of the generation that they go on from; the camera's have no paths yet.
@group(0) @binding(6) var<storage, read> records_before: array<u32>;
@group(0) @binding(7) var<storage, read> paths_before: array<OnwardPath>;

const SEND_INFINITE = F64(0u, 0x7ff00000u);
// How many surfaces one behind the other are seen through.
const MOST_LAYERS: u32 = 32u;

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
    if onward_step.is_first == 0u {
        before = paths_before[number];
    }
    before.pixel = points[number * POINT_WORDS + POINT_PIXEL];
    var ray = starts[number];
    let first = way_at(index, 0u);
    let second = way_at(index, 1u);
    if (bits & WAY_MIRROR) != 0u {
        start_at(number, ray, before, first.xyz, second.xyz, first.w, before.media);
        ray += 1u;
    }
    if onward_step.has_all_ways == 0u {
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
        start_at(number, ray, before, way_at(index, 3u).xyz, way_at(index, 4u).xyz, first.w, across);
        ray += 1u;
    }
    for (var color = 0u; color < 3u; color++) {
        if (bits & (WAY_RED << color)) != 0u {
            let refracted = way_at(index, 3u + color);
            var through = vec3<f32>(0.0);
            through[color] = refracted.w;
            start_at(number, ray, before, refracted.xyz, through, first.w, across);
            ray += 1u;
        }
    }
}

// A ray from a point of a triangle.
fn start_at(
    number: u32,
    ray: u32,
    before: OnwardPath,
    direction: vec3<f32>,
    through: vec3<f32>,
    travelled: f32,
    media: Media,
) {
    let point = read_exact_point(number);
    let word = record_start(ray);
    put_vector(word, point.position);
    put_vector(word + RAY_DIRECTION, f64_vector_from_f32_bits(bitcast<vec3<u32>>(direction)));
    put_number(word + RAY_T_MIN, F64_ZERO);
    put_number(word + RAY_T_MAX, SEND_INFINITE);
    put_number(word + RAY_ERROR, point.error);
    records[word + RECORD_OWN] = points[number * POINT_WORDS + POINT_TRIANGLE];
    records[word + RECORD_TAG] = before.pixel;
    paths[ray] = OnwardPath(through, travelled, media, before.pixel, before.bounces + 1u, 0u);
}

// The same ray from behind what it has met.
fn go_straight_on(number: u32, ray: u32, path: OnwardPath) {
    let word = record_start(ray);
    let word_before = record_start(number);
    for (var index = 0u; index < RAY_T_MIN; index++) {
        records[word + index] = records_before[word_before + index];
    }
    // Behind so many, the interval is empty.
    let is_last = path.layers >= MOST_LAYERS;
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
