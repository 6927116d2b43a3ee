// Stage `meet`: converts the tracer's hits to the points and meetings that lights and shading read.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, f64_subtract, f64_to_f32_bits};
import package::exact::shadow::{exact_point};
import package::rays::read::{read_number, read_ray};
import package::rays::records::{HIT_WORDS, NO_TRIANGLE, RAY_T_MIN, RECORDS_COUNT, record_start};
import package::onward::path::{OnwardPath};
import package::onward::points::{POINT_PIXEL, POINT_TRIANGLE, POINT_WORDS};
import package::onward::put_point::{put_point};
import package::shade::meeting_words::{
    MEETING_BLUR, MEETING_BOUNCES, MEETING_DEPTH, MEETING_INSIDE, MEETING_MEDIA, MEETING_MEDIA_COUNT, MEETING_PIXEL,
    MEETING_THROUGH, MEETING_TRAVELLED, MEETING_VIEW, MEETING_WEIGHTS, MEETING_WORDS,
};

@group(0) @binding(0) var<storage, read> records: array<u32>;
@group(0) @binding(1) var<storage, read> hits: array<u32>;
@group(0) @binding(2) var<storage, read> paths: array<OnwardPath>;
@group(0) @binding(3) var<storage, read_write> points: array<u32>;
@group(0) @binding(4) var<storage, read_write> meetings: array<u32>;

@compute @workgroup_size(64)
fn meet(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    let ray = read_ray(record_start(number));
    let hit = number * HIT_WORDS;
    let id = hits[hit];
    let path = paths[number];
    points[number * POINT_WORDS + POINT_TRIANGLE] = id;
    points[number * POINT_WORDS + POINT_PIXEL] = path.pixel;
    let along = bitcast<vec3<f32>>(vec3<u32>(
        f64_to_f32_bits(ray.direction.x), f64_to_f32_bits(ray.direction.y), f64_to_f32_bits(ray.direction.z),
    ));
    let to = number * MEETING_WORDS;
    meetings[to] = id;
    if id != NO_TRIANGLE {
        let t = F64(hits[hit + 2u], hits[hit + 3u]);
        put_point(number, exact_point(ray, t), t, id, path.pixel);
        meetings[to + MEETING_WEIGHTS] = hits[hit + 4u];
        meetings[to + MEETING_WEIGHTS + 1u] = hits[hit + 5u];
        meetings[to + MEETING_DEPTH] = f64_to_f32_bits(t);
        let since = f64_subtract(t, read_number(record_start(number) + RAY_T_MIN));
        meetings[to + MEETING_INSIDE] = bitcast<u32>(bitcast<f32>(f64_to_f32_bits(since)) * length(along));
    }
    let view = bitcast<vec3<u32>>(-normalize(along));
    for (var axis = 0u; axis < 3u; axis++) {
        meetings[to + MEETING_VIEW + axis] = view[axis];
        meetings[to + MEETING_THROUGH + axis] = bitcast<u32>(path.through[axis]);
    }
    meetings[to + MEETING_TRAVELLED] = bitcast<u32>(path.travelled);
    for (var index = 0u; index < 4u; index++) {
        meetings[to + MEETING_MEDIA + index] = path.media.materials[index];
    }
    meetings[to + MEETING_MEDIA_COUNT] = path.media.count;
    meetings[to + MEETING_BOUNCES] = path.bounces;
    meetings[to + MEETING_PIXEL] = path.pixel;
    meetings[to + MEETING_BLUR] = bitcast<u32>(path.blur);
}
