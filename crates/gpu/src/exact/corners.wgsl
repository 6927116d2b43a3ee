// The bits of a triangle's corners, from the buffers `triangles` and `positions` that a stage declares.

import package::exact::predicate::{CornerBits};
import stage::{positions, triangles};

fn position_bits(vertex: u32) -> vec3<u32> {
    return vec3<u32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

fn corner_bits(id: u32) -> CornerBits {
    let corners = triangles[id].xyz;
    return CornerBits(position_bits(corners.x), position_bits(corners.y), position_bits(corners.z));
}
