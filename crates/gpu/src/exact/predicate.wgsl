// The reference predicate: which triangles a ray meets, where, and what shadows a point. Bit for bit what the Rust
// crate's `predicate` says, and in its order.
//
// Corners come as the bits of their f32 coordinates: what holds an f32 may lose subnormal numbers.

import package::exact::double::{F64, f64_add, f64_multiply, f64_divide, f64_less, f64_maximum, f64_to_f32_bits};
import package::exact::expansion::{DoubleDouble, DoubleDoubleVector, TwoTermsVector, ExpansionTerms, expansion_triple};
import package::exact::vector::{F64Vector, f64_dot, f64_cross, f64_vector_subtract, f64_largest_magnitude};

// origin + t · direction.
struct ExactRay {
    origin: F64Vector,
    direction: F64Vector,
}

// The bits of three corners' f32 coordinates.
alias CornerBits = array<vec3<u32>, 3>;

// The corners of a triangle as F64.
alias ExactCorners = array<F64Vector, 3>;

// A triangle that a line meets, with its corners in canonical order: a triangle gives bit for bit the same result however
// its corners are listed.
struct ExactEdges {
    // In canonical order.
    corners: ExactCorners,
    // Where each of `corners` stands in the caller's list.
    places: vec3<u32>,
    // Weights of `corners`, not yet divided by their sum.
    weights: F64Vector,
    // The common sign of the edge functions: 1 or −1; 0 where the line misses the triangle and nothing else is of use.
    side: i32,
}

// 64 times half the distance from one to the next F64: 2⁻⁴⁷.
const EXACT_ROUNDINGS_64 = F64(0u, 0x3d000000u);

// 2⁻⁴⁰ of the terms left over from a double-double sum is precise enough.
const EXACT_CANCELLATION = F64(0u, 0x3d700000u);

// 1e-250: below this an error bound may itself have lost bits to underflow.
const EXACT_SMALLEST_TRUSTED_BOUND = F64(0x5da2824cu, 0x0c06e93fu);

fn exact_from_corners(corners: CornerBits) -> ExactCorners {
    var exact: ExactCorners;
    for (var corner = 0u; corner < 3u; corner++) {
        for (var axis = 0u; axis < 3u; axis++) {
            exact[corner][axis] = f64_from_f32_bits(corners[corner][axis]);
        }
    }
    return exact;
}

// `direction` with its largest component between one and two, so that products with it don't underflow.
fn exact_scaled(direction: F64Vector) -> F64Vector {
    let field = f64_exponent_field(f64_largest_magnitude(direction));
    if field == 0u || field == 0x7ffu {
        return direction;
    }
    return f64_vector_scale(direction, F64(0u, (2046u - field) << 20u));
}

// Whether `first` is after `second` when sorted by x, then y, then z. What it says of NaN is of no use.
fn exact_is_after(first: vec3<u32>, second: vec3<u32>) -> bool {
    for (var axis = 0u; axis < 3u; axis++) {
        let of_first = exact_order(first[axis]);
        let of_second = exact_order(second[axis]);
        if of_first != of_second {
            return of_first > of_second;
        }
    }
    return false;
}

// A number that is ordered as the f32 with these bits; zeros of both signs have the same.
fn exact_order(bits: u32) -> i32 {
    let magnitude = i32(bits & 0x7fffffffu);
    return select(magnitude, -magnitude, bits >= 0x80000000u);
}

// The places of the corners, sorted by x, then y, then z.
fn exact_canonical_order(corners: CornerBits) -> vec3<u32> {
    var places = vec3(0u, 1u, 2u);
    for (var step = 0u; step < 3u; step++) {
        let at = step & 1u;
        let first = places[at];
        let second = places[at + 1u];
        if exact_is_after(corners[first], corners[second]) {
            places[at] = second;
            places[at + 1u] = first;
        }
    }
    return places;
}

fn exact_reordered(corners: CornerBits, places: vec3<u32>) -> CornerBits {
    return CornerBits(corners[places.x], corners[places.y], corners[places.z]);
}

