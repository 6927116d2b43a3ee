// Stage `sort`: points by cell. The ends of cells come from counts by a prefix sum.

import package::dispatch::{Invocation, flat_index};
import package::light::light::{Light};
import package::light::points::{POINT_NONE};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> mapped: array<vec4<u32>>;
// Where each cell's next point goes; in the end, where its points end.
@group(0) @binding(2) var<storage, read_write> point_cells: array<atomic<u32>>;
// Fixed-point x and y, key and slot; then, four to an element, the triangles that points are on.
@group(0) @binding(3) var<storage, read_write> sorted: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> seen: array<u32>;

@compute @workgroup_size(256)
fn sort(at: Invocation) {
    let slot = flat_index(at, 256u);
    if slot >= light.slots {
        return;
    }
    let point = mapped[slot];
    if point.w != POINT_NONE {
        let number = atomicAdd(&point_cells[point.w], 1u);
        sorted[number] = vec4<u32>(point.xyz, slot);
        sorted[light.slots + number / 4u][number & 3u] = seen[slot];
    }
}
