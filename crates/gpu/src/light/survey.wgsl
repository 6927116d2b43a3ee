// Stage `survey`: where the points are that pixels show, once for all lights.
//
// Points are wrong by at most 2⁻⁴⁶ of their distance from the ray's origin.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, F64_ZERO, f64_add, f64_divide, f64_multiply, f64_to_f32_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_edges, exact_from_corners, exact_t};
import package::exact::vector::{
    F64Vector, f64_cross, f64_dot, f64_largest_magnitude, f64_vector_add, f64_vector_scale, f64_vector_subtract,
};
import package::grid::space::{ordered_bits};
import package::light::points::{BOUNDS_LOW, POINT_NONE};
import package::point_view::{PointView, ray_of_slot};
import package::tile_order::{pixel_of_slot};

@group(0) @binding(0) var<uniform> point_view: PointView;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read> seen: array<u32>;
// Six words a slot: x, y and z as F64.
@group(0) @binding(4) var<storage, read_write> points: array<u32>;
// A bit for each slot that shows something.
@group(0) @binding(5) var<storage, read_write> point_bits: array<u32>;
@group(0) @binding(6) var<storage, read_write> bounds: array<atomic<u32>>;

var<workgroup> bits_of_group: array<atomic<u32>, 2>;
// Complements of the lowest, then the highest coordinates, in order.
var<workgroup> bounds_of_group: array<atomic<u32>, 6>;

@compute @workgroup_size(64)
fn survey(at: Invocation) {
    let slot = flat_index(at, 64u);
    var id = POINT_NONE;
    let size = vec2<u32>(point_view.view.width, point_view.rows);
    if slot < point_view.slots && all(pixel_of_slot(slot, size.x) < size) {
        id = seen[slot];
    }
    if id != POINT_NONE {
        let point = point_on(id, slot);
        atomicOr(&bits_of_group[at.lane / 32u], 1u << (at.lane & 31u));
        store(6u * slot, point.x, 0u);
        store(6u * slot + 2u, point.y, 1u);
        store(6u * slot + 4u, point.z, 2u);
    }
    workgroupBarrier();
    if at.lane < 2u && slot < point_view.slots {
        point_bits[(slot - at.lane) / 32u + at.lane] = atomicLoad(&bits_of_group[at.lane]);
    }
    if at.lane < 6u {
        atomicMax(&bounds[BOUNDS_LOW + at.lane], atomicLoad(&bounds_of_group[at.lane]));
    }
}

fn store(word: u32, coordinate: F64, axis: u32) {
    points[word] = coordinate.x;
    points[word + 1u] = coordinate.y;
    let key = ordered_bits(bitcast<f32>(f64_to_f32_bits(coordinate)));
    atomicMax(&bounds_of_group[axis], ~key);
    atomicMax(&bounds_of_group[3u + axis], key);
}

// Where the pixel's ray meets its triangle.
fn point_on(id: u32, slot: u32) -> F64Vector {
    let ray = ray_of_slot(slot);
    let bits = corner_bits(id);
    let exact = exact_from_corners(bits);
    let ab = f64_vector_subtract(exact.b, exact.a);
    let ac = f64_vector_subtract(exact.c, exact.a);
    let normal = f64_cross(ab, ac);
    let slope = f64_dot(normal, ray.direction);
    // What cancels in the normal and the slope, in powers of two.
    let magnitude = f64_multiply(
        f64_multiply(f64_largest_magnitude(ab), f64_largest_magnitude(ac)), f64_largest_magnitude(ray.direction));
    // A slope above 2⁻¹² of that is wrong by 2⁻³⁸ of itself at most, and so is t. A second step from there has that
    // error of the rest, which leaves some 2⁻⁵⁰ of t where corners aren't farther than it.
    if (slope.y & 0x7fffffffu) + 0x00c00000u > magnitude.y {
        var t = F64_ZERO;
        var point = ray.origin;
        for (var step = 0u; step < 2u; step++) {
            t = f64_add(t, f64_divide(f64_dot(normal, f64_vector_subtract(exact.a, point)), slope));
            point = f64_vector_add(ray.origin, f64_vector_scale(ray.direction, t));
        }
        return point;
    }
    var terms: ExpansionTerms;
    let edges = exact_edges(&terms, ray, bits);
    return f64_vector_add(ray.origin, f64_vector_scale(ray.direction, exact_t(&terms, ray, edges)));
}
