use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::lanes::{LANES, splat};

/// Sixteen points of a layer, which the fast test takes at once. 320 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) x: [f32; LANES],
    pub(super) y: [f32; LANES],
    /// Nearness to the light.
    pub(super) nearness: [f32; LANES],
    /// The triangle that each point is on.
    pub(super) triangle: [u32; LANES],
    /// The pixel that shows each point; [`Block::PADDING`] for none.
    pub(super) pixel: [u32; LANES],
}

impl Block {
    pub(super) const PADDING: u32 = u32::MAX;

    pub(super) const EMPTY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        nearness: [0.0; LANES],
        triangle: [u32::MAX; LANES],
        pixel: [Self::PADDING; LANES],
    };
}

/// The cells of a layer, in rows: where in the blocks each one's points are.
///
/// Cells are narrow and flat, since a row's cells next to each other are one range of points.
#[derive(Debug, Default)]
pub(super) struct Cells {
    pub(super) columns: usize,
    /// A multiple of `rows_per_band`.
    pub(super) rows: usize,
    /// Rows that are sorted together; each band's points start a block. A power of two.
    pub(super) rows_per_band: usize,
    /// The points of cell c are from `ends[c]` to `ends[c + 1]`; the first cell of a band may begin with padding.
    pub(super) ends: Vec<u32>,
    /// For each block the nearness of its farthest point.
    pub(super) farthest: Vec<f32>,
    /// For each block which places hold no point.
    pub(super) padding: Vec<u16>,
}

impl Cells {
    pub(super) fn bytes(&self) -> usize {
        self.ends.capacity() * size_of::<u32>()
            + self.farthest.capacity() * size_of::<f32>()
            + self.padding.capacity() * size_of::<u16>()
    }

    /// Chooses how many cells there are, by how many points and triangles.
    ///
    /// Six to 48 points to a cell, and about as many cells as triangles in between.
    pub(super) fn choose(&mut self, points: usize, triangles: usize) {
        let count = (triangles + triangles / 2).clamp(points / 48, points / 6).clamp(16, 1 << 20);
        let columns = ((3.0 * count as f64).sqrt() as usize).next_multiple_of(16);
        let rows = count.div_ceil(columns);
        let bands = (points / 16_384).clamp(1, 128).min(rows);
        self.rows_per_band = rows.div_ceil(bands).next_power_of_two();
        self.rows = rows.next_multiple_of(self.rows_per_band);
        self.columns = columns;
    }

    pub(super) fn bands(&self) -> usize {
        self.rows / self.rows_per_band
    }

    /// What X and Y in [−1, 1], plus one, are multiplied with to get the column and row.
    ///
    /// A little less than half their number, so that one stays in the last cell.
    pub(super) fn scale(&self) -> [f32; 2] {
        const SHRINK: f32 = 0.499_999;
        [self.columns as f32 * SHRINK, self.rows as f32 * SHRINK]
    }
}

/// The columns or rows of places in X or Y: for points and triangles alike, which keeps their order.
#[inline(always)]
pub(super) fn cells_at<S: Simd>(simd: S, at: f32x16<S>, scale: f32x16<S>, count: usize) -> i32x16<S> {
    let cell: i32x16<S> = (at.max(splat(simd, -2.0)).min(splat(simd, 2.0)) * scale + scale).to_int();
    cell.max(i32x16::splat(simd, 0)).min(i32x16::splat(simd, count as i32 - 1))
}
