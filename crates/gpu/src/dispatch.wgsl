// Work in rows of workgroups: a dispatch has at most 65,535 of them on an axis.
//
// A row's width is fixed, so that shaders needn't ask how many workgroups there are: Direct3D 12 doesn't know that of indirect
// dispatches.

const GROUPS_OF_ROW: u32 = 1024u;

// What entry points get.
struct Invocation {
    @builtin(workgroup_id) group: vec3<u32>,
    // Which one of its workgroup.
    @builtin(local_invocation_index) lane: u32,
}

// Which workgroup of its layer this is.
fn flat_group(group: vec3<u32>) -> u32 {
    return group.y * GROUPS_OF_ROW + group.x;
}

// Which invocation of its layer this is, in workgroups of `width`.
fn flat_index(at: Invocation, width: u32) -> u32 {
    return flat_group(at.group) * width + at.lane;
}

// The size of a dispatch of at least `count` workgroups.
fn groups_of(count: u32) -> vec3<u32> {
    return vec3<u32>(min(count, GROUPS_OF_ROW), (count + GROUPS_OF_ROW - 1u) / GROUPS_OF_ROW, 1u);
}
