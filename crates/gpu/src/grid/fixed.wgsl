// Numbers as fixed-point coordinates.

import package::exact::double::{F64, f64_add};

// Whether a number is below 2³⁰ in magnitude.
fn fits_fixed(value: F64) -> bool {
    return (value.y & 0x7fffffffu) < 0x41d00000u;
}

// The nearest integer of a number below 2³⁰ in magnitude.
fn fixed(value: F64) -> i32 {
    // Adding 1.5 · 2⁵² leaves the integer in the low word.
    return bitcast<i32>(f64_add(value, F64(0u, 0x43380000u)).x);
}
