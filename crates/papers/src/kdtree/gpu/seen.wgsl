// Stage `seen`: writes the triangle that each slot's ray has hit, and whether any ray has hit one.

import package::dispatch::{Invocation, flat_index};
import package::rays::records::{HIT_WORDS, NO_TRIANGLE, RECORDS_COUNT, RECORD_LANES};

@group(0) @binding(0) var<storage, read> records: array<u32>;
@group(0) @binding(1) var<storage, read> hits: array<u32>;
@group(0) @binding(2) var<storage, read_write> seen: array<u32>;
@group(0) @binding(3) var<storage, read_write> sees_any: array<atomic<u32>>;

@compute @workgroup_size(64)
fn see(at: Invocation) {
    let slot = flat_index(at, RECORD_LANES);
    if slot >= records[RECORDS_COUNT] {
        return;
    }
    let id = hits[slot * HIT_WORDS];
    seen[slot] = id;
    if id != NO_TRIANGLE {
        atomicOr(&sees_any[0], 1u);
    }
}
