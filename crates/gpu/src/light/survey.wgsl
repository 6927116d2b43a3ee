// Stage `survey`: finds the points that pixels show, once for all lights.
//
// Points have an error of at most `POINT_ERROR` of their distance from the ray's origin, and the rounding of F64.

import package::dispatch::{Invocation, flat_index};
import package::exact::camera::{exact_across, exact_ray_beside};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, f64_add, f64_from_u32, f64_to_f32_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{ExactRay, exact_edges, exact_t};
import package::exact::vector::{F64Vector, f64_vector_add, f64_vector_from_f32_bits, f64_vector_scale};
import package::exact::wide::{
    WideVector, wide_cross, wide_dot, wide_from_f64, wide_is_zero, wide_largest_magnitude, wide_multiply, wide_reciprocal,
    wide_to_f64, wide_vector_along, wide_vector_from_f32_bits, wide_vector_subtract,
};
import package::grid::space::{ordered_bits};
import package::light::points::{BOUNDS_LOW, POINT_NONE};
import package::point_view::{PointView};
import package::tile_order::{BLOCK_SIDE, TILE_SIDE, pixel_of_slot};

@group(0) @binding(0) var<uniform> point_view: PointView;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read> seen: array<u32>;
// Six words a slot: x, y and z as F64.
@group(0) @binding(4) var<storage, read_write> points: array<u32>;
// A bit for each slot that shows a triangle.
@group(0) @binding(5) var<storage, read_write> point_bits: array<u32>;
@group(0) @binding(6) var<storage, read_write> bounds: array<atomic<u32>>;

// A workgroup has the pixels of a row of blocks across a whole tile.
const SURVEYED: u32 = TILE_SIDE * BLOCK_SIDE;

var<workgroup> bits_of_group: array<atomic<u32>, SURVEYED / 32u>;
// Offsets from the axis of its columns, then of its rows; and the camera's axis.
var<workgroup> across_of_group: array<F64Vector, TILE_SIDE + BLOCK_SIDE>;
var<workgroup> axis_of_group: ExactRay;
// Complements of the lowest, then the highest coordinates, as ordered bits.
var<workgroup> bounds_of_group: array<atomic<u32>, 6>;

@compute @workgroup_size(SURVEYED)
fn survey(at: Invocation) {
    let slot = flat_index(at, SURVEYED);
    let width = point_view.view.width;
    if at.lane < TILE_SIDE + BLOCK_SIDE {
        across_of_group[at.lane] = across_of(pixel_of_slot(slot - at.lane, width), at.lane);
    } else if at.lane == SURVEYED - 1u {
        axis_of_group = ExactRay(
            f64_vector_from_f32_bits(point_view.view.position), f64_vector_from_f32_bits(point_view.view.forward));
    }
    workgroupBarrier();
    var id = POINT_NONE;
    let pixel = pixel_of_slot(slot, width);
    if slot < point_view.slots && all(pixel < vec2<u32>(width, point_view.rows)) {
        id = seen[slot];
    }
    if id != POINT_NONE {
        let across = f64_vector_add(
            across_of_group[pixel.x % TILE_SIDE], across_of_group[TILE_SIDE + pixel.y % BLOCK_SIDE]);
        let point = point_on(id, exact_ray_beside(axis_of_group, across, point_view.view.is_orthographic != 0u));
        atomicOr(&bits_of_group[at.lane / 32u], 1u << (at.lane & 31u));
        store(6u * slot, point.x, 0u);
        store(6u * slot + 2u, point.y, 1u);
        store(6u * slot + 4u, point.z, 2u);
    }
    workgroupBarrier();
    if at.lane < SURVEYED / 32u && slot < point_view.slots {
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

// Offset from the camera's axis of a column, or of one of the rows after it in the list, counted from the pixel `first`.
fn across_of(first: vec2<u32>, index: u32) -> F64Vector {
    let is_row = index >= TILE_SIDE;
    let number = select(first.x + index, point_view.first_row + first.y + index - TILE_SIDE, is_row);
    let offset = select(point_view.x_offset, point_view.y_offset, is_row);
    return exact_across(point_view.view, f64_add(f64_from_u32(number), offset), is_row);
}

// The point where a ray meets its triangle.
fn point_on(id: u32, ray: ExactRay) -> F64Vector {
    let bits = corner_bits(id);
    let origin = wide_vector(ray.origin);
    let direction = wide_vector(ray.direction);
    let a = wide_vector_from_f32_bits(bits.a);
    let ab = wide_vector_subtract(wide_vector_from_f32_bits(bits.b), a);
    let ac = wide_vector_subtract(wide_vector_from_f32_bits(bits.c), a);
    let normal = wide_cross(ab, ac);
    let slope = wide_dot(normal, direction);
    let to_plane = wide_vector_subtract(a, origin);
    let t = wide_multiply(wide_dot(normal, to_plane), wide_reciprocal(slope));
    // The error of the slope is less than 2⁻⁵⁵ of the product of the largest sides and direction, that of its dividend
    // 2⁻⁵⁵ of the product with the largest offset. So the relative error of a point's distance is that times the ratio
    // of the first product to the slope, and the ratio of the second offset to the distance; both are rounded up to
    // powers of two.
    let of_direction = wide_largest_magnitude(direction).exponent;
    let lost = wide_largest_magnitude(ab).exponent + wide_largest_magnitude(ac).exponent + of_direction
        + (3 * 64 - 63) - slope.exponent;
    let farther = wide_largest_magnitude(to_plane).exponent + (64 - 2 * 63) - t.exponent - of_direction;
    if !wide_is_zero(slope) && lost + max(farther, 0) <= 12 {
        let point = wide_vector_along(origin, direction, t);
        return F64Vector(wide_to_f64(point.x), wide_to_f64(point.y), wide_to_f64(point.z));
    }
    var terms: ExpansionTerms;
    let edges = exact_edges(&terms, ray, bits);
    return f64_vector_add(ray.origin, f64_vector_scale(ray.direction, exact_t(&terms, ray, edges)));
}

fn wide_vector(a: F64Vector) -> WideVector {
    return WideVector(wide_from_f64(a.x), wide_from_f64(a.y), wide_from_f64(a.z));
}
