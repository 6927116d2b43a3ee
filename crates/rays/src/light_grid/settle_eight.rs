use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};
use glam::DVec3;

use super::face::ROUNDING;
use super::point_set::PointSet;
use crate::shot::{EightTriangles, cross};
use crate::simd::vectors::{Vectors, dot, largest, minus, splat_vector};
use crate::{LightSource, Triangles};

/// Results in f64 for eight pairs of a point and a triangle, a bit for each.
pub(crate) struct Settled {
    /// The pairs in which the triangle shadows the point.
    pub(crate) shadowed: u64,
    /// The pairs left to the predicate.
    pub(crate) undecided: u64,
    /// Weights of the second and third corner where a triangle shadows a point.
    pub(crate) barycentric: [[f64; 8]; 2],
    /// The largest difference of each weight from the predicate's.
    pub(crate) weight_error: [f64; 8],
}

/// The largest error of a determinant of three vectors, in relation to four times the product of their largest components:
/// one rounding of each of two vectors, and five of products and sums, in each of its six products. That is 42; in heights a
/// vector is the difference of two, one of which has a rounding of its own: four more, of that.
const ROUNDED: f64 = 11.6 * ROUNDING;

/// Where the errors of edge functions are above this, underflow of products doesn't matter.
///
/// Lengths are below 1e40, so an edge function loses less than 1e-280. Corners that aren't the same are at least 1e-45
/// apart, so the normal loses nothing, and a height less than 1e-320, whose error follows to be above 1e-290.
const SMALLEST_ERROR: f64 = 1e-200;

/// Settles in f64 whether triangles shadow the points at `indices`, as
/// [`ShadowRay::blocked_by`](crate::predicate::ShadowRay::blocked_by) would.
///
/// With d the direction of the segment's line, c the corners in relation to a point on it, and r their largest
/// components, the edge functions d · (cⱼ × cₖ) are wrong by 4 rⱼ rₖ |Δd| for the direction, since no determinant of
/// numbers up to one is above four; by 4 |d| e |cⱼ − cₖ| where the point is moved by at most e on any axis; and by
/// [`ROUNDED`].
#[inline(always)]
pub(crate) fn settle_eight<S: Simd>(
    simd: S,
    triangles: Triangles<'_>,
    points: &PointSet<'_>,
    light: &LightSource,
    indices: [u32; 8],
    ids: [u32; 8],
) -> Settled {
    let (origin, direction) = match *light {
        LightSource::Point { position } | LightSource::Spot { position, .. } => (position.as_dvec3(), None),
        LightSource::Directional { direction } => (DVec3::ZERO, Some(-direction.as_dvec3())),
    };
    let points = points.eight(simd, indices, origin);
    let [a, b, c] = EightTriangles::load(simd, triangles, ids).corners;
    let zero = f64x8::splat(simd, 0.0);
    let error = points.error;

    // The segment's line through the light, or through the point.
    let (along, corners, along_error, corner_error) = match direction {
        None => {
            let light = splat_vector(simd, origin);
            (points.offset, [minus(a, light), minus(b, light), minus(c, light)], error, zero)
        }
        Some(direction) => {
            let point = points.offset;
            (splat_vector(simd, direction), [minus(a, point), minus(b, point), minus(c, point)], zero, error)
        }
    };
    let reach = [largest(corners[0]), largest(corners[1]), largest(corners[2])];
    let length = largest(along);
    let (e0, error0) = edge(along, length, along_error, corner_error, [corners[1], corners[2]], [reach[1], reach[2]]);
    let (e1, error1) = edge(along, length, along_error, corner_error, [corners[2], corners[0]], [reach[2], reach[0]]);
    let (e2, error2) = edge(along, length, along_error, corner_error, [corners[0], corners[1]], [reach[0], reach[1]]);
    let positive = [e0.simd_gt(error0), e1.simd_gt(error1), e2.simd_gt(error2)];
    let negative = [(-e0).simd_gt(error0), (-e1).simd_gt(error1), (-e2).simd_gt(error2)];
    let missed = (positive[0] | positive[1] | positive[2]) & (negative[0] | negative[1] | negative[2]);
    let hit_from_front = positive[0] & positive[1] & positive[2];
    let hit_from_behind = negative[0] & negative[1] & negative[2];
    let side_is_certain = hit_from_front | hit_from_behind;
    let side = hit_from_front.select(f64x8::splat(simd, 1.0), f64x8::splat(simd, -1.0));

    // The heights of the point and of the light over the triangle's plane.
    let (ab, ac) = (minus(b, a), minus(c, a));
    let (normal, _) = cross(ab, ac);
    let size = largest(ab) * largest(ac) * 4.0;
    let point_from_a = match direction {
        None => minus(points.offset, corners[0]),
        Some(_) => minus(points.offset, a),
    };
    let height = dot(normal, point_from_a) * side;
    // The error of the whole box that the predicate takes for the point.
    let height_error = size * (error + (largest(point_from_a) + reach[0]) * ROUNDED);
    let (towards_point, light_is_beyond, light_is_before) = match direction {
        None => {
            let height_of_light = dot(normal, corners[0]) * side;
            let error = size * reach[0] * ROUNDED;
            (height, height_of_light.simd_gt(error), (-height_of_light).simd_gt(error))
        }
        Some(_) => (-height, mask64x8::splat(simd, true), mask64x8::splat(simd, false)),
    };
    let behind = towards_point.simd_gt(height_error);
    let not_behind = (-towards_point).simd_gt(height_error);
    let shadowed = side_is_certain & behind & light_is_beyond;
    let lit = missed | (side_is_certain & (not_behind | light_is_before));
    // Sizes whose products could underflow have no bound. None can overflow: corners are f32, and so are points, nearly.
    let trusted = points.certain & error0.min(error1).min(error2).simd_gt(f64x8::splat(simd, SMALLEST_ERROR));
    let (shadowed, lit) = ((trusted & shadowed).to_bitmask(), (trusted & lit).to_bitmask());

    // Each weight is its edge function over the sum of all. With e the largest error of one, and none below zero, it is
    // wrong by at most 2 e over that sum. The predicate's have roundings of their own, fewer than are in e.
    let inverse = f64x8::splat(simd, 1.0) / (e0 + e1 + e2);
    let weight_error = largest([error0, error1, error2]) * inverse.abs() * 4.01;
    Settled {
        shadowed,
        undecided: !(shadowed | lit) & 0xff,
        barycentric: [(e1 * inverse).to_array(), (e2 * inverse).to_array()],
        weight_error: weight_error.to_array(),
    }
}

/// d · (p × q) and its error.
#[inline(always)]
fn edge<S: Simd>(
    along: Vectors<S>,
    length: f64x8<S>,
    along_error: f64x8<S>,
    corner_error: f64x8<S>,
    [p, q]: [Vectors<S>; 2],
    [p_reach, q_reach]: [f64x8<S>; 2],
) -> (f64x8<S>, f64x8<S>) {
    let (normal, _) = cross(p, q);
    let product = p_reach * q_reach;
    let of_corners = length * corner_error * (p_reach + q_reach);
    let error = (product * (along_error + length * ROUNDED) + of_corners) * 4.04;
    (dot(along, normal), error)
}
