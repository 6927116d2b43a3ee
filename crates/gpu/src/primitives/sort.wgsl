// Stable counting sort of u32 keys, and of values that go with them: one pass of it for each four bits, from the lowest.
//
// A pass counts the digits of each page, turns the counts into starts (see `scan`; all pages of a digit behind each
// other), and moves each element to its digit's start. An invocation takes elements that stand behind each other, and
// counts of invocations are summed in the order of the elements: so elements of one digit stay in order.

import package::dispatch::{flat_group};

const SORT_WIDTH: u32 = 256u;
// Elements that an invocation takes one after the other.
const SORT_DEPTH: u32 = 8u;
const SORT_PAGE: u32 = SORT_WIDTH * SORT_DEPTH;
const SORT_DIGITS: u32 = 16u;
// Two counts share a word: a page's are below 2¹⁶.
const SORT_WORDS: u32 = SORT_DIGITS / 2u;

struct SortPass {
    // How many elements there are.
    count: u32,
    pages: u32,
    // Where the digit is in the keys.
    shift: u32,
}

override HAS_VALUES: bool = false;

@group(0) @binding(0) var<uniform> sort_pass: SortPass;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
@group(0) @binding(2) var<storage, read> values: array<u32>;
// For each digit how many each page has, then where they start.
@group(0) @binding(3) var<storage, read_write> digit_starts: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;

var<workgroup> lane_counts: array<array<u32, SORT_WIDTH>, SORT_WORDS>;

fn digit_of(key: u32) -> u32 {
    return (key >> sort_pass.shift) & (SORT_DIGITS - 1u);
}

// Counts the digits of each invocation's elements, then sums the counts of those up to it (Hillis and Steele).
fn count_digits(first: u32, lane: u32) {
    var own: array<u32, SORT_WORDS>;
    for (var place = first; place < min(first + SORT_DEPTH, sort_pass.count); place++) {
        let digit = digit_of(keys[place]);
        own[digit / 2u] += 1u << (digit % 2u * 16u);
    }
    for (var word = 0u; word < SORT_WORDS; word++) {
        lane_counts[word][lane] = own[word];
    }
    workgroupBarrier();
    for (var step = 1u; step < SORT_WIDTH; step *= 2u) {
        for (var word = 0u; word < SORT_WORDS; word++) {
            own[word] = lane_counts[word][lane];
            if lane >= step {
                own[word] += lane_counts[word][lane - step];
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < SORT_WORDS; word++) {
            lane_counts[word][lane] = own[word];
        }
        workgroupBarrier();
    }
}

// How many elements of a digit the invocations up to this one have.
fn lane_count(digit: u32, lane: u32) -> u32 {
    return (lane_counts[digit / 2u][lane] >> (digit % 2u * 16u)) & 0xffffu;
}

@compute @workgroup_size(256)
fn sort_count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let page = flat_group(group, groups);
    count_digits(page * SORT_PAGE + lane * SORT_DEPTH, lane);
    if page < sort_pass.pages && lane < SORT_DIGITS {
        digit_starts[lane * sort_pass.pages + page] = lane_count(lane, SORT_WIDTH - 1u);
    }
}

@compute @workgroup_size(256)
fn sort_move(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let page = flat_group(group, groups);
    let first = page * SORT_PAGE + lane * SORT_DEPTH;
    count_digits(first, lane);
    var moved: array<u32, SORT_DIGITS>;
    for (var place = first; place < min(first + SORT_DEPTH, sort_pass.count); place++) {
        let key = keys[place];
        let digit = digit_of(key);
        let before = select(0u, lane_count(digit, max(lane, 1u) - 1u), lane > 0u);
        let start = digit_starts[digit * sort_pass.pages + page] + before + moved[digit];
        moved[digit] += 1u;
        sorted_keys[start] = key;
        if HAS_VALUES {
            sorted_values[start] = values[place];
        }
    }
}
