// What shadows a point: bit for bit the Rust crate's `predicate::shadow`.

import package::exact::double::{
    F64, F64_NEGATIVE_ZERO, F64_SIGN, F64_ZERO, f64_abs, f64_add, f64_is_above_zero, f64_is_below_zero, f64_is_zero,
    f64_magnitude_less, f64_multiply, f64_subtract,
};
import package::exact::expansion::{ExpansionTerms, expansion_triple, terms_difference};
import package::exact::predicate::{
    CornerBits, EXACT_ROUNDINGS_64, EXACT_SMALLEST_TRUSTED_BOUND, ExactCorners, ExactEdges, ExactRay, exact_edges,
    exact_from_corners, exact_sorted,
};
import package::exact::vector::{
    F64Vector, f64_cross, f64_dot, f64_largest_magnitude, f64_vector_add, f64_vector_from_f32_bits, f64_vector_negate,
    f64_vector_scale, f64_vector_subtract, f64_vector_turned,
};

// A point that a ray has hit, with a bound on how far rounding may have moved it on any axis.
struct ExactPoint {
    position: F64Vector,
    error: F64,
}

// From a light to a point with t in (0, 1), or from a point to a light infinitely far away with t in (0, ∞).
struct ExactShadow {
    ray: ExactRay,
    point: ExactPoint,
    from_point: bool,
}

// Half the distance from one to the next F64, 2⁻⁵³, five and ten times.
const EXACT_ROUNDINGS_5 = F64(0u, 0x3cc40000u);
const EXACT_ROUNDINGS_10 = F64(0u, 0x3cd40000u);

// The point at distance `t` along `ray`, `t` being correct to about its last bit.
fn exact_point(ray: ExactRay, t: F64) -> ExactPoint {
    let step = f64_vector_scale(ray.direction, t);
    let position = f64_vector_add(ray.origin, step);
    let size = f64_add(f64_largest_magnitude(step), f64_largest_magnitude(position));
    return ExactPoint(position, f64_multiply(EXACT_ROUNDINGS_5, size));
}

// The segment between a light and a point. `light` has the bits of an f32 vector: the light's position, or for a
// directional one the direction in which it travels.
fn exact_shadow(is_directional: bool, light: vec3<u32>, point: ExactPoint) -> ExactShadow {
    let vector = f64_vector_from_f32_bits(light);
    if is_directional {
        return ExactShadow(ExactRay(point.position, f64_vector_negate(vector)), point, true);
    }
    return ExactShadow(ExactRay(vector, f64_vector_subtract(point.position, vector)), point, false);
}

// Whether a triangle shadows the point: whether the segment crosses it strictly between the light and the point, by more
// than the error bound of the point itself. Ask for other triangles than the one that the point is on.
//
// Where it does, `edges` is where the segment crosses it, for `exact_barycentric`.
fn exact_blocked_by(
    terms: ptr<function, ExpansionTerms>,
    shadow: ExactShadow,
    corners: CornerBits,
    edges: ptr<function, ExactEdges>,
) -> bool {
    let height = exact_height_above(exact_from_corners(exact_sorted(corners).corners), shadow.point);
    // Asked first, since it is cheap and the triangles around the point's own mostly end here.
    if f64_is_zero(height) {
        return false;
    }
    *edges = exact_edges(terms, shadow.ray, corners);
    if (*edges).side == 0 {
        return false;
    }
    let is_behind = ((*edges).side > 0) == (height.y < F64_SIGN);
    // From the point, the crossing has to be ahead of it.
    if shadow.from_point {
        return !is_behind;
    }
    return is_behind && exact_is_ahead(terms, shadow.ray, *edges);
}

// How far a point is from the plane of a triangle, in lengths of its unnormalised normal and towards it; zero where that
// is within the error of the point and of this evaluation.
fn exact_height_above(corners: ExactCorners, point: ExactPoint) -> F64 {
    let ab = f64_vector_subtract(corners.b, corners.a);
    let ac = f64_vector_subtract(corners.c, corners.a);
    var offset = f64_vector_subtract(point.position, corners.a);
    var left = ab;
    var right = ac;
    // Of one component of the normal after the other; sums that start from −0 start with their first term.
    var height = F64_NEGATIVE_ZERO;
    var bound = F64_NEGATIVE_ZERO;
    for (var axis = 0u; axis < 3u; axis++) {
        let forward = f64_multiply(left.y, right.z);
        let backward = f64_multiply(right.y, left.z);
        let magnitude = f64_add(f64_abs(forward), f64_abs(backward));
        let error = f64_add(f64_multiply(f64_abs(offset.x), EXACT_ROUNDINGS_10), point.error);
        height = f64_add(height, f64_multiply(f64_subtract(forward, backward), offset.x));
        bound = f64_add(bound, f64_multiply(magnitude, error));
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
        offset = f64_vector_turned(offset);
    }
    return select(F64_ZERO, height, f64_magnitude_less(bound, height));
}

// Whether the line meets the plane at t > 0, exactly.
fn exact_is_ahead(terms: ptr<function, ExpansionTerms>, ray: ExactRay, edges: ExactEdges) -> bool {
    let a = edges.corners.a;
    let ab = f64_vector_subtract(edges.corners.b, a);
    let ac = f64_vector_subtract(edges.corners.c, a);
    let towards = f64_vector_subtract(a, ray.origin);
    var height = f64_dot(f64_cross(ab, ac), towards);
    let reach_of_edges = f64_multiply(f64_largest_magnitude(ab), f64_largest_magnitude(ac));
    let reach = f64_multiply(reach_of_edges, f64_largest_magnitude(towards));
    let bound = f64_multiply(EXACT_ROUNDINGS_64, reach);
    if !f64_magnitude_less(bound, height) || f64_magnitude_less(bound, EXACT_SMALLEST_TRUSTED_BOUND) {
        height = expansion_triple(
            terms,
            terms_difference(edges.corners.b, a),
            terms_difference(edges.corners.c, a),
            terms_difference(a, ray.origin),
        );
    }
    return select(f64_is_below_zero(height), f64_is_above_zero(height), edges.side > 0);
}
