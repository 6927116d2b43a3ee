// Prefix of each of these tests' kernels: cases of CASE_WORDS words, and their answers.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64};

@group(0) @binding(0) var<storage, read> inputs: array<u32>;
@group(0) @binding(1) var<storage, read_write> outputs: array<u32>;

// Index of an invocation's case; there may be fewer cases.
fn case_number_of(at: Invocation) -> u32 {
    return flat_index(at, 64u);
}

fn case_pair(word: u32) -> vec2<u32> {
    return vec2(inputs[word], inputs[word + 1u]);
}

fn case_triple(word: u32) -> vec3<u32> {
    return vec3(inputs[word], inputs[word + 1u], inputs[word + 2u]);
}

fn answer_number(word: u32, number: F64) {
    outputs[word] = number.x;
    outputs[word + 1u] = number.y;
}
