// Stage `omit`: counts by reason the triangles that no ray can hit, and keeps the lowest ids of each.

import package::dispatch::{Invocation, flat_index};

struct OmitSize {
    triangles: u32,
    vertices: u32,
}

const OMIT_NOT_FINITE = 0u;
const OMIT_ZERO_AREA = 1u;
const OMIT_OUT_OF_RANGE = 2u;
const OMIT_NONE = 3u;
// Number of ids that are kept for each reason.
const OMIT_IDS = 8u;
// Words of a reason: the number of triangles, then the complements of their lowest ids, so zeros mean none.
const OMIT_WORDS = 1u + OMIT_IDS;

@group(0) @binding(0) var<uniform> omit_size: OmitSize;
@group(0) @binding(1) var<storage, read> positions: array<u32>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> omitted: array<atomic<u32>>;

@compute @workgroup_size(64)
fn omit(at: Invocation) {
    let id = flat_index(at, 64u);
    if id >= omit_size.triangles {
        return;
    }
    let reason = reason_to_omit(triangles[id].xyz);
    if reason != OMIT_NONE {
        let first = reason * OMIT_WORDS;
        atomicAdd(&omitted[first], 1u);
        note_lowest(first + 1u, ~id);
    }
}

fn reason_to_omit(vertices: vec3<u32>) -> u32 {
    if any(vertices >= vec3<u32>(omit_size.vertices)) {
        return OMIT_OUT_OF_RANGE;
    }
    let a = coordinates(vertices.x);
    let b = coordinates(vertices.y);
    let c = coordinates(vertices.z);
    if !(are_finite(a) && are_finite(b) && are_finite(c)) {
        return OMIT_NOT_FINITE;
    }
    return select(OMIT_NONE, OMIT_ZERO_AREA, all(a == b) || all(b == c) || all(c == a));
}

// The bits of a vertex's position, with +0 for −0.
fn coordinates(vertex: u32) -> vec3<u32> {
    let bits = vec3<u32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    return select(bits, vec3<u32>(0u), bits == vec3<u32>(0x80000000u));
}

fn are_finite(bits: vec3<u32>) -> bool {
    return all((bits & vec3<u32>(0x7f800000u)) != vec3<u32>(0x7f800000u));
}

// Each slot keeps the lower of two ids and hands on the other, so the lowest ids end up in order.
fn note_lowest(first: u32, complement: u32) {
    if atomicLoad(&omitted[first + OMIT_IDS - 1u]) > complement {
        return;
    }
    var handed_on = complement;
    for (var slot = 0u; slot < OMIT_IDS; slot++) {
        let kept = atomicMax(&omitted[first + slot], handed_on);
        handed_on = min(kept, handed_on);
        if handed_on == 0u {
            return;
        }
    }
}
