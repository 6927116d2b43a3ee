// Work in rows of workgroups: a dispatch has at most 65,535 of them on an axis.

const MOST_GROUPS: u32 = 65535u;

// Which workgroup of the whole dispatch this is.
fn flat_group(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// The size of an indirect dispatch of at least `count` workgroups.
fn groups_of(count: u32) -> vec3<u32> {
    let rows = (count + MOST_GROUPS - 1u) / MOST_GROUPS;
    return vec3<u32>((count + max(rows, 1u) - 1u) / max(rows, 1u), rows, 1u);
}
