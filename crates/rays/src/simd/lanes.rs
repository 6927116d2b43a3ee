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
