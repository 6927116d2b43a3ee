// Stage `project`: maps each vertex to pixel space, once for every face.

import package::dispatch::{Invocation, flat_index};
import package::exact::wide::{
    Wide, wide_add, wide_dot, wide_is_above_zero, wide_largest_magnitude, wide_magnitude_less, wide_multiply, wide_negate,
    wide_reciprocal, wide_scaled, wide_to_f32_bits, wide_vector_from_f32_bits, wide_vector_subtract,
};
import package::grid::fixed::{fits_fixed, fixed};
import package::grid::header::{HEADER_KEYS};
import package::grid::projection::{wide_projection_term, wide_projection_vector};
import package::grid::space::{Raster, Space, VERTEX_HOMOGENEOUS, VERTEX_NOWHERE, VERTEX_REGULAR, ordered_bits};
import package::light::sphere::vertex::{angled_vertex};

// Whether this is for a light that sees by angles, and has two records a vertex.
override HAS_ANGLES: bool = false;

struct ProjectSize {
    vertices: u32,
}

@group(0) @binding(0) var<uniform> project_size: ProjectSize;
@group(0) @binding(1) var<storage, read> spaces: array<Space>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;
@group(0) @binding(3) var<storage, read_write> vertices: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> header: array<atomic<u32>>;

var<workgroup> nearest_of_group: atomic<u32>;
var<workgroup> farthest_of_group: atomic<u32>;

@compute @workgroup_size(256)
fn project(at: Invocation) {
    // Each layer of workgroups has a face.
    let face = at.group.z;
    let id = flat_index(at, 256u);
    if HAS_ANGLES && id < project_size.vertices {
        let first = 3u * id;
        let vertex = angled_vertex(vec3<u32>(positions[first], positions[first + 1u], positions[first + 2u]));
        vertices[2u * id] = vertex.of_world;
        vertices[2u * id + 1u] = vertex.of_light;
    } else if id < project_size.vertices {
        let vertex = project_vertex(face, id);
        vertices[face * project_size.vertices + id] = vertex;
        let raster = spaces[face].raster;
        let pixel = bitcast<vec2<i32>>(vertex.xy) >> vec2<u32>(raster.fraction_bits);
        let inside = all(pixel >= vec2<i32>(0)) && pixel.x < raster.columns && pixel.y < raster.rows;
        if vertex.w == VERTEX_REGULAR && inside {
            let key = ordered_bits(bitcast<f32>(vertex.z));
            atomicMax(&nearest_of_group, key);
            atomicMax(&farthest_of_group, ~key);
        }
    }
    workgroupBarrier();
    if at.lane == 0u && !HAS_ANGLES {
        atomicMax(&header[HEADER_KEYS + 2u * face], atomicLoad(&nearest_of_group));
        atomicMax(&header[HEADER_KEYS + 2u * face + 1u], atomicLoad(&farthest_of_group));
    }
}

// Coordinates relative to the origin are exact to 2⁻⁵³, their product with a row to 2⁻⁵⁰ of its largest term.
// `depth_bits` is chosen so that this error is below a unit after the division.
fn project_vertex(face: u32, id: u32) -> vec4<u32> {
    let raster = spaces[face].raster;
    let bits = vec3<u32>(positions[3u * id], positions[3u * id + 1u], positions[3u * id + 2u]);
    if any((bits & vec3<u32>(0x7f800000u)) == vec3<u32>(0x7f800000u)) {
        return vec4<u32>(0u, 0u, 0u, VERTEX_NOWHERE);
    }
    let offset = wide_vector_subtract(wide_vector_from_f32_bits(bits), wide_projection_vector(face, 0u));
    let x = wide_dot(wide_projection_vector(face, 3u), offset);
    let y = wide_dot(wide_projection_vector(face, 6u), offset);
    let depth = wide_dot(wide_projection_vector(face, 9u), offset);
    if raster.is_orthographic == 1u {
        let x_added = wide_add(x, wide_projection_term(face, 12u));
        let y_added = wide_add(y, wide_projection_term(face, 13u));
        let key = wide_to_f32_bits(wide_negate(depth));
        if fits_fixed(x_added) && fits_fixed(y_added) {
            return vec4<u32>(bitcast<u32>(fixed(x_added)), bitcast<u32>(fixed(y_added)), key, VERTEX_REGULAR);
        }
        return vec4<u32>(pixels(x_added, raster), pixels(y_added, raster), key, VERTEX_HOMOGENEOUS);
    }
    let reach = wide_scaled(depth, i32(raster.depth_bits));
    if wide_is_above_zero(depth) && wide_magnitude_less(wide_largest_magnitude(offset), reach) {
        let inverse = wide_reciprocal(depth);
        let x_divided = wide_multiply(x, inverse);
        let y_divided = wide_multiply(y, inverse);
        let key = wide_to_f32_bits(inverse);
        let exponent = (key >> 23u) & 0xffu;
        // Keys near the ends of f32's range use the homogeneous form, which the predicate settles.
        if fits_fixed(x_divided) && fits_fixed(y_divided) && exponent > 27u && exponent < 227u {
            return vec4<u32>(bitcast<u32>(fixed(x_divided)), bitcast<u32>(fixed(y_divided)), key, VERTEX_REGULAR);
        }
    }
    return vec4<u32>(pixels(x, raster), pixels(y, raster), wide_to_f32_bits(depth), VERTEX_HOMOGENEOUS);
}

// In pixels: in large worlds, units are beyond the range of f32 where pixels aren't.
fn pixels(value: Wide, raster: Raster) -> u32 {
    return wide_to_f32_bits(wide_scaled(value, -i32(raster.fraction_bits)));
}
