use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::DVec3;

pub use crate::simd::lanes::{LANES, load_corner, splat};

// Closures and `array::map` are not reliably inlined where vectors pass through them, and code that isn't inlined is
// compiled without the instruction set: it made mapping take five times as long. So the vector code here is written out.

/// A vector for each of eight lanes.
pub type Vectors<S> = [f64x8<S>; 3];

#[inline(always)]
pub fn splat_vector<S: Simd>(simd: S, value: DVec3) -> Vectors<S> {
    [f64x8::splat(simd, value.x), f64x8::splat(simd, value.y), f64x8::splat(simd, value.z)]
}

#[inline(always)]
pub fn vectors<S: Simd>(simd: S, [x, y, z]: [[f64; 8]; 3]) -> Vectors<S> {
    [f64x8::simd_from(simd, x), f64x8::simd_from(simd, y), f64x8::simd_from(simd, z)]
}

#[inline(always)]
pub fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub fn minus<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub fn absolute<S: Simd>(a: Vectors<S>) -> Vectors<S> {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// Sixteen vectors in f64, in two halves.
#[inline(always)]
pub fn widen<S: Simd>(a: [f32x16<S>; 3]) -> [Vectors<S>; 2] {
    let ((x0, x1), (y0, y1), (z0, z1)) = (a[0].widen(), a[1].widen(), a[2].widen());
    [[x0, y0, z0], [x1, y1, z1]]
}

/// Two halves as sixteen vectors in f32.
#[inline(always)]
pub fn narrow<S: Simd>(low: Vectors<S>, high: Vectors<S>) -> [f32x16<S>; 3] {
    [low[0].narrow(high[0]), low[1].narrow(high[1]), low[2].narrow(high[2])]
}

#[inline(always)]
pub fn largest<S: Simd>(a: Vectors<S>) -> f64x8<S> {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}
