//! Lane by lane, the extremes of three vectors.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

#[inline(always)]
pub(super) fn min3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.min(b).min(c)
}

#[inline(always)]
pub(super) fn max3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.max(b).max(c)
}
