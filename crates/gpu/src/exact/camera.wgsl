// The ray through a point in the image: bit for bit the Rust crate's `View::ray`.

import package::exact::double::{F64, f64_add, f64_divide, f64_from_f32_bits, f64_from_u32, f64_multiply, f64_subtract};
import package::exact::predicate::{ExactRay};
import package::exact::vector::{F64Vector, f64_vector_add, f64_vector_from_f32_bits, f64_vector_scale};

// A camera, in bits of f32, and the size of its image in pixels.
struct ExactView {
    position: vec3<u32>,
    // Tangent of half the vertical field of view; of an orthographic camera half the height of its view.
    half_height: u32,
    right: vec3<u32>,
    is_orthographic: u32,
    up: vec3<u32>,
    width: u32,
    forward: vec3<u32>,
    height: u32,
}

// The ray of the pixel in a column and a row, through an offset within it from (0, 0) at its upper left to (1, 1).
fn exact_pixel_ray(view: ExactView, column: u32, row: u32, x_offset: F64, y_offset: F64) -> ExactRay {
    return exact_ray(view, f64_add(f64_from_u32(column), x_offset), f64_add(f64_from_u32(row), y_offset));
}

// The ray through a point: `x_pixels` from 0 at the left edge, `y_pixels` from 0 at the upper edge.
fn exact_ray(view: ExactView, x_pixels: F64, y_pixels: F64) -> ExactRay {
    let axis = ExactRay(f64_vector_from_f32_bits(view.position), f64_vector_from_f32_bits(view.forward));
    let across = f64_vector_add(exact_across(view, x_pixels, false), exact_across(view, y_pixels, true));
    return exact_ray_beside(axis, across, view.is_orthographic != 0u);
}

// Offset from the camera's axis of a column of points, or of a row.
fn exact_across(view: ExactView, pixels: F64, is_row: bool) -> F64Vector {
    let height = f64_from_u32(view.height);
    let twice = f64_add(pixels, pixels);
    let from_middle = f64_subtract(select(twice, height, is_row), select(f64_from_u32(view.width), twice, is_row));
    let part = f64_multiply(f64_divide(from_middle, height), f64_from_f32_bits(view.half_height));
    return f64_vector_scale(f64_vector_from_f32_bits(select(view.right, view.up, is_row)), part);
}

// The ray at the offset `across` from a camera's axis.
fn exact_ray_beside(axis: ExactRay, across: F64Vector, is_orthographic: bool) -> ExactRay {
    if is_orthographic {
        return ExactRay(f64_vector_add(axis.origin, across), axis.direction);
    }
    return ExactRay(axis.origin, f64_vector_add(axis.direction, across));
}
