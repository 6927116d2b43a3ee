// The ray through a place in the image: bit for bit the Rust crate's `View::ray`.

import package::exact::double::{F64, f64_add, f64_subtract, f64_multiply, f64_divide, f64_from_u32};
import package::exact::predicate::{ExactRay};
import package::exact::vector::{F64Vector, f64_vector_from_f32_bits};

// A camera and the size of its image in pixels; the rest are bits of f32.
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

// The ray through a place: `x_pixels` from 0 at the left edge, `y_pixels` from 0 at the upper edge.
fn exact_ray(view: ExactView, x_pixels: F64, y_pixels: F64) -> ExactRay {
    let half_height = f64_from_f32_bits(view.half_height);
    let height = f64_from_u32(view.height);
    let twice_x = f64_add(x_pixels, x_pixels);
    let twice_y = f64_add(y_pixels, y_pixels);
    var minuends = array<F64, 2>(twice_x, height);
    var subtrahends = array<F64, 2>(f64_from_u32(view.width), twice_y);
    var axes = array<F64Vector, 2>(f64_vector_from_f32_bits(view.right), f64_vector_from_f32_bits(view.up));
    // right · (x · half height) + up · (y · half height); a sum that starts from −0 starts with its first term.
    var across = F64Vector(F64_NEGATIVE_ZERO, F64_NEGATIVE_ZERO, F64_NEGATIVE_ZERO);
    for (var side = 0u; side < 2u; side++) {
        let place = f64_divide(f64_subtract(minuends[side], subtrahends[side]), height);
        let factor = f64_multiply(place, half_height);
        for (var axis = 0u; axis < 3u; axis++) {
            across[axis] = f64_add(across[axis], f64_multiply(axes[side][axis], factor));
        }
    }
    let position = f64_vector_from_f32_bits(view.position);
    let forward = f64_vector_from_f32_bits(view.forward);
    var origin = position;
    var direction = forward;
    for (var axis = 0u; axis < 3u; axis++) {
        if view.is_orthographic != 0u {
            origin[axis] = f64_add(origin[axis], across[axis]);
        } else {
            direction[axis] = f64_add(direction[axis], across[axis]);
        }
    }
    return ExactRay(origin, direction);
}
