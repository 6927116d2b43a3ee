// Every operation on wide numbers, on each pair of numbers.

import package::exact::wide::{
    WIDE_ONE, Wide, WideVector, wide_add, wide_cross, wide_dot, wide_from_f32_bits, wide_from_f64, wide_magnitude_less, wide_multiply, wide_reciprocal, wide_subtract,
    wide_to_f32_bits, wide_to_f64,
};
import package::grid::fixed::{fits_fixed, fixed};

const CASE_WORDS = 4u;
const ANSWER_WORDS = 34u;

fn answer_wide(word: u32, number: Wide) {
    outputs[word] = number.bits.x;
    outputs[word + 1u] = number.bits.y;
    outputs[word + 2u] = bitcast<u32>(number.exponent);
    outputs[word + 3u] = number.sign;
}

@compute @workgroup_size(64)
fn operations(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let a = wide_from_f64(case_pair(start));
    let b = wide_from_f64(case_pair(start + 2u));
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    answer_wide(answer, wide_add(a, b));
    answer_wide(answer + 4u, wide_subtract(a, b));
    answer_wide(answer + 8u, wide_multiply(a, b));
    answer_wide(answer + 12u, wide_reciprocal(a));
    answer_wide(answer + 16u, wide_from_f32_bits(case_pair(start).x & 0xff7fffffu));
    answer_number(answer + 20u, wide_to_f64(a));
    outputs[answer + 22u] = wide_to_f32_bits(a);
    outputs[answer + 23u] = u32(fits_fixed(a));
    outputs[answer + 24u] = bitcast<u32>(fixed(a));
    outputs[answer + 25u] = u32(wide_magnitude_less(a, b));
    let first = WideVector(a, b, WIDE_ONE);
    answer_wide(answer + 26u, wide_dot(first, WideVector(b, a, WIDE_ONE)));
    answer_wide(answer + 30u, wide_cross(first, WideVector(WIDE_ONE, a, b)).x);
}
