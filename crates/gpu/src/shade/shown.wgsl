// How many pixels show a triangle.

import package::dispatch::{flat_group};
import package::tile_order::{pixel_of_place};

struct ShownSize {
    size_pixels: vec2<u32>,
}

// What a place without a triangle holds.
const SHOWN_NONE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> shown_size: ShownSize;
@group(0) @binding(1) var<storage, read> shown_seen: array<u32>;
@group(0) @binding(2) var<storage, read_write> shown_count: atomic<u32>;

var<workgroup> shown_of_group: atomic<u32>;

@compute @workgroup_size(64)
fn shown(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = flat_group(group, groups) * 64u + lane;
    let pixel = pixel_of_place(place, shown_size.size_pixels.x);
    if all(pixel < shown_size.size_pixels) && shown_seen[place] != SHOWN_NONE {
        atomicAdd(&shown_of_group, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&shown_count, atomicLoad(&shown_of_group));
    }
}
