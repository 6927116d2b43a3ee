// Dispatches in rows of workgroups: a dispatch has at most 65,535 of them on an axis.
//
// Rows have a fixed width, so shaders needn't read the number of workgroups, which Direct3D 12 doesn't know for
// indirect dispatches.

const GROUPS_OF_ROW: u32 = 1024u;

// Built-in values of an entry point.
struct Invocation {
    @builtin(workgroup_id) group: vec3<u32>,
    // Index of the invocation in its workgroup.
    @builtin(local_invocation_index) lane: u32,
}

// Index of a workgroup in its layer.
fn flat_group(group: vec3<u32>) -> u32 {
    return group.y * GROUPS_OF_ROW + group.x;
}

// Index of an invocation in its layer, for workgroups of `width` invocations.
fn flat_index(at: Invocation, width: u32) -> u32 {
    return flat_group(at.group) * width + at.lane;
}

// The size of a dispatch of at least `count` workgroups.
fn groups_of(count: u32) -> vec3<u32> {
    return vec3<u32>(min(count, GROUPS_OF_ROW), (count + GROUPS_OF_ROW - 1u) / GROUPS_OF_ROW, 1u);
}
