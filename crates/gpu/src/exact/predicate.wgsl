// The reference predicate: which triangles a ray meets, at which t, and from which side. Bit for bit the results of the
// Rust crate's `predicate`, with its order of operations.
//
// Corners are the bits of their f32 coordinates, since variables of type f32 may lose subnormal numbers.

import package::exact::double::{
    F64, f64_abs, f64_add, f64_divide, f64_equal, f64_exponent_field, f64_is_above_zero, f64_is_below_zero, f64_is_finite,
    f64_larger_magnitude, f64_magnitude_less, f64_multiply, f64_to_f32_bits,
};
import package::exact::expansion::{
    DoubleDouble, ExpansionTerms, TermsVector, double_from_terms, double_quotient, double_triples, expansion_triple,
    terms_difference, terms_from_vector,
};
import package::exact::vector::{
    F64Vector, f64_cross, f64_dot, f64_largest_magnitude, f64_vector_from_f32_bits, f64_vector_scale,
    f64_vector_subtract,
};

// origin + t · direction.
struct ExactRay {
    origin: F64Vector,
    direction: F64Vector,
}

// The bits of three corners' f32 coordinates.
struct CornerBits {
    a: vec3<u32>,
    b: vec3<u32>,
    c: vec3<u32>,
}

// The corners of a triangle as F64.
struct ExactCorners {
    a: F64Vector,
    b: F64Vector,
    c: F64Vector,
}

// Corners in canonical order: sorted by x, then y, then z.
struct SortedCorners {
    corners: CornerBits,
    // Index of each in the caller's list.
    indices: vec3<u32>,
}

// A triangle that a line meets, with its corners in canonical order: the result is bit for bit the same for any order
// of the caller's corners.
struct ExactEdges {
    // In canonical order.
    corners: ExactCorners,
    // Index of each of `corners` in the caller's list.
    indices: vec3<u32>,
    // Weights of `corners`, not yet divided by their sum.
    weights: F64Vector,
    // The common sign of the edge functions: 1 or −1; 0 if the line misses the triangle, and no other member is valid.
    side: i32,
}

// 64 times half the distance from one to the next F64: 2⁻⁴⁷.
const EXACT_ROUNDINGS_64 = F64(0u, 0x3d000000u);

// A double-double sum is precise enough if it is above 2⁻²⁶ of the magnitudes of its terms.
const EXACT_CANCELLATION = F64(0u, 0x3e500000u);

// Relative errors of quotients: 2⁻⁷⁰ of precise numbers, 2⁻¹⁰⁰ of numbers that were rounded to two terms.
const EXACT_PRECISION = F64(0u, 0x3b900000u);
const EXACT_ROUNDED = F64(0u, 0x39b00000u);

// 1e-250: below this an error bound may itself have lost bits to underflow.
const EXACT_SMALLEST_TRUSTED_BOUND = F64(0x5da2824cu, 0x0c06e93fu);

fn exact_from_corners(corners: CornerBits) -> ExactCorners {
    return ExactCorners(
        f64_vector_from_f32_bits(corners.a),
        f64_vector_from_f32_bits(corners.b),
        f64_vector_from_f32_bits(corners.c),
    );
}

fn exact_corner(corners: ExactCorners, index: u32) -> F64Vector {
    return F64Vector(
        select(select(corners.c.x, corners.b.x, index == 1u), corners.a.x, index == 0u),
        select(select(corners.c.y, corners.b.y, index == 1u), corners.a.y, index == 0u),
        select(select(corners.c.z, corners.b.z, index == 1u), corners.a.z, index == 0u),
    );
}

// Rotates the corners: the second first.
fn exact_corners_turned(corners: ExactCorners) -> ExactCorners {
    return ExactCorners(corners.b, corners.c, corners.a);
}

// The power of two that scales the largest component of `direction` to between one and two, so that products with it
// don't underflow; one if that power isn't a normal number.
fn exact_scale_to_one(direction: F64Vector) -> F64 {
    let field = f64_exponent_field(f64_largest_magnitude(direction));
    return F64(0u, select((2046u - field) << 20u, 0x3ff00000u, field == 0u || field >= 2046u));
}

// Whether `first` is after `second` when sorted by x, then y, then z; unspecified for NaN.
fn exact_is_after(first: vec3<u32>, second: vec3<u32>) -> bool {
    let x = vec2(exact_order(first.x), exact_order(second.x));
    let y = vec2(exact_order(first.y), exact_order(second.y));
    let z = vec2(exact_order(first.z), exact_order(second.z));
    return x.x > x.y || (x.x == x.y && (y.x > y.y || (y.x == y.y && z.x > z.y)));
}

