use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::block::Cluster;
use super::lanes::{LANES, splat};

/// The cells of a face, in rows. A cluster is in the cell of its lowest X and Y.
///
/// Cells are narrow and high, since a row's cells next to each other are one range of clusters, and 16 clusters are
/// looked at together.
#[derive(Debug, Default)]
pub(super) struct Cells {
    pub(super) columns: usize,
    /// Those of earlier faces that had more are kept, for their memory.
    pub(super) all_rows: Vec<Row>,
    pub(super) row_count: usize,
    /// Clusters are at most this wide and high.
    pub(super) reach: f32,
}

/// The clusters of a row of cells, sorted by column. 24 bytes each.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// The clusters of column c are from `ends[c]` to `ends[c + 1]`.
    pub(super) ends: Vec<u32>,
    /// Lowest and highest X, and Y, and the least nearness; after the last cluster 16 that overlap nothing.
    pub(super) x: [Vec<f32>; 2],
    pub(super) y: [Vec<f32>; 2],
    pub(super) farthest: Vec<f32>,
    pub(super) block: Vec<u32>,
}

impl Cells {
    pub(super) fn bytes(&self) -> usize {
        self.all_rows.capacity() * size_of::<Row>() + self.all_rows.iter().map(Row::bytes).sum::<usize>()
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.all_rows[..self.row_count]
    }

    pub(super) fn rows_mut(&mut self) -> &mut [Row] {
        &mut self.all_rows[..self.row_count]
    }

    /// Chooses how many cells there are for a number of points.
    pub(super) fn choose(&mut self, points: usize) {
        // As many columns as a square of full blocks has, and a quarter as many rows.
        let side = (points as f64 / LANES as f64).sqrt().clamp(4.0, 4096.0);
        self.columns = side as usize;
        self.row_count = (side / 4.0) as usize;
        if self.all_rows.len() < self.row_count {
            self.all_rows.resize_with(self.row_count, Row::default);
        }
        self.reach = (CLUSTER_COLUMNS * 2.0 / side) as f32;
    }

    /// What X and Y in [−1, 1], plus one, are multiplied with to get the column and row.
    ///
    /// A little less than half their number, so that one stays in the last cell.
    pub(super) fn scale(&self) -> [f32; 2] {
        const SHRINK: f32 = 0.499_999;
        [self.columns as f32 * SHRINK, self.row_count as f32 * SHRINK]
    }

    /// Below a triangle's lowest X or Y by this, no cluster can begin that it overlaps.
    pub(super) fn reach_back(&self) -> f32 {
        self.reach * 1.001 + 1e-6
    }
}

/// How many columns of cells a cluster may be wide.
const CLUSTER_COLUMNS: f64 = 2.5;

impl Row {
    fn bytes(&self) -> usize {
        let floats: usize = self.x.iter().chain(&self.y).chain([&self.farthest]).map(Vec::capacity).sum();
        (floats + self.ends.capacity() + self.block.capacity()) * size_of::<f32>()
    }

    /// Sorts clusters into the row's cells: a counting sort.
    pub(super) fn sort<'a>(&mut self, columns: usize, clusters: impl Iterator<Item = &'a Cluster> + Clone) {
        self.ends.clear();
        self.ends.resize(columns + 1, 0);
        let mut count = 0;
        for cluster in clusters.clone() {
            self.ends[cluster.column as usize + 1] += 1;
            count += 1;
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
            let end = &mut self.ends[cluster.column as usize + 1];
            let place = *end as usize;
            *end += 1;
            self.x[0][place] = cluster.x[0];
            self.x[1][place] = cluster.x[1];
            self.y[0][place] = cluster.y[0];
            self.y[1][place] = cluster.y[1];
            self.farthest[place] = cluster.farthest;
            self.block[place] = cluster.block;
        }
    }

    /// How many clusters there are.
    pub(super) fn len(&self) -> usize {
        self.block.len().saturating_sub(LANES)
    }

    /// Which of the 16 clusters from `first` overlap a box and have points that are farther from the light than
    /// `nearest`.
    #[inline(always)]
    pub(super) fn overlap<S: Simd>(&self, simd: S, first: usize, bounds: &Bounds<S>) -> mask32x16<S> {
        load(simd, &self.x[0], first).simd_le(bounds.x[1])
            & load(simd, &self.x[1], first).simd_ge(bounds.x[0])
            & load(simd, &self.y[0], first).simd_le(bounds.y[1])
            & load(simd, &self.y[1], first).simd_ge(bounds.y[0])
            & load(simd, &self.farthest, first).simd_lt(bounds.nearest)
    }
}

/// Where a triangle is, 16 times.
pub(super) struct Bounds<S: Simd> {
    pub(super) x: [f32x16<S>; 2],
    pub(super) y: [f32x16<S>; 2],
    pub(super) nearest: f32x16<S>,
}

#[inline(always)]
fn load<S: Simd>(simd: S, list: &[f32], first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &list[first..first + LANES])
}

/// The columns or rows of places in X or Y: for clusters and triangles alike, which keeps their order.
#[inline(always)]
pub(super) fn cells_at<S: Simd>(simd: S, at: f32x16<S>, scale: f32x16<S>, count: usize) -> i32x16<S> {
    let cell: i32x16<S> = (at.max(splat(simd, -2.0)).min(splat(simd, 2.0)) * scale + scale).to_int();
    cell.max(i32x16::splat(simd, 0)).min(i32x16::splat(simd, count as i32 - 1))
}

/// As [`cells_at`], for one place.
pub(super) fn cell_at(at: f32, scale: f32, count: usize) -> usize {
    ((at.clamp(-2.0, 2.0) * scale + scale) as usize).min(count - 1)
}
