// Stage `fit`: decides whether there was room for all undecided hits. Later stages are dispatched only then.

import package::dispatch::{groups_of};

struct KdFit {
    // Room for hits, the same for each use.
    room: u32,
    uses: u32,
    // The workgroups of the next dispatch.
    groups: u32,
}

@group(0) @binding(0) var<uniform> kd_fit: KdFit;
// A header of undecided hits for each use; its first word is their number.
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
