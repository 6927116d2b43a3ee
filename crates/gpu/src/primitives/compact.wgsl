// Stream compaction: keeps the elements whose flags are set, in order.

import package::dispatch::{flat_group, groups_of};

struct CompactSize {
    // How many elements there are.
    count: u32,
    // The word of `scan`'s totals with their sum.
    total_word: u32,
    // How many elements a workgroup takes of the dispatch that is made ready.
    per_group: u32,
}

@group(0) @binding(0) var<uniform> compact_size: CompactSize;
@group(0) @binding(1) var<storage, read> flags: array<u32>;
@group(0) @binding(2) var<storage, read> elements: array<u32>;
// 1 for each flag that is set; then how many are set before it.
@group(0) @binding(3) var<storage, read_write> starts: array<u32>;
@group(0) @binding(4) var<storage, read> totals: array<u32>;
@group(0) @binding(5) var<storage, read_write> kept: array<u32>;
// How many are kept, and the groups that take them.
@group(0) @binding(6) var<storage, read_write> kept_count: array<u32>;

@compute @workgroup_size(256)
fn compact_mark(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = flat_group(group, groups) * 256u + lane;
    if place < compact_size.count {
        starts[place] = u32(flags[place] != 0u);
    }
}

@compute @workgroup_size(256)
fn compact_keep(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = flat_group(group, groups) * 256u + lane;
    if place < compact_size.count && flags[place] != 0u {
        kept[starts[place]] = elements[place];
    }
}

@compute @workgroup_size(1)
fn compact_count() {
    let count = totals[compact_size.total_word];
    let groups = groups_of(count / compact_size.per_group + u32(count % compact_size.per_group > 0u));
    kept_count[0] = count;
    kept_count[1] = groups.x;
    kept_count[2] = groups.y;
    kept_count[3] = groups.z;
}
