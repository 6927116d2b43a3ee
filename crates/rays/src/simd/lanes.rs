//! Sixteen triangles, or points, at once.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x4, f32x16, u8x64, u32x16};
use glam::Vec3;

/// Triangles, samples or points handled at once.
pub const LANES: usize = 16;

/// The same number in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Sixteen numbers as a vector.
#[inline(always)]
pub fn load<S: Simd>(simd: S, values: &[f32; LANES]) -> f32x16<S> {
    f32x16::simd_from(simd, *values)
}

/// Sixteen numbers of each axis as vectors.
#[inline(always)]
pub fn load_positions<S: Simd>(simd: S, [x, y, z]: &[[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    [load(simd, x), load(simd, y), load(simd, z)]
}

/// The positions of a word's bits, the lowest first.
#[inline(always)]
pub fn bits_of(bits: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut bits = bits.into();
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// The coordinates of up to sixteen points, NaN where there are fewer.
#[inline(always)]
pub fn sixteen_of<S: Simd>(simd: S, points: &[Vec3]) -> [f32x16<S>; 3] {
    let mut axes = [[f32::NAN; LANES]; 3];
    for (lane, point) in points.iter().enumerate().take(LANES) {
        axes[0][lane] = point.x;
        axes[1][lane] = point.y;
        axes[2][lane] = point.z;
    }
    [load(simd, &axes[0]), load(simd, &axes[1]), load(simd, &axes[2])]
}

/// Lane by lane the least of three vectors.
#[inline(always)]
pub fn min3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.min(b).min(c)
}

/// Lane by lane the largest of three vectors.
#[inline(always)]
pub fn max3<S: Simd>([a, b, c]: [f32x16<S>; 3]) -> f32x16<S> {
    a.max(b).max(c)
}

/// Reduces each of 16 vectors to one number by `either`: minimum or maximum.
#[inline(always)]
pub fn of_each<S: Simd>(rows: &[f32x16<S>; LANES], either: impl Fn(f32x16<S>, f32x16<S>) -> f32x16<S>) -> f32x16<S> {
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

/// Transposes four vectors into the four numbers of each of 16 items, item after item.
#[inline(always)]
pub fn quads<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
    let (even_low, even_high) = (a.zip_low(c), a.zip_high(c));
    let (odd_low, odd_high) = (b.zip_low(d), b.zip_high(d));
    [even_low.zip_low(odd_low), even_low.zip_high(odd_low), even_high.zip_low(odd_high), even_high.zip_high(odd_high)]
}

/// The four numbers of one corner of 16 triangles, whose corners are indices of `vertices`. The last vertex stands for all
/// indices out of range.
#[inline(always)]
pub fn load_corner<S: Simd, V: Copy + Into<[f32; 4]>>(
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

/// Three numbers of one corner of 16 triangles, whose corners are indices of a few vertices.
///
/// # Panics
/// If there are fewer than 16 triangles, or a corner is out of range.
#[inline(always)]
pub fn load_local_corner<S: Simd, V: Copy + Into<[f32; 4]>>(
    simd: S,
    vertices: &[V],
    corners: &[[u8; 4]],
    corner: usize,
) -> [f32x16<S>; 3] {
    transposed(
        #[inline(always)]
        |lane| f32x4::simd_from(simd, vertices[usize::from(corners[lane][corner])].into()),
    )
}

/// Size of the table of a [`look_up`].
pub const TABLE: usize = 4 * LANES;

/// The numbers of a table at 16 indices below [`TABLE`].
#[inline(always)]
pub fn look_up<S: Simd>(simd: S, table: &[f32; TABLE], indices: u32x16<S>) -> f32x16<S> {
    if !has_fast_permutes(simd) {
        let indices: [u32; LANES] = indices.into();
        let mut found = [0.0; LANES];
        for (found, index) in found.iter_mut().zip(indices) {
            *found = table[index as usize % TABLE];
        }
        return load(simd, &found);
    }
    let quarter = |number: usize| f32x16::from_slice(simd, &table[number * LANES..(number + 1) * LANES]);
    let half = u32x16::splat(simd, TABLE as u32 / 2);
    let in_high = indices.simd_ge(half);
    let of_half = in_high.select(indices - half, indices);
    // Each number's four bytes.
    let bytes = (of_half * 0x0404_0404 + 0x0302_0100).bitcast::<u8x64<S>>();
    let low = quarter(0).concat_swizzle_dyn(quarter(1), bytes);
    in_high.select(quarter(2).concat_swizzle_dyn(quarter(3), bytes), low)
}

/// Whether one instruction permutes the bytes of two registers; otherwise loading numbers one by one is faster.
#[inline(always)]
fn has_fast_permutes<S: Simd>(simd: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let is_fast = matches!(simd.level(), Level::Avx512(_));
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let is_fast = {
        let _: Level = simd.level();
        false
    };
    is_fast
}

/// The first three numbers of each of 16 quads. Combining registers avoids a store and a load through memory, which wait
/// for each other.
#[inline(always)]
pub fn transposed<S: Simd>(quad: impl Fn(usize) -> f32x4<S>) -> [f32x16<S>; 3] {
    let [x, y, z, _] = all_transposed(quad);
    [x, y, z]
}

/// The four numbers of each of 16 quads.
#[inline(always)]
pub fn all_transposed<S: Simd>(quad: impl Fn(usize) -> f32x4<S>) -> [f32x16<S>; 4] {
    let a = quad(0).combine(quad(1)).combine(quad(2).combine(quad(3)));
    let b = quad(4).combine(quad(5)).combine(quad(6).combine(quad(7)));
    let c = quad(8).combine(quad(9)).combine(quad(10).combine(quad(11)));
    let d = quad(12).combine(quad(13)).combine(quad(14).combine(quad(15)));
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
