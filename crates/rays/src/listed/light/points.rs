use rayon::prelude::*;

use super::ListedLightGrid;
use super::sort::{Bins, Entry, SortedRow};
use crate::light_grid::block::{Block, BlockErrors};
use crate::light_grid::face::HALF_ULP;
use crate::simd::vectors::LANES;

/// Up to 16 points of a cell: what the fast test takes at once. 320 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) points: Block,
    /// Of all points.
    pub(super) errors: BlockErrors,
    /// Where they are in the image.
    pub(super) places: [u32; LANES],
    pub(super) count: u32,
}

/// The points of a row of cells.
#[derive(Debug, Default)]
pub(super) struct PointRow {
    places: SortedRow,
    pub(super) groups: Vec<Group>,
    /// For each cell its first group, and where the last cell's end.
    starts: Vec<u32>,
    /// For each cell at most the nearness of its farthest point: its far limit. Infinite without points.
    pub(super) farthest: Vec<f32>,
}

impl PointRow {
    pub(super) fn bytes(&self) -> usize {
        self.places.bytes()
            + self.groups.capacity() * size_of::<Group>()
            + self.starts.capacity() * size_of::<u32>()
            + self.farthest.capacity() * size_of::<f32>()
    }

    /// The places of a cell's points.
    pub(super) fn places_of(&self, column: usize) -> &[u32] {
        &self.places.items()[self.places.range(column)]
    }

    /// The groups of a cell.
    pub(super) fn of_cell(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// Gathers the points of each cell in groups.
    fn gather(&mut self, columns: usize, blocks: &[Block], errors: &[BlockErrors]) {
        let Self { places, groups, starts, farthest } = self;
        groups.clear();
        starts.clear();
        farthest.clear();
        starts.push(0);
        for column in 0..columns {
            let mut least = f32::INFINITY;
            for places in places.items()[places.range(column)].chunks(LANES) {
                let mut group = Group {
                    points: Block::EMPTY,
                    errors: BlockErrors::default(),
                    places: [0; LANES],
                    count: places.len() as u32,
                };
                group.places[..places.len()].copy_from_slice(places);
                for (lane, &place) in places.iter().enumerate() {
                    let (block, at) = (place as usize / LANES, place as usize % LANES);
                    let (points, error) = (&blocks[block], errors[block]);
                    group.points.x[lane] = points.x[at];
                    group.points.y[lane] = points.y[at];
                    group.points.nearness[lane] = points.nearness[at];
                    group.errors.place = group.errors.place.max(error.place);
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

impl ListedLightGrid {
    /// Sorts the points of the face by cell (§4.2), and gathers them there.
    pub(super) fn sort_points(&mut self) {
        const MOST_RANGES: usize = 64;
        let largest = |errors: f32, block: &BlockErrors| errors.max(block.place);
        let used = self.grid.errors.iter().zip(&self.grid.members).filter(|(_, members)| **members != 0);
        let error = used.map(|(error, _)| error).fold(0.0, largest);
        self.choose_cells(error);
        let Self { grid, cells, point_bins, point_rows, .. } = self;
        let (blocks, errors, members) = (&grid.blocks, &grid.errors, &grid.members);
        let (columns, rows) = (cells.across.count, cells.down.count);
        let length = blocks.len().div_ceil(MOST_RANGES).max(1);
        point_bins.resize_with(blocks.len().div_ceil(length), Bins::default);
        point_bins.par_iter_mut().enumerate().with_max_len(1).for_each(|(range, bins)| {
            bins.unsorted.clear();
            for block in range * length..((range + 1) * length).min(blocks.len()) {
                let mut members = members[block];
                while members != 0 {
                    let lane = members.trailing_zeros() as usize;
                    members &= members - 1;
                    let column = cells.across.cell(blocks[block].x[lane]) as u16;
                    let row = cells.down.cell(blocks[block].y[lane]) as u16;
                    bins.unsorted.push(Entry { column, row, item: (block * LANES + lane) as u32 });
                }
            }
            bins.sort(rows);
        });
        point_rows.resize_with(rows, PointRow::default);
        point_rows.par_iter_mut().enumerate().with_max_len(1).for_each(|(row, points)| {
            points.places.sort(columns, point_bins.iter().flat_map(|bins| bins.row(row)).copied());
            points.gather(columns, blocks, errors);
        });
    }
}
