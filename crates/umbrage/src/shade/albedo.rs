//! Directional albedo from tables, and the terms of microfacets that they are integrated from.

use std::f32::consts::PI;
use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::Vec2;
use umbrage_rays::simd::lanes::{TABLE, look_up};
use umbrage_rays::{SimdLevel, dispatch};

use super::lanes::{Each, LANES, Vector};

/// Entries along each side of a table.
pub(super) const SIDE: usize = 24;

/// Entries of `N` numbers by two variables from 0 to 1.
pub(super) type Table<const N: usize> = [[[f32; N]; SIDE]; SIDE];

/// The numbers between a table's entries, at a row and a column from 0 to 1.
#[inline(always)]
pub(super) fn looked_up<S: Simd, const N: usize>(
    simd: S,
    table: &Table<N>,
    row: f32x16<S>,
    column: f32x16<S>,
) -> [f32x16<S>; N] {
    const LAST: f32 = (SIDE - 1) as f32;
    let (row, column) = (row * LAST, column * LAST);
    let (upper, left) = (row.floor().min(LAST - 1.0), column.floor().min(LAST - 1.0));
    let (down, right) = (row - upper, column - left);
    let first = upper.as_slice()[0];
    if upper.simd_eq(first).all_true() {
        return between_two_rows(simd, table, first as usize, left, [right, down]);
    }
    let corners = gather(table, &upper.into(), &left.into());
    let mut numbers = [f32x16::splat(simd, 0.0); N];
    for (number, [a, b, c, d]) in numbers.iter_mut().zip(&corners) {
        let (a, b) = (f32x16::from_slice(simd, a), f32x16::from_slice(simd, b));
        let (c, d) = (f32x16::from_slice(simd, c), f32x16::from_slice(simd, d));
        let (above, below) = (a + (b - a) * right, c + (d - c) * right);
        *number = above + (below - above) * down;
    }
    numbers
}

/// As [`looked_up`], where all lanes have the same row above them, as those of one material have.
#[inline(always)]
fn between_two_rows<S: Simd, const N: usize>(
    simd: S,
    table: &Table<N>,
    upper: usize,
    left: f32x16<S>,
    [right, down]: [f32x16<S>; 2],
) -> [f32x16<S>; N] {
    let upper = upper.min(SIDE - 2);
    let mut rows = [[0.0; TABLE]; 2];
    for (to, row) in rows.iter_mut().zip(&table[upper..]) {
        to[..N * SIDE].copy_from_slice(row.as_flattened());
    }
    let left: u32x16<S> = left.to_int::<u32x16<S>>() * N as u32;
    let mut numbers = [f32x16::splat(simd, 0.0); N];
    for (number, to) in (0..).zip(&mut numbers) {
        let (west, east) = (left + number, left + (number + N as u32));
        let (a, b) = (look_up(simd, &rows[0], west), look_up(simd, &rows[0], east));
        let (c, d) = (look_up(simd, &rows[1], west), look_up(simd, &rows[1], east));
        let (above, below) = (a + (b - a) * right, c + (d - c) * right);
        *to = above + (below - above) * down;
    }
    numbers
}

/// The four entries of a table to mix in each lane, number by number.
fn gather<const N: usize>(table: &Table<N>, rows: &Each<f32>, columns: &Each<f32>) -> [[Each<f32>; 4]; N] {
    let mut corners = [[[0.0; LANES]; 4]; N];
    for lane in 0..LANES {
        let (row, column) = ((rows[lane] as usize).min(SIDE - 2), (columns[lane] as usize).min(SIDE - 2));
        for (number, corners) in corners.iter_mut().enumerate() {
            for (which, corner) in corners.iter_mut().enumerate() {
                corner[lane] = table[row + which / 2][column + which % 2][number];
            }
        }
    }
    corners
}

/// Scale and bias of f0 by perceptual roughness and cosine, both from 0 to 1: 4.6 KB.
static SPECULAR: LazyLock<Table<2>> = LazyLock::new(|| {
    // At zero itself the integrand has no value.
    let value = |index: usize| (index as f32 / (SIDE - 1) as f32).max(1e-3);
    let integrated = |row, column| dispatch!(SimdLevel::default(), simd => integrated(simd, value(row), value(column)));
    std::array::from_fn(|row| std::array::from_fn(|column| integrated(row, column).into()))
});

/// The table, by roughness and then by cosine, both from 0 to 1.
#[cfg(feature = "gpu")]
pub(crate) fn specular_albedo_table() -> &'static Table<2> {
    &SPECULAR
}

