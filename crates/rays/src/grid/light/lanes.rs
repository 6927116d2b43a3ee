use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::DVec3;

/// Points or triangles handled at once.
pub(super) const LANES: usize = 16;

/// A vector for each of eight lanes.
pub(super) type Vectors<S> = [f64x8<S>; 3];

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

#[inline(always)]
pub(super) fn splat_vector<S: Simd>(simd: S, value: DVec3) -> Vectors<S> {
    value.to_array().map(|component| f64x8::splat(simd, component))
}

#[inline(always)]
pub(super) fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub(super) fn largest<S: Simd>(a: Vectors<S>) -> f64x8<S> {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}

#[inline(always)]
pub(super) fn min3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.min(b).min(c)
}

#[inline(always)]
pub(super) fn max3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.max(b).max(c)
}

/// The four columns of 16 rows.
#[inline(always)]
pub(super) fn transpose<S: Simd>(simd: S, rows: &[[f32; 4]; LANES]) -> [f32x16<S>; 4] {
    let quarter = |first: usize| f32x16::from_slice(simd, rows[first..first + 4].as_flattened());
    let (a, b, c, d) = (quarter(0), quarter(4), quarter(8), quarter(12));
    // Two rounds of unzipping take every fourth number.
    let (even_low, even_high) = (a.unzip_low(b), c.unzip_low(d));
    let (odd_low, odd_high) = (a.unzip_high(b), c.unzip_high(d));
    [
        even_low.unzip_low(even_high),
        odd_low.unzip_low(odd_high),
        even_low.unzip_high(even_high),
        odd_low.unzip_high(odd_high),
    ]
}
