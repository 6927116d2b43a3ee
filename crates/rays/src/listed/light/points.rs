use rayon::prelude::*;

use super::Lists;
use super::pass::LightPass;
use super::{Bins, Entry};
use crate::light_grid::LightCells;
use crate::light_grid::block::{Block, BlockErrors};
use crate::light_grid::face::HALF_ULP;
use crate::listed::sorted::Sorted;
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;

/// Up to 16 points of a cell: what the filter tests at once. 320 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) points: Block,
    /// Of all points.
    pub(super) errors: BlockErrors,
    /// The points' pixels.
    pub(super) indices: [u32; LANES],
    pub(super) count: u32,
}

/// The points of a row of cells.
#[derive(Debug, Default)]
pub(super) struct PointRow {
    /// The points' pixels.
    indices: Sorted<u32>,
    pub(super) groups: Vec<Group>,
    /// For each cell its first group, and where the last cell's end.
    starts: Vec<u32>,
    /// For each cell at most the nearness of its farthest point: its far limit. Infinite without points.
    pub(super) farthest: Vec<f32>,
}

impl PointRow {
    pub(super) fn bytes(&self) -> usize {
        self.indices.bytes()
            + self.groups.capacity() * size_of::<Group>()
            + self.starts.capacity() * size_of::<u32>()
            + self.farthest.capacity() * size_of::<f32>()
    }

    /// The groups of a cell.
    pub(super) fn of_cell(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// Gathers the points of each cell in groups.
    fn gather(&mut self, columns: usize, blocks: &[Block], errors: &[BlockErrors]) {
        let Self { indices, groups, starts, farthest } = self;
        groups.clear();
        starts.clear();
        farthest.clear();
        starts.push(0);
        for column in 0..columns {
            let mut least = f32::INFINITY;
            for indices in indices.of(column..column + 1).chunks(LANES) {
                let mut group = Group {
                    points: Block::EMPTY,
                    errors: BlockErrors::default(),
                    indices: [0; LANES],
                    count: indices.len() as u32,
                };
                group.indices[..indices.len()].copy_from_slice(indices);
                for (lane, &index) in indices.iter().enumerate() {
                    let (block, at) = (index as usize / LANES, index as usize % LANES);
                    let (points, error) = (&blocks[block], errors[block]);
                    group.points.x[lane] = points.x[at];
                    group.points.y[lane] = points.y[at];
                    group.points.nearness[lane] = points.nearness[at];
                    group.errors.position = group.errors.position.max(error.position);
                    group.errors.nearness = group.errors.nearness.max(error.nearness);
                    let nearness = points.nearness[at];
                    // Its own rounding as well.
                    let margin = error.nearness * 1.001 + nearness.abs() * (2.0 * HALF_ULP as f32);
                    least = least.min(nearness - margin);
                }
                groups.push(group);
            }
            starts.push(groups.len() as u32);
            farthest.push(least);
        }
    }
}

impl Lists {
    /// Sorts the points of the face by cell (§4.2), and gathers them there.
    pub(super) fn sort_points(&mut self, pass: &LightPass) {
        const MOST_RANGES: usize = 64;
        let largest = |errors: f32, block: &BlockErrors| errors.max(block.position);
        let used = pass.errors.iter().zip(&pass.members).filter(|(_, members)| **members != 0);
        let error = used.map(|(error, _)| error).fold(0.0, largest);
        self.choose_cells(error);
        let Self { cells, point_bins, point_rows, .. } = self;
        let (blocks, errors, members) = (&pass.blocks, &pass.errors, &pass.members);
        let (columns, rows) = (cells.across.count, cells.down.count);
        let length = blocks.len().div_ceil(MOST_RANGES).max(1);
        point_bins.resize_with(blocks.len().div_ceil(length), Bins::default);
        point_bins.par_iter_mut().enumerate().with_max_len(1).for_each(|(range, bins)| {
            bins.unsorted.clear();
            for block in range * length..((range + 1) * length).min(blocks.len()) {
                for lane in bits_of(members[block]) {
                    let column = cells.across.cell(blocks[block].x[lane]) as u16;
                    let row = cells.down.cell(blocks[block].y[lane]) as u16;
                    bins.unsorted.push(Entry { column, row, item: (block * LANES + lane) as u32 });
                }
            }
            bins.sort(rows);
        });
        point_rows.resize_with(rows, PointRow::default);
        point_rows.par_iter_mut().enumerate().with_max_len(1).for_each(|(row, points)| {
            let entries = point_bins.iter().flat_map(|bins| bins.row(row));
            points.indices.sort(columns, entries.map(Entry::column_and_item));
            points.gather(columns, blocks, errors);
        });
    }
    /// Adds the points of the face to `located`, each in the cell that it was sorted to.
    pub(super) fn add_located(&self, pass: &LightPass, located: &mut LightCells) {
        let [columns, rows] = [self.cells.across.count, self.cells.down.count];
        let points = self.point_rows.iter().enumerate().flat_map(|(row, points)| {
            (0..columns).flat_map(move |column| {
                points.indices.of(column..column + 1).iter().map(move |&index| {
                    let index = index as usize;
                    (index, [column, row], pass.blocks[index / LANES].nearness[index % LANES])
                })
            })
        });
        located.add_face(&pass.face, [columns, rows], points);
    }
}
