// More than 53 bits: double-double numbers and Shewchuk's expansions, bit for bit as the Rust crate's `predicate::double`
// and `predicate::expansion`.

import package::exact::double::{
    F64, F64Terms, F64_ZERO, f64_abs, f64_add, f64_divide, f64_is_below_zero, f64_is_zero, f64_multiply, f64_negate,
    f64_subtract, two_product, two_sum,
};
import package::exact::vector::{F64Vector, f64_vector_turned};

// high + low, and the sum of the magnitudes of all added terms.
struct DoubleDouble {
    high: F64,
    low: F64,
    magnitude: F64,
}

const DOUBLE_ZERO = DoubleDouble(F64_ZERO, F64_ZERO, F64_ZERO);

fn double_from_terms(terms: F64Terms) -> DoubleDouble {
    return DoubleDouble(terms.high, terms.low, f64_abs(terms.high));
}

// dividend ÷ divisor, raised (high) and lowered (low) by the relative `error`, each rounded to an F64.
fn double_quotient(dividend: DoubleDouble, divisor: DoubleDouble, error: F64) -> F64Terms {
    let first = f64_divide(dividend.high, divisor.high);
    let factor = DoubleDouble(f64_negate(first), F64_ZERO, f64_abs(first));
    let rest = double_plus(dividend, double_times(divisor, factor));
    let second = f64_divide(rest.high, divisor.high);
    let margin = f64_multiply(f64_abs(first), error);
    return F64Terms(f64_add(first, f64_add(second, margin)), f64_add(first, f64_subtract(second, margin)));
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

// A vector whose components are sums of two terms that don't overlap.
struct TermsVector {
    x: F64Terms,
    y: F64Terms,
    z: F64Terms,
}

// A vector as such sums, with low terms of zero.
fn terms_from_vector(a: F64Vector) -> TermsVector {
    return TermsVector(F64Terms(a.x, F64_ZERO), F64Terms(a.y, F64_ZERO), F64Terms(a.z, F64_ZERO));
}

// a − b on each axis, exactly.
fn terms_difference(a: F64Vector, b: F64Vector) -> TermsVector {
    var left = a;
    var right = b;
    var difference: TermsVector;
    for (var axis = 0u; axis < 3u; axis++) {
        difference = TermsVector(difference.y, difference.z, two_sum(left.x, f64_negate(right.x)));
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
    }
    return difference;
}

// Rotates the axes: y first.
fn terms_turned(a: TermsVector) -> TermsVector {
    return TermsVector(a.y, a.z, a.x);
}

// (a × b) · c and (a × b) · d in double-double numbers.
struct DoubleTriples {
    with_c: DoubleDouble,
    with_d: DoubleDouble,
}

fn double_triples(a: TermsVector, b: TermsVector, c: TermsVector, d: TermsVector) -> DoubleTriples {
    var left = a;
    var right = b;
    var first = c;
    var second = d;
    // A sum that starts from zero has the bits of one that starts with its first term.
    var sums = DoubleTriples(DOUBLE_ZERO, DOUBLE_ZERO);
    for (var axis = 0u; axis < 3u; axis++) {
        // left.y · right.z − left.z · right.y, then its products with c and d. One loop for all four steps, since the
        // functions that it calls compile slowly.
        var component = DOUBLE_ZERO;
        for (var step = 0u; step < 4u; step++) {
            var factor = double_from_terms(left.y);
            var other = right.z;
            var sum = DOUBLE_ZERO;
            if step == 1u {
                factor = double_negated(double_from_terms(left.z));
                other = right.y;
                sum = component;
            } else if step == 2u {
                factor = component;
                other = first.x;
                sum = sums.with_c;
            } else if step == 3u {
                factor = component;
                other = second.x;
                sum = sums.with_d;
            }
            sum = double_plus(sum, double_times(factor, double_from_terms(other)));
            if step < 2u {
                component = sum;
            } else if step == 2u {
                sums.with_c = sum;
            } else {
                sums.with_d = sum;
            }
        }
        left = terms_turned(left);
        right = terms_turned(right);
        first = terms_turned(first);
        second = terms_turned(second);
    }
    return sums;
}

const EXPANSION_SUM = 0u;
const EXPANSION_COMPONENT = 192u;

// The two expansions of `expansion_triple`: at most 192 terms of the sum, and 16 of a component. Declare it only where
// the answer is known to be needed: WGSL clears it. Words are apart: that compiles in half the time (lavapipe).
struct ExpansionTerms {
    low: array<u32, 208>,
    high: array<u32, 208>,
}

fn expansion_term(terms: ptr<function, ExpansionTerms>, index: u32) -> F64 {
    return F64((*terms).low[index], (*terms).high[index]);
}

// Grow-Expansion, leaving out zeros, on the `len` terms from `start` on; returns the new number of terms.
fn expansion_add(terms: ptr<function, ExpansionTerms>, start: u32, len: u32, value: F64) -> u32 {
    var carry = value;
    var kept = start;
    // One turn more than the number of terms, for the last carry.
    for (var index = start; index <= start + len; index++) {
        let is_last = index == start + len;
        let sum = two_sum(carry, expansion_term(terms, index));
        let left = select(sum.low, carry, is_last);
        carry = sum.high;
        if !f64_is_zero(left) {
            (*terms).low[kept] = left.x;
            (*terms).high[kept] = left.y;
            kept++;
        }
    }
    return kept - start;
}

// Adds a · b to the `len` terms from `start` on, unless it is zero; returns the new number of terms.
fn expansion_add_product(terms: ptr<function, ExpansionTerms>, start: u32, len: u32, a: F64, b: F64) -> u32 {
    if f64_is_zero(a) || f64_is_zero(b) {
        return len;
    }
    let product = two_product(a, b);
    var grown = len;
    for (var half = 0u; half < 2u; half++) {
        grown = expansion_add(terms, start, grown, select(product.low, product.high, half == 1u));
    }
    return grown;
}

// (a × b) · c, rounded to two terms, with the exact sign: at most three products of 2 · 16 · 2 terms. Components of a ×
// b above zero are multiplied by `c_above`, the others by `c_below`.
//
// Each component of a × b is added to the sum at once, so that only one is held at a time.
fn expansion_triple(
    terms: ptr<function, ExpansionTerms>,
    a: TermsVector,
    b: TermsVector,
    c_above: TermsVector,
    c_below: TermsVector,
) -> F64Terms {
    var left = a;
    var right = b;
    var above = c_above;
    var below = c_below;
    var len = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        var component_len = 0u;
        // First the products that make up the component, then those of its terms and c. One loop for both, since the
        // functions that it calls compile slowly.
        for (var index = 0u; index < 8u + 2u * component_len; index++) {
            let is_component = index < 8u;
            // left.y · right.z − left.z · right.y. For each product, the terms of `left` one by one, and for each of
            // these the terms of `right`, the lower term first.
            let is_subtracted = (index & 4u) != 0u;
            let is_left_high = (index & 2u) != 0u;
            let is_right_high = (index & 1u) != 0u;
            let unsigned_factor = terms_pick(left.y, left.z, is_subtracted, is_left_high);
            var factor = select(unsigned_factor, f64_negate(unsigned_factor), is_subtracted);
            var other = terms_pick(right.z, right.y, is_subtracted, is_right_high);
            if !is_component {
                // The last term has the component's sign.
                let last = expansion_term(terms, EXPANSION_COMPONENT + component_len - 1u);
                factor = expansion_term(terms, EXPANSION_COMPONENT + ((index - 8u) >> 1u));
                other = terms_pick(above.x, below.x, f64_is_below_zero(last), is_right_high);
            }
            let start = select(EXPANSION_SUM, EXPANSION_COMPONENT, is_component);
            let grown = expansion_add_product(terms, start, select(len, component_len, is_component), factor, other);
            component_len = select(component_len, grown, is_component);
            len = select(grown, len, is_component);
        }
        left = terms_turned(left);
        right = terms_turned(right);
        above = terms_turned(above);
        below = terms_turned(below);
    }
    var rounded = F64Terms(F64_ZERO, F64_ZERO);
    for (var index = 0u; index < len; index++) {
        let sum = two_sum(rounded.high, expansion_term(terms, EXPANSION_SUM + index));
        rounded = F64Terms(sum.high, f64_add(rounded.low, sum.low));
    }
    return rounded;
}

fn terms_pick(first: F64Terms, second: F64Terms, is_second: bool, is_high: bool) -> F64 {
    return select(
        select(first.low, first.high, is_high), select(second.low, second.high, is_high), is_second,
    );
}
