// Stage `sort`: sorts points by cell. A prefix sum has turned counts into the ends of cells.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64};
import package::exact::vector::{F64Vector};
import package::grid::space::{Space};
import package::light::light::{Light};
import package::light::points::{POINT_NONE};
import package::light::sphere::angles::{f32_bits_of, scaled_offset};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> mapped: array<vec4<u32>>;
// Index of each cell's next point; in the end, the end of its points.
@group(0) @binding(2) var<storage, read_write> point_cells: array<atomic<u32>>;
// Fixed-point x and y, key and slot, or offset from the light and slot; then the points' own triangles, four to an element.
@group(0) @binding(3) var<storage, read_write> sorted: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> seen: array<u32>;
@group(0) @binding(5) var<storage, read> points: array<u32>;
@group(0) @binding(6) var<storage, read> spaces: array<Space>;

// Whether the light sees by angles.
override HAS_ANGLES: bool = false;

@compute @workgroup_size(256)
fn sort(at: Invocation) {
    let slot = flat_index(at, 256u);
    if slot >= light.slots {
        return;
    }
    let point = mapped[slot];
    if point.w != POINT_NONE {
        let number = atomicAdd(&point_cells[point.w], 1u);
        var position = point.xyz;
        if HAS_ANGLES {
            let word = 6u * slot;
            position = f32_bits_of(scaled_offset(F64Vector(
                F64(points[word], points[word + 1u]), F64(points[word + 2u], points[word + 3u]),
                F64(points[word + 4u], points[word + 5u]))));
        }
        sorted[number] = vec4<u32>(position, slot);
        sorted[light.slots + number / 4u][number & 3u] = seen[slot];
    }
}
