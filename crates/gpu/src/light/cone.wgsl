// Stage `cone`: clears the bits of points outside of a spot's cone. They aren't lit, and aren't points of its grid.
// Each invocation has a slot.

import package::dispatch::{Invocation, flat_index};
import package::exact::cone::{exact_is_in_cone};
import package::light::light::{Light};
import package::light::seen_point::{seen_point};
import package::point_view::{PointView};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> point_view: PointView;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
@group(0) @binding(4) var<storage, read> seen: array<u32>;
@group(0) @binding(5) var<storage, read_write> lit: array<atomic<u32>>;

@compute @workgroup_size(64)
fn cone(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot >= light.slots {
        return;
    }
    let mask = light.mask + slot / 32u;
    let bit = 1u << (slot & 31u);
    if (atomicLoad(&lit[mask]) & bit) == 0u {
        return;
    }
    let point = seen_point(slot, seen[slot]);
    let spot = bitcast<vec3<u32>>(light.vector);
    if !exact_is_in_cone(point.position, spot, bitcast<vec3<u32>>(light.axis), light.squared_cosine) {
        atomicAnd(&lit[mask], ~bit);
    }
}
