// Stage `send`: the rays that go on from what a generation has met.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, F64_ZERO};
import package::exact::vector::{f64_vector_from_f32_bits};
import package::kdtree::records::{
    RAY_DIRECTION, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORD_OWN, RECORD_TAG, record_start,
};
import package::kdtree::write::{put_number, put_vector};
import package::onward::path::{OnwardPath};
import package::onward::points::{POINT_PIXEL, POINT_TRIANGLE, POINT_WORDS, read_exact_point};
import package::onward::step::{NOWHERE, OnwardStep, index_in_planes, second_way};

@group(0) @binding(0) var<uniform> onward_step: OnwardStep;
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> points: array<u32>;
@group(0) @binding(4) var<storage, read_write> records: array<u32>;
@group(0) @binding(5) var<storage, read_write> paths: array<OnwardPath>;

const SEND_INFINITE = F64(0u, 0x7ff00000u);

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
    let second = planes[second_way(index)];
    if second.w > 0.0 {
        let first = planes[onward_step.ways_plane + index];
        let point = read_exact_point(number);
        let pixel = points[number * POINT_WORDS + POINT_PIXEL];
        let ray = starts[number];
        let word = record_start(ray);
        put_vector(word, point.position);
        put_vector(word + RAY_DIRECTION, f64_vector_from_f32_bits(bitcast<vec3<u32>>(first.xyz)));
        put_number(word + RAY_T_MIN, F64_ZERO);
        put_number(word + RAY_T_MAX, SEND_INFINITE);
        put_number(word + RAY_ERROR, point.error);
        records[word + RECORD_OWN] = points[number * POINT_WORDS + POINT_TRIANGLE];
        records[word + RECORD_TAG] = pixel;
        paths[ray] = OnwardPath(second.xyz, first.w, pixel);
    }
}