/// Scale and bias of f0 in the directional albedo of a GGX layer, at the cosine `n_v` between normal and view: the
/// second of the two sums into which Karis splits light from all around (*Real Shading in Unreal Engine 4*, 2013).
#[inline(always)]
pub(super) fn specular_albedo<S: Simd>(simd: S, roughness: f32x16<S>, n_v: f32x16<S>) -> [f32x16<S>; 2] {
    looked_up(simd, &SPECULAR, roughness.max(0.0).min(1.0), n_v.max(0.0).min(1.0))
}

/// The integral over light directions, by microfacet normals drawn from the distribution itself.
#[inline(always)]
fn integrated<S: Simd>(simd: S, roughness: f32, n_v: f32) -> Vec2 {
    const SAMPLES: usize = 256;
    let alpha = roughness * roughness;
    let a2 = f32x16::splat(simd, alpha * alpha);
    let zero = f32x16::splat(simd, 0.0);
    let view_z = f32x16::splat(simd, n_v);
    let view = Vector { x: f32x16::splat(simd, (1.0 - n_v * n_v).sqrt()), y: zero, z: view_z };
    let (mut scale, mut bias) = (zero, zero);
    for first in (0..SAMPLES).step_by(LANES) {
        let (mut drawn, mut sines, mut cosines) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let sample = (first + lane) as u32;
            drawn[lane] = (sample as f32 + 0.5) / SAMPLES as f32;
            (sines[lane], cosines[lane]) = libm::sincosf(2.0 * PI * (sample.reverse_bits() as f32 / u32::MAX as f32));
        }
        let drawn = f32x16::from_slice(simd, &drawn);
        let cosine = ((1.0 - drawn) / (1.0 + (a2 - 1.0) * drawn)).sqrt();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let half = Vector {
            x: sine * f32x16::from_slice(simd, &cosines),
            y: sine * f32x16::from_slice(simd, &sines),
            z: cosine,
        };
        let v_h = view.dot(half).max(0.0);
        let n_l = 2.0 * v_h * half.z - view_z;
        let weight = 4.0 * visibility(a2, n_l, view_z) * n_l * v_h / half.z;
        let weight = n_l.simd_gt(0.0).select(weight, zero);
        let fresnel = fifth_power(1.0 - v_h);
        scale += (1.0 - fresnel) * weight;
        bias += fresnel * weight;
    }
    Vec2::new(scale.reduce_sum(), bias.reduce_sum()) / SAMPLES as f32
}

/// Height-correlated Smith shadowing over 4 (n·l)(n·v), `a2` being the squared GGX width: Heitz, *Understanding the
/// Masking-Shadowing Function in Microfacet-Based BRDFs*, 2014.
#[inline(always)]
pub(super) fn visibility<S: Simd>(a2: f32x16<S>, n_l: f32x16<S>, n_v: f32x16<S>) -> f32x16<S> {
    0.5 / masked(a2, n_l, n_v)
}

/// One over twice the [`visibility`].
#[inline(always)]
pub(super) fn masked<S: Simd>(a2: f32x16<S>, n_l: f32x16<S>, n_v: f32x16<S>) -> f32x16<S> {
    let masking = n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt();
    let shadowing = n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt();
    masking + shadowing
}

/// The fifth power of Schlick's Fresnel term.
#[inline(always)]
pub(super) fn fifth_power<S: Simd>(value: f32x16<S>) -> f32x16<S> {
    let squared = value * value;
    squared * squared * value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_of_one_row_have_the_bits_of_lanes_of_several() {
        let lanes = |of: &dyn Fn(usize) -> f32| -> Each<f32> { std::array::from_fn(of) };
        let columns = lanes(&|lane| lane as f32 / (LANES - 1) as f32);
        for level in SimdLevel::available() {
            let found = |rows: &Each<f32>| -> [Each<f32>; 2] {
                dispatch!(level, simd => {
                    let (rows, columns) = (f32x16::from_slice(simd, rows), f32x16::from_slice(simd, &columns));
                    looked_up(simd, &SPECULAR, rows, columns).map(Each::<f32>::from)
                })
            };
            for row in [0.0, 0.3, 0.5, 0.99, 1.0] {
                let other = if row > 0.5 { 0.1 } else { 0.9 };
                for apart in 0..LANES {
                    let [of_one, of_two] =
                        [found(&[row; LANES]), found(&lanes(&|lane| if lane == apart { other } else { row }))];
                    for (one, two) in of_one.iter().zip(&of_two) {
                        assert!((0..LANES).all(|lane| (one[lane] == two[lane]) == (lane != apart)), "{row} in {level}");
                    }
                }
            }
        }
    }
}
