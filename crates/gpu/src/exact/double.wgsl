// IEEE 754 binary64 in 32-bit integers, with the bits of Rust's f64, subnormals included.
//
// WGSL has no f64, and a compiler may contract or reassociate its f32, so nothing here computes in floating point.
// Results are rounded to nearest, ties to even. Every NaN is one and the same.

// The bits of a binary64: low word, high word.
alias F64 = vec2<u32>;

// A sum or a product in two terms, as high + low.
struct F64Terms {
    // The rounded result.
    high: F64,
    // The rounding error; +0 if there is none.
    low: F64,
}

// A number apart from its sign: significand · 2^(exponent − 1075).
struct F64Parts {
    significand: vec2<u32>,
    exponent: i32,
}

const F64_SIGN = 0x80000000u;
const F64_HIDDEN_BIT = 0x00100000u;
const F64_NAN = F64(0u, 0x7ff80000u);
const F64_ZERO = F64(0u, 0u);
const F64_NEGATIVE_ZERO = F64(0u, F64_SIGN);

// Unsigned integers of 64 bits: low word, high word.

fn bits_add(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + u32(low < a.x));
}

fn bits_subtract(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

fn bits_negate_if(condition: bool, a: vec2<u32>) -> vec2<u32> {
    return select(a, vec2(0u - a.x, ~a.y + u32(a.x == 0u)), condition);
}

fn bits_less(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn bits_leading_zeros(a: vec2<u32>) -> u32 {
    return countLeadingZeros(select(a.y, a.x, a.y == 0u)) + select(0u, 32u, a.y == 0u);
}

// Zero for shifts by 64 and more.
fn bits_shift_left(a: vec2<u32>, count: u32) -> vec2<u32> {
    let within = count & 31u;
    // In two steps, since WGSL has no shift by 32.
    let shifted = vec2(a.x << within, (a.y << within) | ((a.x >> 1u) >> (31u - within)));
    let moved = select(shifted, vec2(0u, shifted.x), count >= 32u);
    return select(moved, vec2(0u), count >= 64u);
}

// Zero for shifts by 64 and more.
fn bits_shift_right(a: vec2<u32>, count: u32) -> vec2<u32> {
    let within = count & 31u;
    let shifted = vec2((a.x >> within) | ((a.y << 1u) << (31u - within)), a.y >> within);
    let moved = select(shifted, vec2(shifted.y, 0u), count >= 32u);
    return select(moved, vec2(0u), count >= 64u);
}

// Shifts to the right; the lowest bit is set as well if a bit that was shifted out was set.
fn bits_shift_right_sticky(a: vec2<u32>, count: u32) -> vec2<u32> {
    // Includes the lowest bit that stays: if that is set already, setting it changes nothing.
    let within = 31u - (count & 31u);
    let lost = select(a.x << within, (a.y << within) | a.x, count >= 32u);
    let shifted = bits_shift_right(a, count);
    return vec2(shifted.x | u32(select(lost, a.x | a.y, count >= 64u) != 0u), shifted.y);
}

// The product of two words.
fn bits_product(a: u32, b: u32) -> vec2<u32> {
    let first = vec2(a & 0xffffu, a >> 16u);
    let second = vec2(b & 0xffffu, b >> 16u);
    let lowest = first.x * second.x;
    let middle = first.y * second.x + (lowest >> 16u);
    let other = first.x * second.y + (middle & 0xffffu);
    return vec2((other << 16u) | (lowest & 0xffffu), first.y * second.y + (middle >> 16u) + (other >> 16u));
}

// 2⁶³ / a for a word whose highest bit is set; too small by at most 2⁻³⁰ of that.
fn bits_reciprocal(a: u32) -> u32 {
    // From the upper 16 bits: too small by at most 2⁻¹⁴ of the quotient, which each of Newton's steps squares.
    var inverse = (0x7fffffffu / ((a >> 16u) + 1u)) << 16u;
    for (var step = 0u; step < 2u; step++) {
        let missing = bits_subtract(vec2(0u, 0x80000000u), bits_product(a, inverse));
        inverse += bits_product(inverse, (missing.y << 1u) | (missing.x >> 31u)).y;
    }
    return inverse;
}

// Taking apart and putting together.

fn f64_exponent_field(a: F64) -> u32 {
    return (a.y >> 20u) & 0x7ffu;
}

// The parts of a finite number, as they are stored: a significand of 53 bits, or fewer for a subnormal number.
fn f64_parts(a: F64) -> F64Parts {
    let field = f64_exponent_field(a);
    let hidden = select(0u, F64_HIDDEN_BIT, field != 0u);
    return F64Parts(vec2(a.x, (a.y & 0xfffffu) | hidden), i32(max(field, 1u)));
}

// The parts of a finite number other than zero; the significand has exactly 53 bits, even for subnormal numbers.
fn f64_normal_parts(a: F64) -> F64Parts {
    let parts = f64_parts(a);
    let shift = bits_leading_zeros(parts.significand) - 11u;
    return F64Parts(bits_shift_left(parts.significand, shift), parts.exponent - i32(shift));
}

// The number whose highest bit is bit 62 of `significand`; the lowest ten bits are rounded away. With an `exponent` of
// 1 the highest bit may be lower.
fn f64_rounded(sign: u32, exponent: i32, significand: vec2<u32>) -> F64 {
    let up = bits_add(significand, vec2(0x200u, 0u));
    let is_tie = (significand.x & 0x3ffu) == 0x200u;
    let low = ((up.x >> 10u) | (up.y << 22u)) & ~u32(is_tie);
    // The highest bit counts one in the exponent's field, and one more where rounding carries into it.
    let high = (up.y >> 10u) + (u32(exponent - 1) << 20u);
    return select(F64(low, sign | high), F64(0u, sign | 0x7ff00000u), exponent >= 0x7ff);
}

// The number significand · 2^(exponent − 1075), for a significand of at most 53 bits. It isn't rounded, but bits below
// the smallest number are cut off. +0 for a significand of zero.
fn f64_from_parts(sign: u32, exponent: i32, significand: vec2<u32>) -> F64 {
    let kept_exponent = max(exponent, 1);
    let kept = bits_shift_right(significand, u32(kept_exponent - exponent));
    let shift = min(kept_exponent - 1, i32(bits_leading_zeros(kept)) - 11);
    let raised = bits_shift_left(kept, u32(shift));
    let number = F64(raised.x, sign | (raised.y + (u32(kept_exponent - shift - 1) << 20u)));
    return select(number, F64_ZERO, all(kept == vec2(0u)));
}

// Rounds a product or quotient whose `significand` has its highest bit at bit 62 or 61 and a sticky lowest bit.
fn f64_scaled_and_rounded(sign: u32, exponent: i32, significand: vec2<u32>) -> F64 {
    let is_low = significand.y < 0x40000000u;
    let scaled = select(significand, bits_add(significand, significand), is_low);
    // A subnormal result loses more bits.
    let own_exponent = exponent - i32(is_low);
    return f64_rounded(sign, max(own_exponent, 1), bits_shift_right_sticky(scaled, u32(max(1 - own_exponent, 0))));
}

fn f64_from_u32(value: u32) -> F64 {
    return f64_from_parts(0u, 1075, vec2(value, 0u));
}

fn f64_from_i32(value: i32) -> F64 {
    return f64_from_parts(u32(value) & F64_SIGN, 1075, vec2(select(u32(value), 0u - u32(value), value < 0), 0u));
}

// From the bits of an f32, since a variable of type f32 may lose subnormal numbers.
fn f64_from_f32_bits(bits: u32) -> F64 {
    let sign = bits & F64_SIGN;
    let field = (bits >> 23u) & 0xffu;
    let fraction = bits & 0x7fffffu;
    if field == 0xffu {
        return select(F64_NAN, F64(0u, sign | 0x7ff00000u), fraction == 0u);
    }
    // 2⁻¹⁴⁹, the smallest subnormal number, is 2^(926 − 1075).
    let significand = fraction | select(0u, 0x800000u, field != 0u);
    let magnitude = f64_from_parts(0u, 925 + i32(max(field, 1u)), vec2(significand, 0u));
    return F64(magnitude.x, sign | magnitude.y);
}

// The bits of the nearest f32, ties to even.
fn f64_to_f32_bits(a: F64) -> u32 {
    let sign = a.y & F64_SIGN;
    if f64_is_nan(a) {
        return 0x7fc00000u;
    }
    let parts = f64_parts(a);
    // The highest bit at bit 30, seven bits to be rounded away.
    let significand = bits_shift_right_sticky(parts.significand, 22u).x;
    let exponent = parts.exponent - (1023 - 127);
    let lowered = bits_shift_right_sticky(vec2(significand, 0u), u32(clamp(1 - exponent, 0, 63))).x;
    let is_tie = (lowered & 0x7fu) == 0x40u;
    let rounded = ((lowered + 0x40u) >> 7u) & ~u32(is_tie);
    let number = rounded + (u32(max(exponent, 1) - 1) << 23u);
    return sign | select(number, 0x7f800000u, exponent >= 0xff);
}

// Kinds of numbers.

fn f64_is_finite(a: F64) -> bool {
    return f64_exponent_field(a) != 0x7ffu;
}

fn f64_is_nan(a: F64) -> bool {
    return bits_less(vec2(0u, 0x7ff00000u), f64_abs(a));
}

fn f64_is_zero(a: F64) -> bool {
    return (a.x | (a.y << 1u)) == 0u;
}

// Comparisons, false for NaN.

fn f64_equal(a: F64, b: F64) -> bool {
    return !f64_is_nan(a) && !f64_is_nan(b) && (all(a == b) || (f64_is_zero(a) && f64_is_zero(b)));
}

fn f64_less(a: F64, b: F64) -> bool {
    // As integers in two's complement, zeros of both signs being one.
    let first = bits_negate_if(a.y >= F64_SIGN, f64_abs(a));
    let second = bits_negate_if(b.y >= F64_SIGN, f64_abs(b));
    let order = bits_less(vec2(first.x, first.y ^ F64_SIGN), vec2(second.x, second.y ^ F64_SIGN));
    return order && !f64_is_nan(a) && !f64_is_nan(b);
}

// |a| < |b|.
fn f64_magnitude_less(a: F64, b: F64) -> bool {
    return bits_less(f64_abs(a), f64_abs(b)) && !f64_is_nan(b);
}

fn f64_is_below_zero(a: F64) -> bool {
    return a.y >= F64_SIGN && !f64_is_zero(a) && !f64_is_nan(a);
}

fn f64_is_above_zero(a: F64) -> bool {
    return a.y < F64_SIGN && !f64_is_zero(a) && !f64_is_nan(a);
}

// Arithmetic.

fn f64_negate(a: F64) -> F64 {
    return F64(a.x, a.y ^ F64_SIGN);
}

fn f64_abs(a: F64) -> F64 {
    return F64(a.x, a.y & ~F64_SIGN);
}

// Two numbers in the order of their magnitudes.
struct F64Ordered {
    large: F64,
    of_large: F64Parts,
    of_small: F64Parts,
    // Whether their signs differ, and the difference of their exponents.
    opposite: bool,
    distance: u32,
}

fn f64_ordered(a: F64, b: F64) -> F64Ordered {
    let ordered = bits_less(f64_abs(a), f64_abs(b));
    let large = select(a, b, ordered);
    let of_large = f64_parts(large);
    let of_small = f64_parts(select(b, a, ordered));
    let distance = u32(of_large.exponent - of_small.exponent);
    return F64Ordered(large, of_large, of_small, ((a.y ^ b.y) & F64_SIGN) != 0u, distance);
}

fn f64_add(a: F64, b: F64) -> F64 {
    let terms = f64_ordered(a, b);
    let large = terms.large;
    let sign = large.y & F64_SIGN;
    // The larger number's highest bit goes to bit 61, so that a carry ends at bit 62.
    let aligned = bits_shift_right_sticky(bits_shift_left(terms.of_small.significand, 9u), terms.distance);
    let sum = bits_add(bits_shift_left(terms.of_large.significand, 9u), bits_negate_if(terms.opposite, aligned));
    // The shift stops at an exponent of 1: the result is a subnormal number.
    let shift = min(i32(bits_leading_zeros(sum)) - 1, terms.of_large.exponent);
    let rounded = f64_rounded(sign, terms.of_large.exponent + 1 - shift, bits_shift_left(sum, u32(shift)));
    // Equal magnitudes of opposite signs cancel to +0, or to NaN if they are infinite.
    let is_zero = all(sum == vec2(0u));
    let number = select(rounded, F64(0u, select(sign, 0u, terms.opposite)), is_zero);
    let is_nan = f64_is_nan(large) || (is_zero && terms.opposite);
    return select(number, select(large, F64_NAN, is_nan), !f64_is_finite(large));
}

fn f64_subtract(a: F64, b: F64) -> F64 {
    return f64_add(a, f64_negate(b));
}

fn f64_multiply(a: F64, b: F64) -> F64 {
    return f64_product(a, b).rounded;
}

// The rounded sum and its exact rounding error, as in Knuth's algorithm (which overflows within a factor of two of the
// largest number; this doesn't). The error is NaN if the sum isn't finite.
fn two_sum(a: F64, b: F64) -> F64Terms {
    let high = f64_add(a, b);
    let terms = f64_ordered(a, b);
    // The error is a multiple of the smaller number's last place, below 2⁵³ of them. So the difference of the unrounded
    // and the rounded sum is right in 64 bits although its terms aren't.
    let of_high = f64_parts(high);
    let rise = of_high.exponent - terms.of_small.exponent;
    let summed = bits_add(
        bits_shift_left(terms.of_large.significand, terms.distance),
        bits_negate_if(terms.opposite, terms.of_small.significand),
    );
    let loss = bits_subtract(summed, bits_shift_left(of_high.significand, u32(rise)));
    let is_below = loss.y >= F64_SIGN;
    let sign = (terms.large.y ^ loss.y) & F64_SIGN;
    let low = f64_from_parts(sign, terms.of_small.exponent, bits_negate_if(is_below, loss));
    // A sum with smaller digits than its terms has cancelled and is exact.
    return F64Terms(high, select(select(low, F64_ZERO, rise < 0), F64_NAN, !f64_is_finite(high)));
}

// A product rounded, and the lowest 64 of its 112 bits, whose last place is 2^(exponent − 1075 − 58).
struct F64Product {
    rounded: F64,
    bits: vec2<u32>,
    exponent: i32,
}

fn f64_product(a: F64, b: F64) -> F64Product {
    let sign = (a.y ^ b.y) & F64_SIGN;
    let of_a = f64_normal_parts(a);
    let of_b = f64_normal_parts(b);

    // Digits of 14 bits of the significands times eight: their products fit into 32 bits, and so do sums of four.
    let x = bits_digits(of_a.significand);
    let y = bits_digits(of_b.significand);
    let column_0 = x.x * y.x;
    let column_1 = x.x * y.y + x.y * y.x + (column_0 >> 14u);
    let column_2 = x.x * y.z + x.y * y.y + x.z * y.x + (column_1 >> 14u);
    let column_3 = x.x * y.w + x.y * y.z + x.z * y.y + x.w * y.x + (column_2 >> 14u);
    let column_4 = x.y * y.w + x.z * y.z + x.w * y.y + (column_3 >> 14u);
    let column_5 = x.z * y.w + x.w * y.z + (column_4 >> 14u);
    let column_6 = x.w * y.w + (column_5 >> 14u);
    // The product has 112 bits, 56 in each.
    let lower = bits_from_digits(vec4(column_0, column_1, column_2, column_3));
    let upper = bits_from_digits(vec4(column_4, column_5, column_6 & 0x3fffu, column_6 >> 14u));

    let top = bits_shift_left(upper, 7u);
    let below = bits_shift_right_sticky(lower, 49u).x;
    // A product of ones, with its highest bit at bit 61, has the sum of the exponents as its own.
    let exponent = of_a.exponent + of_b.exponent - 1023;
    let rounded = f64_scaled_and_rounded(sign, exponent + 1, vec2(top.x | below, top.y));
    let is_zero = f64_is_zero(a) || f64_is_zero(b);
    let is_infinite = !f64_is_finite(a) || !f64_is_finite(b);
    let is_nan = f64_is_nan(a) || f64_is_nan(b) || (is_zero && is_infinite);
    let number = select(rounded, F64(0u, sign | select(0u, 0x7ff00000u, is_infinite)), is_zero || is_infinite);
    return F64Product(
        select(number, F64_NAN, is_nan), vec2(lower.x, lower.y | (upper.x << 24u)), exponent);
}

// The rounded product and its rounding error, as in Dekker's algorithm wherever that is exact. Bits of the error below
// the smallest number are cut off. The error is NaN if the product isn't finite.
fn two_product(a: F64, b: F64) -> F64Terms {
    let product = f64_product(a, b);
    let high = product.rounded;
    // Right in 64 bits, as for sums. Both significands had been multiplied by eight.
    let of_high = f64_parts(high);
    let rise = of_high.exponent - product.exponent + 58;
    let loss = bits_subtract(product.bits, bits_shift_left(of_high.significand, u32(rise)));
    let magnitude = bits_shift_right(bits_negate_if(loss.y >= F64_SIGN, loss), 6u);
    // A subnormal product's error is below the smallest number.
    let is_exact = f64_is_zero(a) || f64_is_zero(b) || f64_exponent_field(high) == 0u;
    let low = f64_from_parts((a.y ^ b.y ^ loss.y) & F64_SIGN, product.exponent - 52, magnitude);
    return F64Terms(high, select(select(low, F64_ZERO, is_exact), F64_NAN, !f64_is_finite(high)));
}

// Eight times a number of 53 bits in digits of 14 bits, the lowest first.
fn bits_digits(a: vec2<u32>) -> vec4<u32> {
    return vec4(a.x << 3u, a.x >> 11u, (a.x >> 25u) | (a.y << 7u), a.y >> 7u) & vec4(0x3fffu);
}

// 56 bits from the lowest 14 bits of each digit, the lowest first.
fn bits_from_digits(digits: vec4<u32>) -> vec2<u32> {
    let cut = digits & vec4(0x3fffu);
    return vec2(cut.x | (cut.y << 14u) | (cut.z << 28u), (cut.z >> 4u) | (cut.w << 10u));
}

fn f64_divide(a: F64, b: F64) -> F64 {
    let sign = (a.y ^ b.y) & F64_SIGN;
    let is_infinite = !f64_is_finite(a) || f64_is_zero(b);
    let is_zero = f64_is_zero(a) || !f64_is_finite(b);
    if f64_is_nan(a) || f64_is_nan(b) || (is_infinite && is_zero) {
        return F64_NAN;
    }
    if is_infinite || is_zero {
        return F64(0u, sign | select(0u, 0x7ff00000u, is_infinite));
    }
    let of_a = f64_normal_parts(a);
    let of_b = f64_normal_parts(b);
    // The quotient has 55 bits: 53, one to round by, and one since the first may be zero. Long division in digits of 28
    // and 27 bits: each comes from the reciprocal of the divisor's upper 32 bits, and is too small by at most one.
    let divisor = of_b.significand;
    // Less by two, because the divisor's lower bits, which are cut off, make it larger.
    let inverse = bits_reciprocal(bits_shift_left(divisor, 11u).y) - 2u;
    var rest = of_a.significand;
    var quotient = vec2(0u);
    for (var step = 0u; step < 2u; step++) {
        var digit = bits_product(bits_shift_right(rest, 21u).x, inverse).y >> 4u;
        // Right in 64 bits, since the remainder is below the divisor, or below twice the divisor.
        let low = bits_product(digit, divisor.x);
        rest = bits_subtract(bits_shift_left(rest, 27u), vec2(low.x, low.y + digit * divisor.y));
        let fits = !bits_less(rest, divisor);
        rest = bits_subtract(rest, select(vec2(0u), divisor, fits));
        digit += u32(fits);
        quotient = bits_add(bits_shift_left(quotient, 27u), vec2(digit, 0u));
    }
    let significand = bits_shift_left(quotient, 8u);
    let sticky = u32(any(rest != vec2(0u)));
    return f64_scaled_and_rounded(sign, of_a.exponent - of_b.exponent + 1023, significand | vec2(sticky, 0u));
}

// The larger of |a| and |b|; |b| if either is NaN.
fn f64_larger_magnitude(a: F64, b: F64) -> F64 {
    return f64_abs(select(b, a, f64_magnitude_less(b, a)));
}
