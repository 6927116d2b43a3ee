use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::block::Cluster;
use crate::simd::vectors::{LANES, splat};

/// The cells of a face, in rows. A cluster is listed in each row that it overlaps, in the column of its lowest X.
///
/// Cells are as narrow and as high as points are dense: see [`Axis`]. They are narrower than high, since a row's cells
/// next to each other are one range of clusters, and 16 clusters are looked at together.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    pub(crate) across: Axis,
    pub(crate) down: Axis,
    /// Those of earlier faces that had more are kept, for their memory.
    pub(crate) all_rows: Vec<Row>,
    /// For each row and column the least nearness of any cluster in that cell and the [`WINDOW`] − 1 to the right.
    minima: Vec<f32>,
}

/// How X is divided into columns, or Y into rows: each coordinate is in one of [`Axis::STRIPS`] strips, each strip in a cell.
/// 16 KiB.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    cells: Vec<u16>,
    pub(crate) count: usize,
}

/// The clusters of a row of cells, sorted by column. 24 bytes each.
#[derive(Debug, Default)]
pub(crate) struct Row {
    /// The clusters of column c are from `ends[c]` to `ends[c + 1]`.
    ends: Vec<u32>,
    /// The first cluster that reaches column c.
    firsts: Vec<u32>,
    /// Lowest and highest X, and Y, and the least nearness; after the last cluster 16 that overlap nothing.
    pub(crate) x: [Vec<f32>; 2],
    pub(crate) y: [Vec<f32>; 2],
    pub(crate) farthest: Vec<f32>,
    pub(crate) block: Vec<u32>,
    /// Where the row begins and ends in Y; the first and the last one also hold what is beyond.
    pub(crate) range: [f32; 2],
}

/// The cells that a triangle's bounds are in: first and last column and row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Covered {
    pub(crate) columns: [u16; 2],
    pub(crate) rows: [u16; 2],
}

/// Most columns that [`Cells::farthest`] looks at.
const WINDOW: u16 = 4;

impl Axis {
    /// Strips are half as wide as the error of points may be, so that no cluster reaches over many cells.
    pub(crate) const STRIPS: usize = 8192;

    /// Divides the axis into `count` cells, about as many in each part as there are points, and a few where there are
    /// none. `points` has a number for each strip.
    pub(crate) fn choose(&mut self, count: usize, points: &[u32]) {
        const EMPTY_SHARE: u64 = 4;
        let all: u64 = points.iter().map(|&points| u64::from(points)).sum::<u64>().max(1);
        let whole = all * EMPTY_SHARE * Self::STRIPS as u64 + all * Self::STRIPS as u64;
        let mut before = 0;
        self.count = count;
        self.cells.clear();
        self.cells.extend(points.iter().map(|&points| {
            let cell = before * count as u64 / whole;
            before += u64::from(points) * EMPTY_SHARE * Self::STRIPS as u64 + all;
            cell as u16
        }));
    }

    /// The cell of a coordinate: for clusters and triangles alike, which keeps their order.
    pub(crate) fn cell(&self, at: f32) -> usize {
        usize::from(self.cells[strip(at)])
    }

    /// The cells of 16 coordinates.
    #[inline(always)]
    pub(crate) fn cells_at<S: Simd>(&self, simd: S, at: f32x16<S>) -> [u16; LANES] {
        const LAST: usize = Axis::STRIPS - 1;
        let strips: i32x16<S> =
            (at.max(splat(simd, -2.0)).min(splat(simd, 2.0)) * splat(simd, SCALE) + splat(simd, SCALE)).to_int();
        let strips = strips.max(i32x16::splat(simd, 0)).to_array();
        let Some(cells) = self.cells.first_chunk::<{ Axis::STRIPS }>() else { return [0; LANES] };
        let mut found = [0; LANES];
        for (cell, strip) in found.iter_mut().zip(strips) {
            *cell = cells[(strip as usize).min(LAST)];
        }
        found
    }

