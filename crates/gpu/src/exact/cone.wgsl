// The cone of a spot light.

import package::exact::double::{F64, f64_is_above_zero, f64_less, f64_multiply};
import package::exact::vector::{F64Vector, f64_dot, f64_vector_from_f32_bits, f64_vector_subtract};

// Whether a position is in a spot's cone. The spot's position and axis are bits of f32. Operations are in the order of
// the Rust crate's `Cone::contains`.
fn exact_is_in_cone(position: F64Vector, spot: vec3<u32>, axis: vec3<u32>, squared_cosine: F64) -> bool {
    let v = f64_vector_subtract(position, f64_vector_from_f32_bits(spot));
    let along = f64_dot(f64_vector_from_f32_bits(axis), v);
    let least = f64_multiply(squared_cosine, f64_dot(v, v));
    return f64_is_above_zero(along) && !f64_less(f64_multiply(along, along), least);
}
