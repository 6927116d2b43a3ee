// Stage `lit`: writes a bit for each slot that a light reaches.

import package::dispatch::{Invocation, flat_index};
import package::rays::light::{ShadowLight};
import package::rays::records::{NO_TRIANGLE, RECORDS_COUNT, RECORD_LANES, RECORD_TAG, record_start};

@group(0) @binding(0) var<uniform> shadow_light: ShadowLight;
@group(0) @binding(1) var<storage, read> records: array<u32>;
@group(0) @binding(2) var<storage, read> traced: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> lit_words: array<u32>;

var<workgroup> lit_bits: array<atomic<u32>, 2>;

@compute @workgroup_size(64)
fn lit(at: Invocation) {
    let slot = flat_index(at, RECORD_LANES);
    let is_slot = slot < records[RECORDS_COUNT];
    if is_slot && records[record_start(slot) + RECORD_TAG] != NO_TRIANGLE
        && (shadow_light.casts_shadow == 0u || traced[slot].x == 0u) {
        atomicOr(&lit_bits[at.lane / 32u], 1u << (at.lane & 31u));
    }
    workgroupBarrier();
    if is_slot && at.lane < 2u {
        lit_words[shadow_light.mask + (slot - at.lane) / 32u + at.lane] = atomicLoad(&lit_bits[at.lane]);
    }
}