    /// Where a cell begins and ends, give or take 10⁻⁶; the first and the last one also hold what is beyond.
    pub(crate) fn range(&self, cell: usize) -> [f32; 2] {
        let edge = |strip: usize| strip as f32 / SCALE - 1.0;
        let low = if cell == 0 { -2.0 } else { edge(self.cells.partition_point(|&at| usize::from(at) < cell)) };
        let high = self.cells.partition_point(|&at| usize::from(at) <= cell);
        [low, if high == Self::STRIPS { 2.0 } else { edge(high) }]
    }
}

/// What X and Y in [−1, 1], plus one, are multiplied with to get the strip: exact in f32.
const SCALE: f32 = (Axis::STRIPS / 2) as f32;

/// The strip of a coordinate.
pub(crate) fn strip(at: f32) -> usize {
    ((at.clamp(-2.0, 2.0) * SCALE + SCALE) as usize).min(Axis::STRIPS - 1)
}

/// How many columns and rows beyond its first one a cluster may reach, but for the error of its points.
pub(crate) const REACH: [u16; 2] = [3, 1];

impl Cells {
    pub(crate) fn bytes(&self) -> usize {
        let rows: usize = self.all_rows.iter().map(Row::bytes).sum();
        let axes = self.across.cells.capacity() + self.down.cells.capacity();
        let rows = rows + self.all_rows.capacity() * size_of::<Row>();
        rows + axes * size_of::<u16>() + self.minima.capacity() * size_of::<f32>()
    }

    pub(crate) fn rows(&self) -> &[Row] {
        &self.all_rows[..self.down.count]
    }

    /// The columns, the rows as an axis and as lists, and the minima.
    pub(crate) fn parts(&mut self) -> (&Axis, &Axis, &mut [Row], &mut [f32]) {
        (&self.across, &self.down, &mut self.all_rows[..self.down.count], &mut self.minima)
    }

    /// At most the nearness of the farthest point in some cells; infinite where there is none.
    #[inline(always)]
    pub(crate) fn farthest(&self, Covered { columns, rows }: Covered) -> f32 {
        if columns[1] - columns[0] >= WINDOW || rows[1] - rows[0] >= 2 {
            return f32::NEG_INFINITY;
        }
        let at = |row: u16| {
            let cell = usize::from(row) * self.across.count + usize::from(columns[0]);
            self.minima.get(cell).copied().unwrap_or(f32::NEG_INFINITY)
        };
        at(rows[0]).min(at(rows[1]))
    }

    /// Chooses the cells for a number of points, of which some are in the strips of X and Y.
    pub(crate) fn choose(&mut self, points: usize, samples: [&[u32]; 2]) {
        // As many columns as a square of full blocks has, and a quarter as many rows.
        let side = (points as f64 / LANES as f64).sqrt().clamp(4.0, 4096.0);
        self.across.choose(side as usize, samples[0]);
        self.down.choose((side / 4.0) as usize, samples[1]);
        if self.all_rows.len() < self.down.count {
            self.all_rows.resize_with(self.down.count, Row::default);
        }
        self.minima.resize(self.across.count * self.down.count, f32::INFINITY);
    }
}

impl Row {
    fn bytes(&self) -> usize {
        let floats: usize = self.x.iter().chain(&self.y).chain([&self.farthest]).map(Vec::capacity).sum();
        (floats + self.ends.capacity() + self.firsts.capacity() + self.block.capacity()) * size_of::<f32>()
    }

