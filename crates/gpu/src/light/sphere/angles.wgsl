// Angles of points and vertices, for a light that sees by angles.
//
// The light's space has rows for right, up and forward of length one. `row_reach` is a power of two that makes the
// farthest point's largest coordinate about one: offsets from the light are multiplied by it. `depth_error` is the
// error of points' coordinates, besides 2⁻⁴⁰ of the largest and their rounding.

import package::exact::double::{f64_from_f32_bits, f64_to_f32_bits};
import package::exact::vector::{F64Vector, f64_dot, f64_vector_scale, f64_vector_subtract};
import package::grid::projection::{projection_vector};
import package::light::sphere::turn::{HALF_TURN};
import stage::{spaces};

// Offset of a position from the light, scaled.
fn scaled_offset(position: F64Vector) -> F64Vector {
    let scale = f64_from_f32_bits(bitcast<u32>(spaces[0].raster.row_reach));
    return f64_vector_scale(f64_vector_subtract(position, projection_vector(0u, 0u)), scale);
}

// An offset along the light's axes.
fn along_axes(offset: F64Vector) -> vec3<f32> {
    return vec3<f32>(part_along(offset, 3u), part_along(offset, 6u), part_along(offset, 9u));
}

fn part_along(offset: F64Vector, row: u32) -> f32 {
    return bitcast<f32>(f64_to_f32_bits(f64_dot(projection_vector(0u, row), offset)));
}

fn f32_bits_of(vector: F64Vector) -> vec3<u32> {
    return vec3<u32>(f64_to_f32_bits(vector.x), f64_to_f32_bits(vector.y), f64_to_f32_bits(vector.z));
}

// The angle of a vector other than zero, in the units of `turn`.
fn angle_of(across: f32, along: f32) -> i32 {
    let part = across / (abs(across) + abs(along));
    let side = select(-2.0, 2.0, across >= 0.0);
    return i32(select(part, side - part, along < 0.0) * f32(HALF_TURN / 2));
}