// An integer in the order of the f32 with these bits; zeros of both signs have the same.
fn exact_order(bits: u32) -> i32 {
    let magnitude = i32(bits & 0x7fffffffu);
    return select(magnitude, -magnitude, bits >= 0x80000000u);
}

fn exact_sorted(corners: CornerBits) -> SortedCorners {
    var sorted = SortedCorners(corners, vec3(0u, 1u, 2u));
    for (var step = 0u; step < 3u; step++) {
        let bits = sorted.corners;
        let indices = sorted.indices;
        // The first two, the last two, and the first two again.
        if step == 1u {
            if exact_is_after(bits.b, bits.c) {
                sorted = SortedCorners(CornerBits(bits.a, bits.c, bits.b), indices.xzy);
            }
        } else if exact_is_after(bits.a, bits.b) {
            sorted = SortedCorners(CornerBits(bits.b, bits.a, bits.c), indices.yxz);
        }
    }
    return sorted;
}

// Intersects the line through `ray` with a triangle.
fn exact_edges(terms: ptr<function, ExpansionTerms>, ray: ExactRay, corners: CornerBits) -> ExactEdges {
    let sorted = exact_sorted(corners);
    var edges: ExactEdges;
    edges.indices = sorted.indices;
    edges.corners = exact_from_corners(sorted.corners);
    var relative = ExactCorners(
        f64_vector_subtract(edges.corners.a, ray.origin),
        f64_vector_subtract(edges.corners.b, ray.origin),
        f64_vector_subtract(edges.corners.c, ray.origin),
    );
    let reach = f64_larger_magnitude(
        f64_largest_magnitude(relative.a),
        f64_larger_magnitude(f64_largest_magnitude(relative.b), f64_largest_magnitude(relative.c)),
    );
    let largest_product = f64_multiply(EXACT_ROUNDINGS_64, f64_largest_magnitude(ray.direction));
    let bound = f64_multiply(f64_multiply(largest_product, reach), reach);
    let is_trusted = !f64_magnitude_less(bound, EXACT_SMALLEST_TRUSTED_BOUND);

    var undecided = vec3(false);
    var positive = false;
    var negative = false;
    var finite = true;
    // Each corner's weight, from the edge opposite to it.
    for (var corner = 0u; corner < 3u; corner++) {
        let weight = f64_dot(ray.direction, f64_cross(relative.b, relative.c));
        let decided = f64_magnitude_less(bound, weight) && is_trusted;
        positive |= decided && f64_is_above_zero(weight);
        negative |= decided && f64_is_below_zero(weight);
        finite &= f64_is_finite(weight);
        edges.weights = F64Vector(edges.weights.y, edges.weights.z, weight);
        undecided = vec3(undecided.yz, !decided);
        relative = exact_corners_turned(relative);
    }
    if (positive && negative) || !finite {
        return edges;
    }
    if any(undecided) {
        // All weights get the scale of the exact ones, so that their ratios are right. Decided weights are far above
        // the smallest number, so a power of two changes none of their bits.
        let scale = exact_scale_to_one(ray.direction);
        edges.weights = f64_vector_scale(edges.weights, scale);
        let direction = terms_from_vector(f64_vector_scale(ray.direction, scale));
        while any(undecided) && !(positive && negative) {
            // Each invocation takes its first undecided corner, so that its neighbours needn't wait.
            let corner = select(select(2u, 1u, undecided.y), 0u, undecided.x);
            undecided &= vec3(0u, 1u, 2u) != vec3(corner);
            // d · ((p − o) × (q − o)) to within one rounding, with the exact sign.
            let p = terms_difference(exact_corner(edges.corners, (corner + 1u) % 3u), ray.origin);
            let q = terms_difference(exact_corner(edges.corners, (corner + 2u) % 3u), ray.origin);
            let weight = expansion_triple(terms, p, q, direction, direction).high;
            positive |= f64_is_above_zero(weight);
            negative |= f64_is_below_zero(weight);
            edges.weights = F64Vector(
                select(edges.weights.x, weight, corner == 0u),
                select(edges.weights.y, weight, corner == 1u),
                select(edges.weights.z, weight, corner == 2u),
            );
        }
    }
    edges.side = i32(positive) - i32(negative);
    return edges;
}