    /// Sorts clusters into the row's cells: a counting sort. `minima` has a number for each column.
    pub(crate) fn sort<'a>(&mut self, minima: &mut [f32], clusters: impl Iterator<Item = &'a Cluster> + Clone) {
        let columns = minima.len();
        minima.fill(f32::INFINITY);
        self.ends.clear();
        self.ends.resize(columns + 1, 0);
        self.firsts.clear();
        self.firsts.extend(0..columns as u32);
        let mut count = 0;
        for cluster in clusters.clone() {
            let [first, last] = cluster.columns;
            self.ends[usize::from(first) + 1] += 1;
            let reached = &mut self.firsts[usize::from(last)];
            *reached = u32::from(first).min(*reached);
            for least in &mut minima[usize::from(first)..=usize::from(last)] {
                *least = least.min(cluster.farthest);
            }
            count += 1;
        }
        for column in 0..columns {
            let window = &minima[column..(column + usize::from(WINDOW)).min(columns)];
            minima[column] = window.iter().fold(f32::INFINITY, |least, &at| least.min(at));
        }
        // What reaches a column has also reached those before, as far as it began.
        let mut least = u32::MAX;
        for first in self.firsts.iter_mut().rev() {
            least = least.min(*first);
            *first = least;
        }
        // Each cell's count becomes its beginning, and by counting up again its end.
        let mut sum = 0;
        for end in &mut self.ends[1..] {
            (*end, sum) = (sum, sum + *end);
        }
        for list in self.x.iter_mut().chain(&mut self.y).chain([&mut self.farthest]) {
            list.resize(count + LANES, 0.0);
            list[count..].fill(f32::INFINITY);
        }
        self.block.resize(count + LANES, u32::MAX);
        for cluster in clusters {
            let end = &mut self.ends[usize::from(cluster.columns[0]) + 1];
            let slot = *end as usize;
            *end += 1;
            self.x[0][slot] = cluster.x[0];
            self.x[1][slot] = cluster.x[1];
            self.y[0][slot] = cluster.y[0];
            self.y[1][slot] = cluster.y[1];
            self.farthest[slot] = cluster.farthest;
            self.block[slot] = cluster.block;
        }
        for first in &mut self.firsts {
            *first = self.ends[*first as usize];
        }
    }

    /// How many clusters there are.
    pub(crate) fn len(&self) -> usize {
        self.block.len().saturating_sub(LANES)
    }

    /// A range of clusters that has all those in some columns, and others. 16 can be loaded from its last one on: those
    /// after the row's last overlap nothing.
    #[inline(always)]
    pub(crate) fn reaching(&self, first_column: usize, last_column: usize) -> std::ops::Range<usize> {
        self.firsts[first_column] as usize..self.ends[last_column + 1] as usize
    }

    /// Which of the 16 clusters from `first` overlap a box and have points that are farther from the light than
    /// `nearest`.
    #[inline(always)]
    pub(crate) fn overlap<S: Simd>(&self, simd: S, first: usize, bounds: &Bounds<S>) -> mask32x16<S> {
        load(simd, &self.x[0], first).simd_le(bounds.x[1])
            & load(simd, &self.x[1], first).simd_ge(bounds.x[0])
            & load(simd, &self.y[0], first).simd_le(bounds.y[1])
            & load(simd, &self.y[1], first).simd_ge(bounds.y[0])
            & load(simd, &self.farthest, first).simd_lt(bounds.nearest)
    }

    /// The part of 16 clusters from `first` that is in a box: lowest and highest X and Y, the wrong way around where
    /// there is none.
    #[inline(always)]
    pub(crate) fn part_in<S: Simd>(&self, simd: S, first: usize, bounds: &Bounds<S>) -> [[f32x16<S>; 2]; 2] {
        let x = [load(simd, &self.x[0], first).max(bounds.x[0]), load(simd, &self.x[1], first).min(bounds.x[1])];
        let y = [load(simd, &self.y[0], first).max(bounds.y[0]), load(simd, &self.y[1], first).min(bounds.y[1])];
        [x, y]
    }

    /// Which of the 16 clusters from `first` begin in this row, with few others.
    #[inline(always)]
    pub(crate) fn begin_here<S: Simd>(&self, simd: S, first: usize) -> mask32x16<S> {
        load(simd, &self.y[0], first).simd_ge(splat(simd, self.range[0] - 1e-6))
    }
}

/// A triangle's bounds, the same in all 16 lanes.
pub(crate) struct Bounds<S: Simd> {
    pub(crate) x: [f32x16<S>; 2],
    pub(crate) y: [f32x16<S>; 2],
    pub(crate) nearest: f32x16<S>,
}

#[inline(always)]
fn load<S: Simd>(simd: S, list: &[f32], first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &list[first..first + LANES])
}
