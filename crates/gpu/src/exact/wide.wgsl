// Numbers of 64 significant bits, for filters: several times as fast as binary64 and more precise, but with other
// results. The error of a sum is below 2⁻⁶¹ of its larger term, and zero for two f32 within 2³⁸ of each other; the
// relative error of a product is 2⁻⁶⁰, that of a quotient 2⁻⁵⁶.

import package::exact::double::{
    F64, F64_SIGN, bits_add, bits_leading_zeros, bits_less, bits_negate_if, bits_product, bits_reciprocal, bits_shift_left,
    bits_shift_right, f64_exponent_field,
};

// bits · 2^exponent; the highest bit is set, unless it is zero. There are no other numbers: exponents don't overflow.
struct Wide {
    bits: vec2<u32>,
    exponent: i32,
    // F64_SIGN or zero.
    sign: u32,
}

struct WideVector {
    x: Wide,
    y: Wide,
    z: Wide,
}

// Exponent of zero: below that of any product.
const WIDE_NOTHING: i32 = -1000000;
const WIDE_ONE: Wide = Wide(vec2<u32>(0u, F64_SIGN), -63, 0u);
const WIDE_TWO: Wide = Wide(vec2<u32>(0u, F64_SIGN), -62, 0u);

// From a finite F64; a subnormal one becomes zero.
fn wide_from_f64(a: F64) -> Wide {
    let field = i32(f64_exponent_field(a));
    let bits = vec2<u32>(a.x << 11u, (a.y << 11u) | (a.x >> 21u) | F64_SIGN);
    return Wide(
        select(bits, vec2<u32>(0u), field == 0), select(field - (1023 + 63), WIDE_NOTHING, field == 0), a.y & F64_SIGN);
}

// From the bits of a finite f32.
fn wide_from_f32_bits(a: u32) -> Wide {
    let field = (a >> 23u) & 0xffu;
    let significand = (a & 0x7fffffu) | select(0u, 0x800000u, field != 0u);
    let shift = countLeadingZeros(significand);
    let exponent = i32(max(field, 1u)) - (150 + 32) - i32(shift);
    // WGSL has no shift by 32: zero isn't shifted.
    return Wide(
        vec2<u32>(0u, significand << (shift & 31u)), select(exponent, WIDE_NOTHING, significand == 0u), a & F64_SIGN);
}

// Normalises any bits.
fn wide_from_bits(bits: vec2<u32>, exponent: i32, sign: u32) -> Wide {
    let shift = bits_leading_zeros(bits);
    return Wide(bits_shift_left(bits, shift), select(exponent - i32(shift), WIDE_NOTHING, shift >= 64u), sign);
}

// Truncated to 53 bits; zero outside of the range of normal numbers.
fn wide_to_f64(a: Wide) -> F64 {
    let field = a.exponent + 63 + 1023;
    // The highest bit counts one in the exponent's field.
    let high = (a.bits.y >> 11u) + (u32(field - 1) << 20u);
    let bits = F64((a.bits.x >> 11u) | (a.bits.y << 21u), a.sign | high);
    return select(F64(0u, a.sign), bits, field > 0 && field < 2047);
}

// Bits of a nearest f32, which may be zero or infinity.
fn wide_to_f32_bits(a: Wide) -> u32 {
    let field = a.exponent + 63 + 127;
    // A subnormal number has fewer bits.
    let kept = a.bits.y >> u32(clamp(1 - field, 0, 31));
    let number = (kept >> 8u) + ((kept >> 7u) & 1u) + (u32(max(field, 1) - 1) << 23u);
    return a.sign | select(number, 0x7f800000u, field >= 0xff);
}

fn wide_is_zero(a: Wide) -> bool {
    return a.bits.y == 0u;
}

fn wide_is_above_zero(a: Wide) -> bool {
    return a.bits.y != 0u && a.sign == 0u;
}

// |a| < |b|.
fn wide_magnitude_less(a: Wide, b: Wide) -> bool {
    return a.exponent < b.exponent || (a.exponent == b.exponent && bits_less(a.bits, b.bits));
}

// A number other than zero, times a power of two.
fn wide_scaled(a: Wide, exponent: i32) -> Wide {
    return Wide(a.bits, a.exponent + exponent, a.sign);
}

fn wide_negate(a: Wide) -> Wide {
    return Wide(a.bits, a.exponent, a.sign ^ F64_SIGN);
}

