// Stage `shown`: counts the pixels that show a triangle.

import package::dispatch::{Invocation, flat_index};
import package::tile_order::{pixel_of_slot};

struct ShownSize {
    size_pixels: vec2<u32>,
}

// Value of a slot without a triangle.
const SHOWN_NONE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> shown_size: ShownSize;
@group(0) @binding(1) var<storage, read> shown_seen: array<u32>;
@group(0) @binding(2) var<storage, read_write> shown_count: atomic<u32>;

var<workgroup> shown_of_group: atomic<u32>;

@compute @workgroup_size(64)
fn shown(at: Invocation) {
    let slot = flat_index(at, 64u);
    let pixel = pixel_of_slot(slot, shown_size.size_pixels.x);
    if all(pixel < shown_size.size_pixels) && shown_seen[slot] != SHOWN_NONE {
        atomicAdd(&shown_of_group, 1u);
    }
    workgroupBarrier();
    if at.lane == 0u {
        atomicAdd(&shown_count, atomicLoad(&shown_of_group));
    }
}
