// IEEE 754 binary32 in 32-bit integers, with the bits of Rust's f32. Every NaN is one and the same.
//
// Operations go through F64, which has more than twice the bits: rounding twice then is the same as rounding once
// (Figueroa, "When is double rounding innocuous?", 1995).

import package::exact::double::{f64_add, f64_from_f32_bits, f64_multiply, f64_to_f32_bits};

const F32_ZERO = 0u;
const F32_HALF = 0x3f000000u;
const F32_ONE = 0x3f800000u;
const F32_SIGN = 0x80000000u;

fn f32_add(a: u32, b: u32) -> u32 {
    return f64_to_f32_bits(f64_add(f64_from_f32_bits(a), f64_from_f32_bits(b)));
}

fn f32_subtract(a: u32, b: u32) -> u32 {
    return f32_add(a, b ^ F32_SIGN);
}

fn f32_multiply(a: u32, b: u32) -> u32 {
    return f64_to_f32_bits(f64_multiply(f64_from_f32_bits(a), f64_from_f32_bits(b)));
}

fn f32_is_nan(a: u32) -> bool {
    return (a & 0x7fffffffu) > 0x7f800000u;
}

// a ≥ b; false for NaN.
fn f32_at_least(a: u32, b: u32) -> bool {
    return !f32_is_nan(a) && !f32_is_nan(b) && f32_order(a) >= f32_order(b);
}

// An integer in the order of the f32 with these bits, except for NaN; zeros of both signs have the same.
fn f32_order(bits: u32) -> i32 {
    let magnitude = i32(bits & 0x7fffffffu);
    return select(magnitude, -magnitude, bits >= F32_SIGN);
}

// The greatest whole number that isn't above `a`.
fn f32_floor(a: u32) -> u32 {
    let field = (a >> 23u) & 0xffu;
    if field >= 150u || (a & 0x7fffffffu) == 0u {
        return a;
    }
    let is_negative = a >= F32_SIGN;
    if field < 127u {
        return select(F32_ZERO, F32_ONE | F32_SIGN, is_negative);
    }
    let below_point = 0x7fffffu >> (field - 127u);
    return select(a, a + below_point, is_negative) & ~below_point;
}

// byte ÷ 255: in binary, the byte repeated behind the point.
fn f32_from_byte(byte: u32) -> u32 {
    let repeated = byte * 0x01010101u;
    let zeros = countLeadingZeros(repeated);
    // Rounded by the next bit alone: the digits never end, so there is no tie.
    let shifted = repeated << (zeros & 31u);
    let significand = (shifted >> 8u) + ((shifted >> 7u) & 1u);
    return select(significand + ((125u - zeros) << 23u), F32_ZERO, byte == 0u);
}
