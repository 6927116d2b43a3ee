use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use crate::shear::{SMALLEST, Sheared};
use crate::simd::lanes::splat;

const EPSILON: f32 = 1.0 / (1 << 24) as f32;

/// The results of an f32 test of sixteen triangles against a line each.
///
/// Corners are relative to the lines' origin and sheared in f64 along the slopes (c, d) in the middle of the tile's lines,
/// then rounded to f32. Lines have the rest of their slopes, at most h. These are [`Sheared`]'s offsets and slopes with
/// H = h + 2⁻²⁰: the error of both in f64 is at most 2⁻⁴⁹ z. Products don't overflow, for scenes of the size that
/// [`scale`](super::scale) makes.
pub(super) struct LineTests<S: Simd> {
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

/// Relative error bound of a line's ends.
const OF_ENDS: f32 = 4.0 * EPSILON;

/// Tests sixteen triangles against a line each; `wide` is H.
#[inline(always)]
pub(super) fn test<S: Simd>(simd: S, wide: f32, corners: &[[f32x16<S>; 3]; 3], beam: &Beam<S>) -> LineTests<S> {
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
    let sheared = Sheared::new([[x0, x1, x2], [y0, y1, y2], [z0, z1, z2]], [-beam.u, -beam.v], wide, 0.0);
    let largest = z0.abs().max(z1.abs()).max(z2.abs());
    let [earliest, latest] = sheared.depth([z0, z1, z2], largest.mul_add(16.0 * EPSILON, splat(simd, SMALLEST)));
    let (of_near, of_end) = (beam.near.abs() * OF_ENDS, beam.end.abs() * OF_ENDS);
    // Written so that NaN is possible, and never certain.
    let outside =
        earliest.simd_gt(beam.far) | earliest.simd_gt(beam.end + of_end) | latest.simd_lt(beam.near - of_near);
    let possible = !(sheared.is_missed() | outside);
    let certain =
        possible & sheared.is_met() & earliest.simd_gt(beam.near + of_near) & latest.simd_lt(beam.end - of_end);
    LineTests { possible, certain, earliest, latest }
}
