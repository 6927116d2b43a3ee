//! Sixteen triangles, or points, at once.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

/// Triangles, samples or points handled at once.
pub(crate) const LANES: usize = 16;

/// The same number in all lanes.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Sixteen numbers as a vector.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, values: &[f32; LANES]) -> f32x16<S> {
    f32x16::simd_from(simd, *values)
}

/// The positions of a word's bits, the lowest first.
#[inline(always)]
pub(crate) fn bits_of(bits: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut bits = bits.into();
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// Lane by lane the least of three vectors.
#[inline(always)]
pub(crate) fn min3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.min(b).min(c)
}

/// Lane by lane the largest of three vectors.
#[inline(always)]
pub(crate) fn max3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.max(b).max(c)
}

/// What is left of each of 16 vectors when `either` takes one of two numbers: the least, or the largest.
#[inline(always)]
pub(crate) fn of_each<S: Simd>(
    rows: &[f32x16<S>; LANES],
    either: impl Fn(f32x16<S>, f32x16<S>) -> f32x16<S>,
) -> f32x16<S> {
    let mut rows = *rows;
    let mut count = LANES;
    while count > 1 {
        count /= 2;
        for index in 0..count {
            let (a, b) = (rows[2 * index], rows[2 * index + 1]);
            rows[index] = either(a.unzip_low(b), a.unzip_high(b));
        }
    }
    rows[0]
}

/// Four numbers of each of 16 things, thing after thing.
#[inline(always)]
pub(crate) fn quads<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
    let (even_low, even_high) = (a.zip_low(c), a.zip_high(c));
    let (odd_low, odd_high) = (b.zip_low(d), b.zip_high(d));
    [even_low.zip_low(odd_low), even_low.zip_high(odd_low), even_high.zip_low(odd_high), even_high.zip_high(odd_high)]
}

/// One corner of 16 triangles, given as indices of `vertices`, the last of which stands for all that are out of range:
/// the four numbers of each.
#[inline(always)]
pub(crate) fn load_corner<S: Simd, V: Copy + Into<[f32; 4]>>(
    simd: S,
    vertices: &[V],
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

/// One corner of 16 triangles, given as indices of a few vertices: three numbers of each.
///
/// # Panics
/// If there are fewer than 16 triangles, or a corner is out of range.
#[inline(always)]
pub(crate) fn load_local_corner<S: Simd>(
    simd: S,
    vertices: &[[f32; 4]],
    corners: &[[u8; 4]],
    corner: usize,
) -> [f32x16<S>; 3] {
    let vertex = |lane: usize| f32x4::simd_from(simd, vertices[usize::from(corners[lane][corner])]);
    let a = vertex(0).combine(vertex(1)).combine(vertex(2).combine(vertex(3)));
    let b = vertex(4).combine(vertex(5)).combine(vertex(6).combine(vertex(7)));
    let c = vertex(8).combine(vertex(9)).combine(vertex(10).combine(vertex(11)));
    let d = vertex(12).combine(vertex(13)).combine(vertex(14).combine(vertex(15)));
    let (even_low, even_high) = (a.unzip_low(b), c.unzip_low(d));
    let (odd_low, odd_high) = (a.unzip_high(b), c.unzip_high(d));
    [even_low.unzip_low(even_high), odd_low.unzip_low(odd_high), even_low.unzip_high(even_high)]
}

/// One corner of four triangles, vertex after vertex. Combining registers avoids a store and a load through memory,
/// which wait for each other.
#[inline(always)]
fn load_quarter<S: Simd, V: Copy + Into<[f32; 4]>>(
    simd: S,
    vertices: &[V],
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
fn load_vertex<S: Simd, V: Copy + Into<[f32; 4]>>(simd: S, vertices: &[V], index: u32) -> f32x4<S> {
    f32x4::simd_from(simd, vertices[(index as usize).min(vertices.len() - 1)].into())
}