fn wide_add(a: Wide, b: Wide) -> Wide {
    let ordered = a.exponent < b.exponent;
    let exponent = max(a.exponent, b.exponent);
    let distance = u32(exponent - min(a.exponent, b.exponent));
    // One bit stays free for the carry.
    let larger = select(a.bits, b.bits, ordered);
    let large = vec2<u32>((larger.x >> 1u) | (larger.y << 31u), larger.y >> 1u);
    let small = bits_shift_right(select(b.bits, a.bits, ordered), distance + 1u);
    let opposite = a.sign != b.sign;
    let sum = bits_add(large, bits_negate_if(opposite, small));
    // If the exponents are equal, the second may be the larger one.
    let is_below = opposite && sum.y >= F64_SIGN;
    let sign = select(a.sign, b.sign, ordered) ^ select(0u, F64_SIGN, is_below);
    return wide_from_bits(bits_negate_if(is_below, sum), exponent + 1, sign);
}

fn wide_subtract(a: Wide, b: Wide) -> Wide {
    return wide_add(a, wide_negate(b));
}

fn wide_multiply(a: Wide, b: Wide) -> Wide {
    let product = wide_product(a, b);
    let is_low = product.bits.y < F64_SIGN;
    let bits = select(product.bits, bits_add(product.bits, product.bits), is_low);
    return Wide(bits, product.exponent - i32(is_low), product.sign);
}

// A product whose highest bit may be bit 62 instead of bit 63, for sums.
fn wide_product(a: Wide, b: Wide) -> Wide {
    // Leaves out the lowest of the four products of words, and the lower words of two more.
    let cross = bits_product(a.bits.y, b.bits.x).y;
    let other = bits_product(a.bits.x, b.bits.y).y;
    let high = bits_product(a.bits.y, b.bits.y);
    let bits = bits_add(bits_add(high, vec2<u32>(cross, 0u)), vec2<u32>(other, 0u));
    return Wide(bits, select(a.exponent + b.exponent + 64, WIDE_NOTHING, bits.y == 0u), a.sign ^ b.sign);
}

// Reciprocal of a number other than zero.
fn wide_reciprocal(a: Wide) -> Wide {
    // The relative error is 2⁻²⁹, which Newton's step squares.
    let upper = max(bits_reciprocal(a.bits.y), F64_SIGN);
    let rough = Wide(vec2<u32>(0u, upper), -127 - a.exponent, a.sign);
    return wide_multiply(rough, wide_subtract(WIDE_TWO, wide_multiply(a, rough)));
}

// From the bits of f32 coordinates.
fn wide_vector_from_f32_bits(bits: vec3<u32>) -> WideVector {
    return WideVector(wide_from_f32_bits(bits.x), wide_from_f32_bits(bits.y), wide_from_f32_bits(bits.z));
}

fn wide_vector_subtract(a: WideVector, b: WideVector) -> WideVector {
    return WideVector(wide_subtract(a.x, b.x), wide_subtract(a.y, b.y), wide_subtract(a.z, b.z));
}

// origin + distance · direction.
fn wide_vector_along(origin: WideVector, direction: WideVector, distance: Wide) -> WideVector {
    return WideVector(
        wide_add(origin.x, wide_multiply(direction.x, distance)),
        wide_add(origin.y, wide_multiply(direction.y, distance)),
        wide_add(origin.z, wide_multiply(direction.z, distance)),
    );
}

// Normalised once: the error is 2⁻⁵⁷ of the largest term.
fn wide_dot(a: WideVector, b: WideVector) -> Wide {
    let x = wide_product(a.x, b.x);
    let y = wide_product(a.y, b.y);
    let z = wide_product(a.z, b.z);
    let exponent = max(max(x.exponent, y.exponent), z.exponent);
    let sum = bits_add(bits_add(wide_term(x, exponent), wide_term(y, exponent)), wide_term(z, exponent));
    let sign = sum.y & F64_SIGN;
    return wide_from_bits(bits_negate_if(sign != 0u, sum), exponent + 3, sign);
}

// An eighth of a number's bits at a larger exponent, in two's complement: leaves room for the sum of three, and a sign.
fn wide_term(a: Wide, exponent: i32) -> vec2<u32> {
    return bits_negate_if(a.sign != 0u, bits_shift_right(a.bits, u32(exponent - a.exponent) + 3u));
}

fn wide_cross(a: WideVector, b: WideVector) -> WideVector {
    return WideVector(
        wide_subtract(wide_product(a.y, b.z), wide_product(b.y, a.z)),
        wide_subtract(wide_product(a.z, b.x), wide_product(b.z, a.x)),
        wide_subtract(wide_product(a.x, b.y), wide_product(b.x, a.y)),
    );
}

// Largest magnitude of the three components.
fn wide_largest_magnitude(a: WideVector) -> Wide {
    var largest = a.x;
    if wide_magnitude_less(largest, a.y) {
        largest = a.y;
    }
    if wide_magnitude_less(largest, a.z) {
        largest = a.z;
    }
    return Wide(largest.bits, largest.exponent, 0u);
}
