// Whether a triangle shadows a point: bit for bit the Rust crate's `predicate::shadow`.

import package::exact::double::{
    F64, F64_ZERO, f64_abs, f64_add, f64_is_above_zero, f64_is_below_zero, f64_larger_magnitude, f64_less,
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

// A point that a ray has hit, with a bound on its rounding error on any axis: the exact hit is in the box from
// `position − error` to `position + error`, both as F64.
struct ExactPoint {
    position: F64Vector,
    error: F64,
}

// The ray from a light to a point, with t in (0, 1), or from a point to a directional light, with t in (0, ∞).
struct ExactShadow {
    ray: ExactRay,
    point: ExactPoint,
    from_point: bool,
}

// Four and twenty times 2⁻⁵³, half the distance from one to the next F64.
const EXACT_ROUNDINGS_4 = F64(0u, 0x3cc00000u);
const EXACT_ROUNDINGS_20 = F64(0u, 0x3ce40000u);

// 2³⁰⁰. Coordinates of points may have bits far below those of corners: products of scaled coordinates keep them all.
const EXACT_SCALE = F64(0u, 0x52b00000u);

// The point at distance `t` along `ray`, `t` being correct to its last bit.
fn exact_point(ray: ExactRay, t: F64) -> ExactPoint {
    let step = f64_vector_scale(ray.direction, t);
    let position = f64_vector_add(ray.origin, step);
    let size = f64_add(f64_largest_magnitude(step), f64_largest_magnitude(position));
    return ExactPoint(position, f64_multiply(EXACT_ROUNDINGS_4, size));
}

// The segment between a light and a point. `light` has the bits of an f32 vector: the light's position, or a
// directional light's direction of travel.
fn exact_shadow(is_directional: bool, light: vec3<u32>, point: ExactPoint) -> ExactShadow {
    let vector = f64_vector_from_f32_bits(light);
    if is_directional {
        return ExactShadow(ExactRay(point.position, f64_vector_negate(vector)), point, true);
    }
    return ExactShadow(ExactRay(vector, f64_vector_subtract(point.position, vector)), point, false);
}

// Whether a triangle shadows the point: the segment's line meets the triangle, the light is strictly on one side of its
// plane, and the point's whole box strictly on the other. Not for the point's own triangle.
//
// If so, `edges` is the crossing, for `exact_barycentric`.
fn exact_blocked_by(
    terms: ptr<function, ExpansionTerms>,
    shadow: ExactShadow,
    corners: CornerBits,
    edges: ptr<function, ExactEdges>,
) -> bool {
    let side = exact_side_of(terms, exact_from_corners(exact_sorted(corners).corners), shadow.point);
    // Tested first, since it is cheap and rejects most triangles around the point's own.
    if side == 0 {
        return false;
    }
    *edges = exact_edges(terms, shadow.ray, corners);
    if (*edges).side == 0 {
        return false;
    }
    let is_behind = (*edges).side == side;
    // From the point, the crossing has to be ahead of it.
    if shadow.from_point {
        return !is_behind;
    }
    return is_behind && exact_is_ahead(terms, shadow.ray, *edges);
}

// Whether the plane of a triangle meets a point's box: rays that start at the point pass through the triangle.
fn exact_is_on(terms: ptr<function, ExpansionTerms>, point: ExactPoint, corners: CornerBits) -> bool {
    return exact_side_of(terms, exact_from_corners(exact_sorted(corners).corners), point) == 0;
}

// The side of a triangle's plane that a point's whole box is on: 1 where the normal points, else −1, and 0 if the plane
// meets the box or the triangle has no plane.
fn exact_side_of(terms: ptr<function, ExpansionTerms>, corners: ExactCorners, point: ExactPoint) -> i32 {
    let error = F64Vector(point.error, point.error, point.error);
    let low_corner = f64_vector_subtract(point.position, error);
    let high_corner = f64_vector_add(point.position, error);
    let ab = f64_vector_subtract(corners.b, corners.a);
    let ac = f64_vector_subtract(corners.c, corners.a);
    var low = f64_vector_subtract(low_corner, corners.a);
    var high = f64_vector_subtract(high_corner, corners.a);
    var left = ab;
    var right = ac;
    // Adds one component of the normal after the other. The bound has eight roundings of the terms, and as many for a
    // component with the wrong sign, which takes the other end of the box.
    var lowest = F64_ZERO;
    var highest = F64_ZERO;
    var bound = F64_ZERO;
    for (var axis = 0u; axis < 3u; axis++) {
        let forward = f64_multiply(left.y, right.z);
        let backward = f64_multiply(right.y, left.z);
        let component = f64_subtract(forward, backward);
        let magnitude = f64_add(f64_abs(forward), f64_abs(backward));
        let of_low = f64_multiply(component, low.x);
        let of_high = f64_multiply(component, high.x);
        let is_along = f64_less(of_low, of_high);
        lowest = f64_add(lowest, select(of_high, of_low, is_along));
        highest = f64_add(highest, select(of_low, of_high, is_along));
        bound = f64_add(bound, f64_multiply(magnitude, f64_larger_magnitude(low.x, high.x)));
        left = f64_vector_turned(left);
        right = f64_vector_turned(right);
        low = f64_vector_turned(low);
        high = f64_vector_turned(high);
    }
    bound = f64_multiply(bound, EXACT_ROUNDINGS_20);
    let is_trusted = !f64_magnitude_less(bound, EXACT_SMALLEST_TRUSTED_BOUND);
    let is_lowest_clear = is_trusted && f64_magnitude_less(bound, lowest);
    let is_highest_clear = is_trusted && f64_magnitude_less(bound, highest);
    if is_lowest_clear && f64_is_above_zero(lowest) {
        return 1;
    }
    if is_highest_clear && f64_is_below_zero(highest) {
        return -1;
    }
    if is_lowest_clear && is_highest_clear {
        return 0;
    }
    let a = f64_vector_scale(corners.a, EXACT_SCALE);
    var above = terms_difference(f64_vector_scale(low_corner, EXACT_SCALE), a);
    var below = terms_difference(f64_vector_scale(high_corner, EXACT_SCALE), a);
    var side = 0;
    for (var end = 0u; end < 2u && side == 0; end++) {
        let height = expansion_triple(
            terms, terms_difference(corners.b, corners.a), terms_difference(corners.c, corners.a), above, below,
        ).high;
        // Of the lowest corner, then of the highest.
        side = select(-i32(f64_is_below_zero(height)), i32(f64_is_above_zero(height)), end == 0u);
        let turned = above;
        above = below;
        below = turned;
    }
    return side;
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
        let towards_light = terms_difference(a, ray.origin);
        height = expansion_triple(
            terms,
            terms_difference(edges.corners.b, a),
            terms_difference(edges.corners.c, a),
            towards_light,
            towards_light,
        ).high;
    }
    return select(f64_is_below_zero(height), f64_is_above_zero(height), edges.side > 0);
}
