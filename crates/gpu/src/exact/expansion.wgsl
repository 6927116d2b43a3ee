// More than 53 bits: double-double numbers and Shewchuk's expansions, bit for bit as the Rust crate's `predicate::double`
// and `predicate::expansion`.
//
// Compilers inline every call and an operation on F64 is long, so sums of products are loops rather than calls side by
// side.

import package::exact::double::{F64, two_sum, two_product, f64_add, f64_multiply, f64_divide};
import package::exact::vector::{F64Vector};

// high + low, and the sum of the magnitudes of everything that was added up to it.
struct DoubleDouble {
    high: F64,
    low: F64,
    magnitude: F64,
}

alias DoubleDoubleVector = array<DoubleDouble, 3>;

fn double_from_f64(value: F64) -> DoubleDouble {
    return DoubleDouble(value, F64_ZERO, f64_abs(value));
}

fn double_from_vector(a: F64Vector) -> DoubleDoubleVector {
    return DoubleDoubleVector(double_from_f64(a[0]), double_from_f64(a[1]), double_from_f64(a[2]));
}

// a − b on each axis, exactly.
fn double_difference(a: F64Vector, b: F64Vector) -> DoubleDoubleVector {
    var difference: DoubleDoubleVector;
    for (var axis = 0u; axis < 3u; axis++) {
        let sum = two_sum(a[axis], f64_negate(b[axis]));
        difference[axis] = DoubleDouble(sum.high, sum.low, f64_abs(sum.high));
    }
    return difference;
}

fn double_cross(a: DoubleDoubleVector, b: DoubleDoubleVector) -> DoubleDoubleVector {
    var cross: DoubleDoubleVector;
    for (var axis = 0u; axis < 3u; axis++) {
        let next = (axis + 1u) % 3u;
        let last = (axis + 2u) % 3u;
        let forward = double_times(a[next], b[last]);
        cross[axis] = double_plus(forward, double_negated(double_times(a[last], b[next])));
    }
    return cross;
}

fn double_dot(a: DoubleDoubleVector, b: DoubleDoubleVector) -> DoubleDouble {
    var sum = double_times(a[0], b[0]);
    for (var axis = 1u; axis < 3u; axis++) {
        sum = double_plus(sum, double_times(a[axis], b[axis]));
    }
    return sum;
}

// dividend ÷ divisor as an F64, to about one unit in the last place.
fn double_quotient(dividend: DoubleDouble, divisor: DoubleDouble) -> F64 {
    let first = f64_divide(dividend.high, divisor.high);
    let rest = double_plus(dividend, double_times(divisor, double_from_f64(f64_negate(first))));
    return f64_add(first, f64_divide(rest.high, divisor.high));
}

fn double_negated(a: DoubleDouble) -> DoubleDouble {
    return DoubleDouble(f64_negate(a.high), f64_negate(a.low), a.magnitude);
}

fn double_plus(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    let sum = two_sum(a.high, b.high);
    let result = two_sum(sum.high, f64_add(sum.low, f64_add(a.low, b.low)));
    return DoubleDouble(result.high, result.low, f64_add(a.magnitude, b.magnitude));
}

fn double_times(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    let product = two_product(a.high, b.high);
    let crossed = f64_add(f64_multiply(a.high, b.low), f64_multiply(a.low, b.high));
    let result = two_sum(product.high, f64_add(product.low, crossed));
    return DoubleDouble(result.high, result.low, f64_multiply(a.magnitude, b.magnitude));
}

// An expansion of at most two terms, zeros left out; `len` of them are in use.
struct TwoTerms {
    terms: array<F64, 2>,
    len: u32,
}

alias TwoTermsVector = array<TwoTerms, 3>;

const EXPANSION_SUM = 0u;
const EXPANSION_COMPONENT = 192u;

// The two expansions that `expansion_triple` works on: the sum's 192 terms at most, and a component's 16. Declare it
// where the answer is known to be needed: WGSL clears it.
alias ExpansionTerms = array<F64, 208>;

fn expansion_from_f64(value: F64) -> TwoTerms {
    return TwoTerms(array<F64, 2>(value, F64_ZERO), u32(!f64_is_zero(value)));
}

// a − b.
fn expansion_difference(a: F64, b: F64) -> TwoTerms {
    let sum = two_sum(a, f64_negate(b));
    let low_len = u32(!f64_is_zero(sum.low));
    let terms = array<F64, 2>(select(sum.low, sum.high, low_len == 0u), sum.high);
    return TwoTerms(terms, low_len + u32(!f64_is_zero(sum.high)));
}

fn expansion_vector_difference(a: F64Vector, b: F64Vector) -> TwoTermsVector {
    var difference: TwoTermsVector;
    for (var axis = 0u; axis < 3u; axis++) {
        difference[axis] = expansion_difference(a[axis], b[axis]);
    }
    return difference;
}

fn expansion_vector(a: F64Vector) -> TwoTermsVector {
    return TwoTermsVector(expansion_from_f64(a[0]), expansion_from_f64(a[1]), expansion_from_f64(a[2]));
}

// Grow-Expansion, leaving out zeros, on the `len` terms from `start` on; returns how many there are now.
fn expansion_add(terms: ptr<function, ExpansionTerms>, start: u32, len: u32, value: F64) -> u32 {
    var carry = value;
    var kept = start;
    for (var place = start; place < start + len; place++) {
        let sum = two_sum(carry, (*terms)[place]);
        carry = sum.high;
        if !f64_is_zero(sum.low) {
            (*terms)[kept] = sum.low;
            kept++;
        }
    }
    if !f64_is_zero(carry) {
        (*terms)[kept] = carry;
        kept++;
    }
    return kept - start;
}

// (a × b) · c to within one rounding, with the exact sign: three products of 2 · 16 · 2 terms at most.
//
// A component of a × b is added to the sum as soon as it is known, so that one is held at a time.
fn expansion_triple(
    terms: ptr<function, ExpansionTerms>, a: TwoTermsVector, b: TwoTermsVector, c: TwoTermsVector,
) -> F64 {
    var sum_len = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        let next = (axis + 1u) % 3u;
        let last = (axis + 2u) % 3u;
        var len = 0u;
        for (var place = 0u; place < 8u; place++) {
            let is_subtracted = place >= 4u;
            let of_left = select(next, last, is_subtracted);
            let of_right = select(last, next, is_subtracted);
            let first = (place >> 1u) & 1u;
            let second = place & 1u;
            if first < a[of_left].len && second < b[of_right].len {
                let factor = a[of_left].terms[first];
                let product = two_product(
                    select(factor, f64_negate(factor), is_subtracted), b[of_right].terms[second],
                );
                for (var half = 0u; half < 2u; half++) {
                    let term = select(product.low, product.high, half == 1u);
                    len = expansion_add(terms, EXPANSION_COMPONENT, len, term);
                }
            }
        }
        for (var place = 0u; place < 2u * len; place++) {
            let second = place & 1u;
            if second < c[axis].len {
                let product = two_product((*terms)[EXPANSION_COMPONENT + (place >> 1u)], c[axis].terms[second]);
                for (var half = 0u; half < 2u; half++) {
                    let term = select(product.low, product.high, half == 1u);
                    sum_len = expansion_add(terms, EXPANSION_SUM, sum_len, term);
                }
            }
        }
    }
    // As Rust's sums, which start from −0.
    var estimate = F64_NEGATIVE_ZERO;
    for (var place = 0u; place < sum_len; place++) {
        estimate = f64_add(estimate, (*terms)[EXPANSION_SUM + place]);
    }
    return estimate;
}
