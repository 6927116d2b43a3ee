use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use crate::simd::lanes::splat;

const EPSILON: f32 = 1.0 / (1 << 24) as f32;

/// The results of an f32 test of sixteen triangles against a line each.
///
/// **Coordinates.** With the face's axes, and (c, d) the slopes in the middle of the tile's lines, a corner has relative to
/// the lines' origin x = Δᵢ − c z, y = Δⱼ − d z and the depth z, in f64 and then rounded to f32; a line has its slopes minus
/// (c, d), called (u, v), of at most h. Where a line passes a corner, X = x − u z and Y = y − v z are zero.
///
/// **Misses.** The edge functions of the predicate are, up to a common factor, E = X₁ Y₂ − X₂ Y₁. A triangle is missed if
/// two of them have certain and opposite signs, and certainly met if all three have the same certain sign.
///
/// **Error bounds.** Let ε = 2⁻²⁴ and a = |X| + |Y|. Rounding moves X by ε |x| ≤ ε (|X| + h z) for the corner, by 2 ε h z
/// for u and z, by ε h z for their product and by ε |X| for the difference; the error of x and u in f64 is at most 2⁻⁴⁹ z,
/// since |Δᵢ| ≤ |x| + |c| z. With H = h + 2⁻²⁰, these are together less than a third of e = 16 ε (a + H z), taken for the
/// largest of the three corners. An edge function is then wrong by at most e (a₁ + a₂ + 2 e) / 2, and its own roundings are
/// 2 ε a₁ a₂: less than δ = e (a₁ + a₂ + a₃ + 3 e) for all three. Underflow loses less than `SMALLEST`, for scenes of the
/// size that [`scale`](super::job::scale) makes. Where products and sums are fused, there is one rounding less.
///
/// **Depth of a hit.** The depth is Σ E z / Σ E. Where the triangle is met, it is between the least and the largest z, each
/// with an error of ε of itself; f = 16 ε max |z| is far more. With s the difference of these, weights with an error of δ
/// move it by at most 3 δ s / (|Σ E| − 3 δ), and the roundings of sums, products and quotient by 8 ε max |z|. As it isn't
/// moved by more than s either, that is less than 2 f + s min(1, 16 δ / |Σ E|): where |Σ E| > 12 δ the quotient is below 4 δ
/// s / |Σ E|, and elsewhere 16 δ / |Σ E| is above one.
pub(super) struct Found<S: Simd> {
    /// Not missed, and not certainly outside of the line's ends.
    pub(super) possible: mask32x16<S>,
    /// Those of them certainly met, between the ends.
    pub(super) certain: mask32x16<S>,
    /// Bounds of a hit's depth.
    pub(super) earliest: f32x16<S>,
    pub(super) latest: f32x16<S>,
}

/// Sixteen lines.
#[derive(Clone, Copy)]
pub(super) struct Beam<S: Simd> {
    pub(super) u: f32x16<S>,
    pub(super) v: f32x16<S>,
    /// Depths of the lines' start and end, rounded to f32.
    pub(super) near: f32x16<S>,
    pub(super) end: f32x16<S>,
    /// Hits behind this depth don't matter any more.
    pub(super) far: f32x16<S>,
}

pub(super) const SMALLEST: f32 = 1e-36;

/// Relative error bound of a line's ends.
const OF_ENDS: f32 = 4.0 * EPSILON;

/// Tests sixteen triangles against a line each; `wide` is H.
#[inline(always)]
pub(super) fn test<S: Simd>(simd: S, wide: f32, corners: &[[f32x16<S>; 3]; 3], beam: &Beam<S>) -> Found<S> {
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
    let one = splat(simd, 1.0);
    let (u, v) = (-beam.u, -beam.v);
    let (x0, x1, x2) = (u.mul_add(z0, x0), u.mul_add(z1, x1), u.mul_add(z2, x2));
    let (y0, y1, y2) = (v.mul_add(z0, y0), v.mul_add(z1, y1), v.mul_add(z2, y2));
    let (e0, e1, e2) = (x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0);
    let (a0, a1, a2) = (x0.abs() + y0.abs(), x1.abs() + y1.abs(), x2.abs() + y2.abs());
    let wide = splat(simd, wide);
    let largest = z0.abs().mul_add(wide, a0).max(z1.abs().mul_add(wide, a1)).max(z2.abs().mul_add(wide, a2));
    let error = largest * (16.0 * EPSILON);
    let aside = a0 + a1 + a2;
    let doubt = (error * 3.0 + aside) * error + splat(simd, SMALLEST);
    let (lowest, highest) = (e0.min(e1).min(e2), e0.max(e1).max(e2));
    let missed = lowest.simd_lt(-doubt) & highest.simd_gt(doubt);
    let sure = lowest.simd_gt(doubt) | highest.simd_lt(-doubt);
    let (first, last) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
    let inverse = one / (e0 + e1 + e2);
    // Each E is divided first: products E z may underflow, and weights don't matter where they do.
    let depth = (e0 * inverse) * z0 + (e1 * inverse) * z1 + (e2 * inverse) * z2;
    let range = last - first;
    let of_depth = first.abs().max(last.abs()) * (16.0 * EPSILON) + splat(simd, SMALLEST);
    let moved = of_depth * 2.0 + range * (doubt * inverse.abs() * 16.0).min(one);
    let earliest = sure.select(depth - moved, first - of_depth);
    let latest = sure.select(depth + moved, last + of_depth);
    let (of_near, of_end) = (beam.near.abs() * OF_ENDS, beam.end.abs() * OF_ENDS);
    // Written so that NaN is possible, and never certain.
    let outside =
        earliest.simd_gt(beam.far) | earliest.simd_gt(beam.end + of_end) | latest.simd_lt(beam.near - of_near);
    let possible = !(missed | outside);
    let certain = possible & sure & earliest.simd_gt(beam.near + of_near) & latest.simd_lt(beam.end - of_end);
    Found { possible, certain, earliest, latest }
}
