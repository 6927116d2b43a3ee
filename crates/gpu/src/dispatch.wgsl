// Work in rows of workgroups: a dispatch has at most 65,535 of them on an axis.

const MOST_GROUPS: u32 = 65535u;

// What every entry point gets.
struct Invocation {
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    // Which one of its workgroup.
    @builtin(local_invocation_index) lane: u32,
}

// Which workgroup of its layer this is.
fn flat_group(at: Invocation) -> u32 {
    return at.group.y * at.groups.x + at.group.x;
}

// Which invocation of its layer this is, in workgroups of `width`.
fn flat_index(at: Invocation, width: u32) -> u32 {
    return flat_group(at) * width + at.lane;
}

// The size of an indirect dispatch of at least `count` workgroups.
fn groups_of(count: u32) -> vec3<u32> {
    let rows = (count + MOST_GROUPS - 1u) / MOST_GROUPS;
    return vec3<u32>((count + max(rows, 1u) - 1u) / max(rows, 1u), rows, 1u);
}
