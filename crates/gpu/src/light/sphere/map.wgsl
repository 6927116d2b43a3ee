// Stage `map` of a light that sees by angles: finds the angles of each point, and the range of all of them; then, in
// `bin`, counts the points of each bin of the angles' axes.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64, f64_is_zero};
import package::exact::vector::{F64Vector, f64_largest_magnitude};
import package::grid::header::{HEADER_ANGLES};
import package::grid::space::{Space};
import package::light::cells::{BIN_FRACTION_BITS, spread_base};
import package::light::depths::{note_key, write_keys};
import package::light::light::{Light};
import package::light::points::{POINT_ERROR, POINT_NONE};
import package::light::sphere::angles::{along_axes, angle_of, f32_bits_of, scaled_offset};
import package::light::sphere::arcs::{bin_of, ordered_angle, seen_angles};
import package::light::sphere::largest::{largest_bits};
import package::light::sphere::turn::{HALF_TURN};
import package::light::undecided::{compare_with_all};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> spaces: array<Space>;
@group(0) @binding(2) var<storage, read_write> header: array<atomic<u32>>;
// Bits of slots with points; for a spot, those in its cone.
@group(0) @binding(3) var<storage, read> lit: array<u32>;
@group(0) @binding(4) var<storage, read> points: array<u32>;
// Of each slot: α and β, later their bins in fixed-point; key; face.
@group(0) @binding(5) var<storage, read_write> mapped: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> spread: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

// Same words as in the header.
var<workgroup> angles_of_group: array<atomic<u32>, 6>;

// A point has no angles if their error exceeds this, 2⁻¹⁸ of a turn, …
const LARGEST_ANGLE_ERROR: f32 = 1.5258789e-5;
// … if it is nearer to the light than 10⁻²⁰ or farther than 16, or if the error of coordinates exceeds 2⁻²⁰.
const NEAREST_BITS: u32 = 0x1e3ce508u;
const FARTHEST_BITS: u32 = 0x41800000u;
const LARGEST_ERROR_BITS: u32 = 0x35800000u;

@compute @workgroup_size(64)
fn map(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot < light.slots {
        var found = vec4<u32>(0u, 0u, 0u, POINT_NONE);
        if ((lit[light.mask + slot / 32u] >> (slot & 31u)) & 1u) == 1u {
            found = angles_and_key(slot);
        }
        mapped[slot] = found;
    }
    workgroupBarrier();
    write_keys(at.lane);
    if at.lane < 6u {
        atomicMax(&header[HEADER_ANGLES + at.lane], atomicLoad(&angles_of_group[at.lane]));
    }
}

// A point's angles and key. None for a point at the light, which nothing shadows, and for one with unknown angles,
// which is compared with all triangles.
fn angles_and_key(slot: u32) -> vec4<u32> {
    const NONE: vec4<u32> = vec4<u32>(0u, 0u, 0u, POINT_NONE);
    let word = 6u * slot;
    let offset = scaled_offset(F64Vector(
        F64(points[word], points[word + 1u]), F64(points[word + 2u], points[word + 3u]),
        F64(points[word + 4u], points[word + 5u])));
    if f64_is_zero(f64_largest_magnitude(offset)) {
        return NONE;
    }
    let largest = largest_bits(f32_bits_of(offset));
    let reach = bitcast<f32>(largest);
    let depth_error = spaces[0].raster.depth_error;
    let is_known = largest > NEAREST_BITS && largest < FARTHEST_BITS && bitcast<u32>(depth_error) < LARGEST_ERROR_BITS;
    let parts = along_axes(offset);
    // Along an axis of length one a coordinate's error grows by up to √3; F64 loses 2⁻⁴⁹ of the largest coordinate.
    let error = depth_error + 4.1 * POINT_ERROR * reach;
    let sums = vec2<f32>(abs(parts.x), abs(parts.y)) + abs(parts.z);
    // An angle moves by at most twice as much as its two parts, divided by their sum.
    let of_angles = 3.6 * error;
    if !is_known || !(of_angles < LARGEST_ANGLE_ERROR * min(sums.x, sums.y)) {
        compare_with_all(slot);
        return NONE;
    }
    let angles = vec2<i32>(angle_of(parts.x, parts.z), angle_of(parts.y, parts.z));
    for (var plane = 0u; plane < 2u; plane++) {
        let units = u32(1.01 * of_angles / sums[plane] * f32(HALF_TURN / 2)) + 1u;
        atomicMax(&angles_of_group[3u * plane], ~ordered_angle(angles[plane]));
        atomicMax(&angles_of_group[3u * plane + 1u], ordered_angle(angles[plane]));
        atomicMax(&angles_of_group[3u * plane + 2u], units);
    }
    // Farther points have lower keys.
    let key = bitcast<u32>(-(reach + depth_error));
    note_key(key);
    return vec4<u32>(bitcast<vec2<u32>>(angles), key, 0u);
}

@compute @workgroup_size(64)
fn bin(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot >= light.slots || mapped[slot].w == POINT_NONE {
        return;
    }
    for (var plane = 0u; plane < 2u; plane++) {
        let bin = bin_of(i32(mapped[slot][plane]), seen_angles(plane));
        mapped[slot][plane] = bin << BIN_FRACTION_BITS;
        atomicAdd(&spread[spread_base(0u, plane) + bin], 1u);
    }
}
