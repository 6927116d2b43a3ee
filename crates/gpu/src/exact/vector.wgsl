// Vectors of F64, with glam's order of operations.

import package::exact::double::{F64, f64_add, f64_subtract, f64_multiply, f64_from_f32_bits, f64_maximum};

alias F64Vector = array<F64, 3>;

// From the bits of f32 coordinates.
fn f64_vector_from_f32_bits(bits: vec3<u32>) -> F64Vector {
    return F64Vector(f64_from_f32_bits(bits.x), f64_from_f32_bits(bits.y), f64_from_f32_bits(bits.z));
}

fn f64_vector_subtract(a: F64Vector, b: F64Vector) -> F64Vector {
    var difference: F64Vector;
    for (var axis = 0u; axis < 3u; axis++) {
        difference[axis] = f64_subtract(a[axis], b[axis]);
    }
    return difference;
}

fn f64_vector_scale(a: F64Vector, factor: F64) -> F64Vector {
    var vector = a;
    for (var axis = 0u; axis < 3u; axis++) {
        vector[axis] = f64_multiply(vector[axis], factor);
    }
    return vector;
}

fn f64_dot(a: F64Vector, b: F64Vector) -> F64 {
    // A sum that starts from −0 starts with the first product.
    var sum = F64_NEGATIVE_ZERO;
    for (var axis = 0u; axis < 3u; axis++) {
        sum = f64_add(sum, f64_multiply(a[axis], b[axis]));
    }
    return sum;
}

fn f64_cross(a: F64Vector, b: F64Vector) -> F64Vector {
    var cross: F64Vector;
    for (var axis = 0u; axis < 3u; axis++) {
        let next = (axis + 1u) % 3u;
        let last = (axis + 2u) % 3u;
        cross[axis] = f64_subtract(f64_multiply(a[next], b[last]), f64_multiply(b[next], a[last]));
    }
    return cross;
}

// The magnitude of the component that is the furthest from zero.
fn f64_largest_magnitude(a: F64Vector) -> F64 {
    return f64_maximum(f64_abs(a[0]), f64_maximum(f64_abs(a[1]), f64_abs(a[2])));
}
