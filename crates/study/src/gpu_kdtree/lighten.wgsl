// Stage `lighten`: adds the light of unshadowed points to their pixels. A pixel has one path, and so one point.

import package::dispatch::{Invocation, flat_index};
import package::rays::records::{RECORDS_COUNT, RECORD_LANES, RECORD_TAG, SHADOW_COLOR, record_start};

@group(0) @binding(0) var<storage, read> records: array<u32>;
@group(0) @binding(1) var<storage, read> traced: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> film: array<vec4<f32>>;

@compute @workgroup_size(64)
fn lighten(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    if number >= records[RECORDS_COUNT] || traced[number].x != 0u {
        return;
    }
    let word = record_start(number);
    let color = vec3(records[word + SHADOW_COLOR], records[word + SHADOW_COLOR + 1u], records[word + SHADOW_COLOR + 2u]);
    film[records[word + RECORD_TAG]] += vec4(bitcast<vec3<f32>>(color), 0.0);
}