// The line through `ray` and a triangle.
fn exact_edges(terms: ptr<function, ExpansionTerms>, ray: ExactRay, corners: CornerBits) -> ExactEdges {
    var edges: ExactEdges;
    edges.places = exact_canonical_order(corners);
    edges.corners = exact_from_corners(exact_reordered(corners, edges.places));
    var relative: ExactCorners;
    var reach = F64_ZERO;
    for (var corner = 0u; corner < 3u; corner++) {
        relative[corner] = f64_vector_subtract(edges.corners[corner], ray.origin);
        reach = f64_maximum(f64_largest_magnitude(relative[corner]), reach);
    }

    var bound = f64_multiply(EXACT_ROUNDINGS_64, f64_largest_magnitude(ray.direction));
    for (var factor = 0u; factor < 2u; factor++) {
        bound = f64_multiply(bound, reach);
    }

    var undecided = vec3(false);
    var positive = false;
    var negative = false;
    var finite = true;
    for (var opposite = 0u; opposite < 3u; opposite++) {
        let first = (opposite + 1u) % 3u;
        let second = (opposite + 2u) % 3u;
        let weight = f64_dot(ray.direction, f64_cross(relative[first], relative[second]));
        edges.weights[opposite] = weight;
        undecided[opposite] = !f64_less(bound, f64_abs(weight)) || f64_less(bound, EXACT_SMALLEST_TRUSTED_BOUND);
        positive |= !undecided[opposite] && f64_less(F64_ZERO, weight);
        negative |= !undecided[opposite] && f64_less(weight, F64_ZERO);
        finite &= f64_is_finite(weight);
    }
    if (positive && negative) || !finite {
        return edges;
    }
    if any(undecided) {
        let direction = expansion_vector(exact_scaled(ray.direction));
        for (var opposite = 0u; opposite < 3u; opposite++) {
            if undecided[opposite] {
                // d · ((p − o) × (q − o)) to within one rounding, with the exact sign.
                let p = expansion_vector_difference(edges.corners[(opposite + 1u) % 3u], ray.origin);
                let q = expansion_vector_difference(edges.corners[(opposite + 2u) % 3u], ray.origin);
                let weight = expansion_triple(terms, p, q, direction);
                edges.weights[opposite] = weight;
                positive |= f64_less(F64_ZERO, weight);
                negative |= f64_less(weight, F64_ZERO);
                if positive && negative {
                    return edges;
                }
            }
        }
    }
    edges.side = i32(positive) - i32(negative);
    return edges;
}

// n · d and n · (A − o) for the unnormalised normal n: t is the second over the first.
//
// In double-double arithmetic where that is exact enough to give t its last bit, else exactly.
fn exact_t(terms: ptr<function, ExpansionTerms>, ray: ExactRay, edges: ExactEdges) -> F64 {
    let a = edges.corners[0];
    let b = edges.corners[1];
    let c = edges.corners[2];
    let normal = double_cross(double_difference(b, a), double_difference(c, a));
    let slope = double_dot(normal, double_from_vector(ray.direction));
    let height = double_dot(normal, double_difference(a, ray.origin));
    if exact_is_precise(slope) && exact_is_precise(height) {
        return double_quotient(height, slope);
    }
    let ab = expansion_vector_difference(b, a);
    let ac = expansion_vector_difference(c, a);
    let exact_height = expansion_triple(terms, ab, ac, expansion_vector_difference(a, ray.origin));
    return f64_divide(exact_height, expansion_triple(terms, ab, ac, expansion_vector(ray.direction)));
}

fn exact_is_precise(a: DoubleDouble) -> bool {
    return f64_less(f64_multiply(EXACT_CANCELLATION, a.magnitude), f64_abs(a.high));
}

// The bits of the f32 weights of the second and third of the corners as the caller listed them.
fn exact_barycentric(edges: ExactEdges) -> vec2<u32> {
    var of_caller: F64Vector;
    for (var corner = 0u; corner < 3u; corner++) {
        of_caller[edges.places[corner]] = f64_abs(edges.weights[corner]);
    }
    var sum = of_caller[0];
    for (var corner = 1u; corner < 3u; corner++) {
        sum = f64_add(sum, of_caller[corner]);
    }
    var barycentric: vec2<u32>;
    for (var corner = 0u; corner < 2u; corner++) {
        barycentric[corner] = f64_to_f32_bits(f64_divide(of_caller[corner + 1u], sum));
    }
    return barycentric;
}

// Whether the ray comes from the side from which the corners are seen counterclockwise.
fn exact_is_front(edges: ExactEdges) -> bool {
    let is_even = edges.places.y == (edges.places.x + 1u) % 3u;
    return (edges.side < 0) == is_even;
}

// Whether rays of a `direction` meet a triangle on the side from which its corners are seen counterclockwise; false where
// they only graze it. Where they hit it, this is `exact_is_front`.
fn exact_is_front_along(terms: ptr<function, ExpansionTerms>, direction: F64Vector, corners: CornerBits) -> bool {
    let scaled = exact_scaled(direction);
    let exact = exact_from_corners(corners);
    return exact_is_against_normal(terms, exact, double_from_vector(scaled), expansion_vector(scaled));
}

// Whether a triangle's corners are seen counterclockwise from a `point`; false where that is in the triangle's plane.
fn exact_is_front_from(terms: ptr<function, ExpansionTerms>, point: F64Vector, corners: CornerBits) -> bool {
    let exact = exact_from_corners(corners);
    return exact_is_against_normal(
        terms, exact, double_difference(exact[0], point), expansion_vector_difference(exact[0], point),
    );
}

// Whether n · v is below zero for the unnormalised normal n of a triangle and a vector v, given in two forms.
fn exact_is_against_normal(
    terms: ptr<function, ExpansionTerms>, corners: ExactCorners, vector: DoubleDoubleVector, exact: TwoTermsVector,
) -> bool {
    let a = corners[0];
    let b = corners[1];
    let c = corners[2];
    let product = double_dot(double_cross(double_difference(b, a), double_difference(c, a)), vector);
    if exact_is_precise(product) {
        return f64_less(product.high, F64_ZERO);
    }
    let ab = expansion_vector_difference(b, a);
    let ac = expansion_vector_difference(c, a);
    return f64_less(expansion_triple(terms, ab, ac, exact), F64_ZERO);
}
