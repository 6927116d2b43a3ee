// Vectors of F64, with glam's order of operations.

import package::exact::double::{
    F64, f64_add, f64_from_f32_bits, f64_larger_magnitude, f64_multiply, f64_negate, f64_subtract,
};

// Loops over axes rotate vectors instead of indexing them: an indexed vector lies in memory rather than in registers,
// which made the loops twice as slow (lavapipe). A loop pays if its body is long; a short one compiles to more code
// than the unrolled operations.
struct F64Vector {
    x: F64,
    y: F64,
    z: F64,
}

// From the bits of f32 coordinates.
fn f64_vector_from_f32_bits(bits: vec3<u32>) -> F64Vector {
    return F64Vector(f64_from_f32_bits(bits.x), f64_from_f32_bits(bits.y), f64_from_f32_bits(bits.z));
}

// Rotates the axes: y first.
fn f64_vector_turned(a: F64Vector) -> F64Vector {
    return F64Vector(a.y, a.z, a.x);
}

fn f64_vector_add(a: F64Vector, b: F64Vector) -> F64Vector {
    var left = a;
    var right = b;
    var sum: F64Vector;
    for (var axis = 0u; axis < 3u; axis++) {
        sum = F64Vector(sum.y, sum.z, f64_add(left.x, right.x));
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
    }
    return sum;
}

fn f64_vector_subtract(a: F64Vector, b: F64Vector) -> F64Vector {
    return f64_vector_add(a, f64_vector_negate(b));
}

fn f64_vector_negate(a: F64Vector) -> F64Vector {
    return F64Vector(f64_negate(a.x), f64_negate(a.y), f64_negate(a.z));
}

fn f64_vector_scale(a: F64Vector, factor: F64) -> F64Vector {
    var scaled = a;
    for (var axis = 0u; axis < 3u; axis++) {
        scaled = F64Vector(scaled.y, scaled.z, f64_multiply(scaled.x, factor));
    }
    return scaled;
}

fn f64_dot(a: F64Vector, b: F64Vector) -> F64 {
    var left = a;
    var right = b;
    var sum: F64;
    for (var axis = 0u; axis < 3u; axis++) {
        let product = f64_multiply(left.x, right.x);
        sum = select(f64_add(sum, product), product, axis == 0u);
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
    }
    return sum;
}

fn f64_cross(a: F64Vector, b: F64Vector) -> F64Vector {
    var left = a;
    var right = b;
    var cross: F64Vector;
    for (var axis = 0u; axis < 3u; axis++) {
        let component = f64_subtract(f64_multiply(left.y, right.z), f64_multiply(right.y, left.z));
        cross = F64Vector(cross.y, cross.z, component);
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
    }
    return cross;
}

// Largest magnitude of the three components.
fn f64_largest_magnitude(a: F64Vector) -> F64 {
    return f64_larger_magnitude(a.x, f64_larger_magnitude(a.y, a.z));
}
