use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};
use glam::DVec3;

use super::face::{Face, LARGEST_POINT_ERROR, POINT_LIMIT, ROUNDING};
use super::point_set::PointSet;
use crate::simd::vectors::{Vectors, dot, largest, splat_vector};

/// Maps eight points to a face; an image's points come from the planes of their triangles.
#[inline(always)]
pub(crate) fn refine_eight<S: Simd>(simd: S, points: &PointSet<'_>, face: &Face, indices: [u32; 8]) -> Refined {
    let known = indices.map(|index| points.is_known(index as usize));
    let known = known.into_iter().enumerate().fold(0, |mask, (lane, known)| mask | u64::from(known) << lane);
    let points = points.eight(simd, indices, face.origin);
    let v = points.offset;
    let (at, inverse) = face.project(simd, v);
    // Products and sums of the map have three roundings, and the division two.
    let error = points.error + largest(v) * (6.0 * ROUNDING);
    let norms = face.norms();
    let (position_error, nearness_error) = if face.is_parallel {
        (error * norms.x.max(norms.y), error * norms.z)
    } else {
        // X moves by (x − X z) · dv / (p.z + z · dv). As x is at least 1 / 1.6 long, and X moves by at most
        // `LARGEST_POINT_ERROR`, z · dv is less than a thousandth of p.z: errors have more than that to spare.
        let relative = error * inverse;
        let reach = at[0].abs().max(at[1].abs());
        ((reach * norms.z + norms.x.max(norms.y)) * relative, at[2] * relative * norms.z)
    };
    let limit = f64x8::splat(simd, POINT_LIMIT);
    // Excludes points whose error leaves W without meaning.
    let depth_is_certain = (error * inverse * norms.z).simd_lt(f64x8::splat(simd, 1.0 / 16.0));
    let exact = points.certain
        & depth_is_certain
        & at[0].abs().simd_le(limit)
        & at[1].abs().simd_le(limit)
        & inverse.simd_gt(f64x8::splat(simd, 0.0))
        & at[2].abs().simd_lt(f64x8::splat(simd, 1e15))
        & (points.predicate_error * inverse).simd_le(f64x8::splat(simd, face.point_error))
        & position_error.simd_le(f64x8::splat(simd, LARGEST_POINT_ERROR));
    let members = known & !is_elsewhere(simd, face, v, error, points.certain).to_bitmask();
    let exact = exact.to_bitmask();
    Refined {
        at: [at[0].to_array(), at[1].to_array(), at[2].to_array()],
        errors: [position_error.to_array(), nearness_error.to_array()],
        members,
        exact,
    }
}

/// Mask of the vectors from the light, among eight, that certainly belong to other faces. `error` counts the roundings of
/// products and sums.
#[inline(always)]
fn is_elsewhere<S: Simd>(simd: S, face: &Face, v: Vectors<S>, error: f64x8<S>, certain: mask64x8<S>) -> mask64x8<S> {
    let Some([x, y]) = face.owned else { return mask64x8::splat(simd, false) };
    let norms = face.norms();
    let most = x[0].abs().max(x[1].abs()).max(y[0].abs()).max(y[1].abs());
    let error = error * (norms.x.max(norms.y) + most * norms.z);
    let of = |axis: DVec3| dot(v, splat_vector(simd, axis));
    let (px, py, pz) = (of(face.x), of(face.y), of(face.z));
    let beyond = (px - pz * x[1]).simd_gt(error)
        | (pz * x[0] - px).simd_gt(error)
        | (py - pz * y[1]).simd_gt(error)
        | (pz * y[0] - py).simd_gt(error)
        | (-pz).simd_gt(error);
    certain & beyond
}

/// Eight points on a face.
pub(crate) struct Refined {
    /// X, Y and W.
    pub(crate) at: [[f64; 8]; 3],
    /// Errors of X and Y, and of W.
    pub(crate) errors: [[f64; 8]; 2],
    /// The points that belong to the face.
    pub(crate) members: u64,
    /// The members whose coordinates and errors hold.
    pub(crate) exact: u64,
}

#[cfg(test)]
mod tests;
