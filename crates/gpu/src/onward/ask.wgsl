// Stage `ask`: writes a shadow query for each point, from the point to a light.

import package::dispatch::{Invocation, flat_index};
import package::rays::light::{ShadowLight};
import package::rays::question::{put_no_question, put_question};
import package::rays::records::{NO_TRIANGLE, RECORDS_COUNT, record_start};
import package::onward::points::{POINT_TRIANGLE, POINT_WORDS, read_exact_point};

@group(0) @binding(0) var<uniform> shadow_light: ShadowLight;
@group(0) @binding(1) var<storage, read> points: array<u32>;
@group(0) @binding(2) var<storage, read_write> records: array<u32>;

@compute @workgroup_size(64)
fn ask(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    let id = points[number * POINT_WORDS + POINT_TRIANGLE];
    if id == NO_TRIANGLE {
        put_no_question(record_start(number));
        return;
    }
    put_question(record_start(number), read_exact_point(number), id, number);
}
