// Every operation on each pair of numbers.

import package::exact::double::{
    f64_abs, f64_divide, f64_equal, f64_from_f32_bits, f64_from_i32, f64_from_u32, f64_is_above_zero, f64_is_below_zero,
    f64_is_finite, f64_is_nan, f64_is_zero, f64_larger_magnitude, f64_less, f64_magnitude_less, f64_negate,
    f64_subtract, f64_to_f32_bits, two_product, two_sum,
};

const CASE_WORDS = 4u;
const ANSWER_WORDS = 24u;

@compute @workgroup_size(64)
fn operations(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let a = case_pair(start);
    let b = case_pair(start + 2u);
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    let sum = two_sum(a, b);
    answer_number(answer, sum.high);
    answer_number(answer + 2u, sum.low);
    answer_number(answer + 4u, f64_subtract(a, b));
    let product = two_product(a, b);
    answer_number(answer + 6u, product.high);
    answer_number(answer + 8u, product.low);
    answer_number(answer + 10u, f64_divide(a, b));
    answer_number(answer + 12u, f64_from_f32_bits(a.x));
    answer_number(answer + 14u, f64_from_u32(a.x));
    answer_number(answer + 16u, f64_from_i32(i32(a.x)));
    answer_number(answer + 18u, f64_larger_magnitude(a, b));
    outputs[answer + 20u] = f64_to_f32_bits(a);
    outputs[answer + 21u] = u32(f64_less(a, b)) | (u32(f64_equal(a, b)) << 1u) | (u32(f64_is_finite(a)) << 2u)
        | (u32(f64_is_nan(a)) << 3u) | (u32(f64_is_zero(a)) << 4u)
        | (u32(f64_magnitude_less(a, b)) << 5u) | (u32(f64_is_below_zero(a)) << 6u) | (u32(f64_is_above_zero(a)) << 7u);
    answer_number(answer + 22u, f64_abs(f64_negate(a)));
}
