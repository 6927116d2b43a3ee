// Conversion to fixed-point coordinates.

import package::exact::wide::{Wide};

// Whether a number is below 2³⁰ in magnitude.
fn fits_fixed(value: Wide) -> bool {
    return value.exponent + 63 < 30;
}

// Nearest integer to a number below 2³⁰ in magnitude.
fn fixed(value: Wide) -> i32 {
    let shift = -(value.exponent + 32);
    let rounded = ((value.bits.y >> u32(clamp(shift - 1, 0, 31))) + 1u) >> 1u;
    let magnitude = select(i32(rounded), 0, shift > 32);
    return select(magnitude, -magnitude, value.sign != 0u);
}