// t, rounded to the nearest F64: n · (A − o) over n · d for the unnormalised normal n.
//
// In double-double arithmetic if that is precise enough, else exactly. A quotient within 2⁻⁴⁵ units in the last place
// of the middle between two F64 goes to the even one.
fn exact_t(terms: ptr<function, ExpansionTerms>, ray: ExactRay, edges: ExactEdges) -> F64 {
    let a = edges.corners.a;
    let ab = terms_difference(edges.corners.b, a);
    let ac = terms_difference(edges.corners.c, a);
    var towards = terms_difference(a, ray.origin);
    let triples = double_triples(ab, ac, towards, terms_from_vector(ray.direction));
    var height = triples.with_c;
    var slope = triples.with_d;
    let is_precise = exact_is_precise(slope) && exact_is_precise(height);
    let scale = exact_scale_to_one(ray.direction);
    var error = EXACT_PRECISION;
    var t: F64;
    // At most a second turn, with the exact height and slope.
    for (var turn = 0u; turn < 2u; turn++) {
        let quotient = double_quotient(height, slope, error);
        if turn == 1u {
            let is_even = (quotient.low.x & 1u) == 0u;
            t = f64_multiply(select(quotient.high, quotient.low, is_even), scale);
            break;
        }
        if is_precise && f64_equal(quotient.low, quotient.high) {
            t = quotient.low;
            break;
        }
        for (var vector = 0u; vector < 2u; vector++) {
            height = slope;
            slope = double_from_terms(expansion_triple(terms, ab, ac, towards, towards));
            towards = terms_from_vector(f64_vector_scale(ray.direction, scale));
        }
        error = EXACT_ROUNDED;
    }
    return t;
}

fn exact_is_precise(a: DoubleDouble) -> bool {
    return f64_magnitude_less(f64_multiply(EXACT_CANCELLATION, a.magnitude), a.high)
        && !f64_magnitude_less(a.magnitude, EXACT_SMALLEST_TRUSTED_BOUND);
}

// Bits of the f32 weights of the caller's second and third corners.
fn exact_barycentric(edges: ExactEdges) -> vec2<u32> {
    let first = exact_weight_of(edges, 0u);
    let second = exact_weight_of(edges, 1u);
    let third = exact_weight_of(edges, 2u);
    let sum = f64_add(f64_add(first, second), third);
    return vec2(f64_to_f32_bits(f64_divide(second, sum)), f64_to_f32_bits(f64_divide(third, sum)));
}

// Magnitude of the weight of one of the caller's corners.
fn exact_weight_of(edges: ExactEdges, index: u32) -> F64 {
    let first_or_second = select(edges.weights.x, edges.weights.y, edges.indices.y == index);
    return f64_abs(select(first_or_second, edges.weights.z, edges.indices.z == index));
}

// Whether the ray comes from the side from which the corners are seen counterclockwise.
fn exact_is_front(edges: ExactEdges) -> bool {
    let is_even = edges.indices.y == (edges.indices.x + 1u) % 3u;
    return (edges.side < 0) == is_even;
}

// Whether rays of a `direction` meet a triangle on the side from which its corners are seen counterclockwise; false where
// they only graze it. Where they hit it, this is `exact_is_front`.
fn exact_is_front_along(terms: ptr<function, ExpansionTerms>, direction: F64Vector, corners: CornerBits) -> bool {
    let scaled = f64_vector_scale(direction, exact_scale_to_one(direction));
    return exact_is_against_normal(terms, exact_from_corners(corners), terms_from_vector(scaled));
}

// Whether a triangle's corners are seen counterclockwise from a `point`; false where that is in the triangle's plane.
fn exact_is_front_from(terms: ptr<function, ExpansionTerms>, point: F64Vector, corners: CornerBits) -> bool {
    let exact = exact_from_corners(corners);
    return exact_is_against_normal(terms, exact, terms_difference(exact.a, point));
}

// Whether n · v is below zero for the unnormalised normal n of a triangle and a vector v.
fn exact_is_against_normal(terms: ptr<function, ExpansionTerms>, corners: ExactCorners, vector: TermsVector) -> bool {
    let ab = terms_difference(corners.b, corners.a);
    let ac = terms_difference(corners.c, corners.a);
    let product = double_triples(ab, ac, vector, vector).with_c;
    if exact_is_precise(product) {
        return f64_is_below_zero(product.high);
    }
    return f64_is_below_zero(expansion_triple(terms, ab, ac, vector, vector).high);
}
