// Stage `project`: each vertex into pixel space, once for every face.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{
    F64, f64_add, f64_divide, f64_from_f32_bits, f64_multiply, f64_negate, f64_subtract, f64_to_f32_bits,
};
import package::grid::fixed::{fits_fixed, fixed};
import package::grid::header::{HEADER_KEYS};
import package::grid::projection::{projection_term};
import package::grid::space::{Space, VERTEX_HOMOGENEOUS, VERTEX_NOWHERE, VERTEX_REGULAR, ordered_bits};
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
    // Rows of workgroups are faces where there are several.
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

// Coordinates in relation to the origin are exact to 2⁻⁵³, a row's product with them to 2⁻⁵⁰ of its largest term.
// `depth_bits` is such that this is below a unit after the division.
fn project_vertex(face: u32, id: u32) -> vec4<u32> {
    let raster = spaces[face].raster;
    var offset: array<F64, 3>;
    var largest = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        let bits = positions[3u * id + axis];
        if (bits & 0x7f800000u) == 0x7f800000u {
            return vec4<u32>(0u, 0u, 0u, VERTEX_NOWHERE);
        }
        offset[axis] = f64_subtract(f64_from_f32_bits(bits), projection_term(face, axis));
        largest = max(largest, offset[axis].y & 0x7fffffffu);
    }
    var projected: array<F64, 3>;
    for (var row = 0u; row < 3u; row++) {
        var sum = F64(0u, 0u);
        for (var axis = 0u; axis < 3u; axis++) {
            sum = f64_add(sum, f64_multiply(projection_term(face, 3u + 3u * row + axis), offset[axis]));
        }
        projected[row] = sum;
    }
    // In F64: units of large worlds are beyond the range of f32, where their pixels aren't.
    let to_pixels = F64(0u, (1023u - raster.fraction_bits) << 20u);
    if raster.is_orthographic == 1u {
        let x = f64_add(projected[0], projection_term(face, 12u));
        let y = f64_add(projected[1], projection_term(face, 13u));
        let key = f64_to_f32_bits(f64_negate(projected[2]));
        if fits_fixed(x) && fits_fixed(y) {
            return vec4<u32>(bitcast<u32>(fixed(x)), bitcast<u32>(fixed(y)), key, VERTEX_REGULAR);
        }
        return vec4<u32>(pixels(x, to_pixels), pixels(y, to_pixels), key, VERTEX_HOMOGENEOUS);
    }
    // The high words of positive numbers compare as the numbers do; bits are added to the exponent.
    let depth_high = projected[2].y;
    if (depth_high & 0x80000000u) == 0u && depth_high + (raster.depth_bits << 20u) > largest {
        let inverse = f64_divide(F64(0u, 0x3ff00000u), projected[2]);
        let x = f64_multiply(projected[0], inverse);
        let y = f64_multiply(projected[1], inverse);
        let key = f64_to_f32_bits(inverse);
        let exponent = (key >> 23u) & 0xffu;
        // Keys near the ends of f32's range are left to the homogeneous form, which ends at the predicate.
        if fits_fixed(x) && fits_fixed(y) && exponent > 27u && exponent < 227u {
            return vec4<u32>(bitcast<u32>(fixed(x)), bitcast<u32>(fixed(y)), key, VERTEX_REGULAR);
        }
    }
    return vec4<u32>(
        pixels(projected[0], to_pixels), pixels(projected[1], to_pixels), f64_to_f32_bits(projected[2]), VERTEX_HOMOGENEOUS);
}

fn pixels(value: F64, to_pixels: F64) -> u32 {
    return f64_to_f32_bits(f64_multiply(value, to_pixels));
}
