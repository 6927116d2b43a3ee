// Stage `cone`: what is outside of a spot's cone isn't lit, whatever is in between, and is no point of its grid. An
// invocation has a slot.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{f64_is_above_zero, f64_less, f64_multiply};
import package::exact::vector::{f64_dot, f64_vector_from_f32_bits, f64_vector_subtract};
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
    let v = f64_vector_subtract(point.position, f64_vector_from_f32_bits(bitcast<vec3<u32>>(light.vector)));
    // In the order of the Rust crate's `Cone::contains`.
    let along = f64_dot(f64_vector_from_f32_bits(bitcast<vec3<u32>>(light.axis)), v);
    let least = f64_multiply(light.squared_cosine, f64_dot(v, v));
    if !f64_is_above_zero(along) || f64_less(f64_multiply(along, along), least) {
        atomicAnd(&lit[mask], ~bit);
    }
}
