// Stage `ask_around`: writes an ambient-occlusion query for each point, along the point's direction.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, f64_add, f64_from_f32_bits, f64_multiply, f64_to_f32_bits};
import package::rays::light::{ShadowLight};
import package::rays::question::{put_no_question, put_question_to};
import package::rays::records::{NO_TRIANGLE, RECORDS_COUNT, record_start};
import package::onward::points::{POINT_TRIANGLE, POINT_WORDS, read_exact_point};

@group(0) @binding(0) var<uniform> shadow_light: ShadowLight;
@group(0) @binding(1) var<storage, read> points: array<u32>;
@group(0) @binding(2) var<storage, read> directions: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> records: array<u32>;

@compute @workgroup_size(64)
fn ask_around(at: Invocation) {
    let number = flat_index(at, 64u);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    let id = points[number * POINT_WORDS + POINT_TRIANGLE];
    if id == NO_TRIANGLE {
        put_no_question(record_start(number));
        return;
    }
    let point = read_exact_point(number);
    let direction = bitcast<vec3<u32>>(directions[number].xyz);
    // The occlusion radius, stored in place of the light's position.
    let reach = f64_from_f32_bits(shadow_light.vector.x);
    let end = vec3<u32>(
        ahead(point.position.x, direction.x, reach),
        ahead(point.position.y, direction.y, reach),
        ahead(point.position.z, direction.z, reach),
    );
    put_question_to(record_start(number), point, id, number, end, 0u);
}

// The coordinate at distance `reach` along `direction`, as bits of a finite f32.
fn ahead(start: F64, direction: u32, reach: F64) -> u32 {
    let bits = f64_to_f32_bits(f64_add(start, f64_multiply(f64_from_f32_bits(direction), reach)));
    return (bits & 0x80000000u) | min(bits & 0x7fffffffu, 0x7f7fffffu);
}
