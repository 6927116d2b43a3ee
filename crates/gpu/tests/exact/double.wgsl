// Every operation on each pair of numbers.

import package::dispatch::{flat_group};
import package::exact::double::{two_sum, two_product, f64_divide, f64_less, f64_equal};

const RESULT_WORDS = 24u;

@group(0) @binding(0) var<storage, read> pairs: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

fn put(place: u32, value: F64) {
    results[place] = value.x;
    results[place + 1u] = value.y;
}

@compute @workgroup_size(64)
fn operations(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pair = flat_group(group, groups) * 64u + lane;
    if pair >= arrayLength(&pairs) {
        return;
    }
    let a = pairs[pair].xy;
    let b = pairs[pair].zw;
    let start = pair * RESULT_WORDS;
    let sum = two_sum(a, b);
    put(start, sum.high);
    put(start + 2u, sum.low);
    put(start + 4u, f64_subtract(a, b));
    let product = two_product(a, b);
    put(start + 6u, product.high);
    put(start + 8u, product.low);
    put(start + 10u, f64_divide(a, b));
    put(start + 12u, f64_from_f32_bits(a.x));
    put(start + 14u, f64_from_u32(a.x));
    put(start + 16u, f64_from_i32(i32(a.x)));
    put(start + 18u, f64_larger_magnitude(a, b));
    results[start + 20u] = f64_to_f32_bits(a);
    results[start + 21u] = u32(f64_less(a, b)) | (u32(f64_equal(a, b)) << 1u) | (u32(f64_is_finite(a)) << 2u)
        | (u32(f64_is_nan(a)) << 3u) | (u32(f64_is_zero(a)) << 4u)
        | (u32(f64_magnitude_less(a, b)) << 5u) | (u32(f64_is_below_zero(a)) << 6u) | (u32(f64_is_above_zero(a)) << 7u);
    put(start + 22u, f64_abs(f64_negate(a)));
}
