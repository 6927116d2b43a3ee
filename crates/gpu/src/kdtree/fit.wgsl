// Stage `fit`: whether there was room for all undecided hits. What follows is dispatched only then.

import package::dispatch::{groups_of};

struct KdFit {
    // How many hits there is room for, each time.
    room: u32,
    uses: u32,
    // The workgroups that follow.
    groups: u32,
}

@group(0) @binding(0) var<uniform> kd_fit: KdFit;
// A header of undecided hits for each use, which begins with how many there are.
@group(0) @binding(1) var<storage, read> needs: array<u32>;
@group(0) @binding(2) var<storage, read_write> sizes: array<u32>;

const NEEDS_WORDS: u32 = 16u;

@compute @workgroup_size(1)
fn fit() {
    var all_fit = true;
    for (var index = 0u; index < kd_fit.uses; index++) {
        all_fit = all_fit && needs[index * NEEDS_WORDS] <= kd_fit.room;
    }
    let groups = select(vec3<u32>(0u), groups_of(kd_fit.groups), all_fit);
    sizes[0] = groups.x;
    sizes[1] = groups.y;
    sizes[2] = groups.z;
}
