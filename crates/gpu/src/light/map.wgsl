// Stage `map`: finds each point's position on the light's faces, and counts the points of each bin of their axes.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{F64};
import package::exact::wide::{
    Wide, WideVector, wide_add, wide_dot, wide_from_f64, wide_is_above_zero, wide_is_zero, wide_largest_magnitude,
    wide_magnitude_less, wide_multiply, wide_negate, wide_reciprocal, wide_to_f32_bits, wide_vector_subtract,
};
import package::grid::fixed::{fits_fixed, fixed};
import package::grid::header::{HEADER_FACES};
import package::grid::projection::{wide_projection_term, wide_projection_vector};
import package::grid::set_up::{INFINITE};
import package::grid::space::{Space};
import package::light::cells::{spread_base};
import package::light::depths::{note_key, write_keys};
import package::light::light::{Light};
import package::light::points::{POINT_ERROR, POINT_NONE};
import package::light::undecided::{compare_with_all};

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> spaces: array<Space>;
@group(0) @binding(2) var<storage, read_write> header: array<atomic<u32>>;
// Bits of slots with points; for a spot, those in its cone.
@group(0) @binding(3) var<storage, read> lit: array<u32>;
@group(0) @binding(4) var<storage, read> points: array<u32>;
// Fixed-point x and y, key and face of each slot.
@group(0) @binding(5) var<storage, read_write> mapped: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> spread: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> undecided: array<atomic<u32>>;

@compute @workgroup_size(64)
fn map(at: Invocation) {
    let slot = flat_index(at, 64u);
    if slot < light.slots {
        var face = POINT_NONE;
        if ((lit[light.mask + slot / 32u] >> (slot & 31u)) & 1u) == 1u {
            face = map_point(slot);
        }
        if face == POINT_NONE {
            mapped[slot] = vec4<u32>(0u, 0u, 0u, POINT_NONE);
        }
    }
    workgroupBarrier();
    write_keys(at.lane);
}

fn word_pair(word: u32) -> Wide {
    return wide_from_f64(F64(points[word], points[word + 1u]));
}

// Maps a point and returns its face. None for a point at the light, which nothing shadows, and for one whose position
// isn't certain, which is compared with all triangles.
fn map_point(slot: u32) -> u32 {
    let point = WideVector(word_pair(6u * slot), word_pair(6u * slot + 2u), word_pair(6u * slot + 4u));
    let offset = wide_vector_subtract(point, wide_projection_vector(0u, 0u));
    if wide_is_zero(wide_largest_magnitude(offset)) && light.is_directional == 0u {
        return POINT_NONE;
    }
    var face = 0u;
    if atomicLoad(&header[HEADER_FACES]) == 6u {
        face = cube_face_of(offset);
    }
    let raster = spaces[face].raster;
    var x = wide_dot(wide_projection_vector(face, 3u), offset);
    var y = wide_dot(wide_projection_vector(face, 6u), offset);
    let depth = wide_dot(wide_projection_vector(face, 9u), offset);
    var key = wide_to_f32_bits(wide_negate(depth));
    // In units: below the error that `choose` expects if this is below 4.
    let reach = light.reach + bitcast<f32>(wide_to_f32_bits(wide_largest_magnitude(point)));
    var error = 4.0 * POINT_ERROR * reach * raster.row_reach;
    if light.is_directional == 1u {
        x = wide_add(x, wide_projection_term(face, 12u));
        y = wide_add(y, wide_projection_term(face, 13u));
    } else {
        let inverse = wide_reciprocal(depth);
        x = wide_multiply(x, inverse);
        y = wide_multiply(y, inverse);
        key = wide_to_f32_bits(inverse);
        error = select(INFINITE, error * bitcast<f32>(key), wide_is_above_zero(depth));
    }
    let fixed_point = vec2<i32>(fixed(x), fixed(y));
    let column_and_row = fixed_point >> vec2<u32>(raster.fraction_bits);
    let is_inside = fits_fixed(x) && fits_fixed(y) && all(column_and_row >= vec2<i32>(0))
        && column_and_row.x < raster.columns && column_and_row.y < raster.rows;
    if !is_inside || !(error < 4.0) || (key & 0x7f800000u) == 0x7f800000u {
        compare_with_all(slot);
        return POINT_NONE;
    }
    mapped[slot] = vec4<u32>(bitcast<vec2<u32>>(fixed_point), key, face);
    note_key(key);
    let bins = vec2<u32>(column_and_row);
    atomicAdd(&spread[spread_base(face, 0u) + bins.x], 1u);
    atomicAdd(&spread[spread_base(face, 1u) + bins.y], 1u);
    return face;
}

fn cube_face_of(offset: WideVector) -> u32 {
    var axis = 0u;
    var largest = offset.x;
    if wide_magnitude_less(largest, offset.y) {
        axis = 1u;
        largest = offset.y;
    }
    if wide_magnitude_less(largest, offset.z) {
        axis = 2u;
        largest = offset.z;
    }
    return 2u * axis + (largest.sign >> 31u);
}
