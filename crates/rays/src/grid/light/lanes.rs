use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, f64x8};
use glam::DVec3;

// Closures and `array::map` are not reliably inlined where vectors pass through them, and what isn't inlined is compiled
// without the instruction set: it made mapping take five times as long. So the vector code here is written out.

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
    [f64x8::splat(simd, value.x), f64x8::splat(simd, value.y), f64x8::splat(simd, value.z)]
}

#[inline(always)]
pub(super) fn dot<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub(super) fn minus<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn absolute<S: Simd>(a: Vectors<S>) -> Vectors<S> {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// Sixteen vectors in f64, in two halves.
#[inline(always)]
pub(super) fn widen<S: Simd>(a: [f32x16<S>; 3]) -> [Vectors<S>; 2] {
    let ((x0, x1), (y0, y1), (z0, z1)) = (a[0].widen(), a[1].widen(), a[2].widen());
    [[x0, y0, z0], [x1, y1, z1]]
}

/// Two halves as sixteen vectors in f32.
#[inline(always)]
pub(super) fn narrow<S: Simd>(low: Vectors<S>, high: Vectors<S>) -> [f32x16<S>; 3] {
    [low[0].narrow(high[0]), low[1].narrow(high[1]), low[2].narrow(high[2])]
}

#[inline(always)]
pub(super) fn largest<S: Simd>(a: Vectors<S>) -> f64x8<S> {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}

/// One corner of 16 triangles, given as places in `vertices`, the last of which stands for all that are out of range:
/// the four numbers of each.
#[inline(always)]
pub(super) fn load_corner<S: Simd>(
    simd: S,
    vertices: &[[f32; 4]],
    triangles: &[[u32; 3]; LANES],
    corner: usize,
) -> [f32x16<S>; 4] {
    let a = load_quarter(simd, vertices, triangles, corner, 0);
    let b = load_quarter(simd, vertices, triangles, corner, 4);
    let c = load_quarter(simd, vertices, triangles, corner, 8);
    let d = load_quarter(simd, vertices, triangles, corner, 12);
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

/// One corner of four triangles. Combining registers avoids a store and a load through memory, which wait for each
/// other.
#[inline(always)]
fn load_quarter<S: Simd>(
    simd: S,
    vertices: &[[f32; 4]],
    triangles: &[[u32; 3]; LANES],
    corner: usize,
    lane: usize,
) -> f32x16<S> {
    let a = load_vertex(simd, vertices, triangles[lane][corner]);
    let b = load_vertex(simd, vertices, triangles[lane + 1][corner]);
    let c = load_vertex(simd, vertices, triangles[lane + 2][corner]);
    let d = load_vertex(simd, vertices, triangles[lane + 3][corner]);
    a.combine(b).combine(c.combine(d))
}

#[inline(always)]
fn load_vertex<S: Simd>(simd: S, vertices: &[[f32; 4]], place: u32) -> f32x4<S> {
    f32x4::simd_from(simd, vertices[(place as usize).min(vertices.len() - 1)])
}
