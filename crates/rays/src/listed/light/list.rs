use std::ops::Range as Ids;

use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::cells::Cells;
use super::pass::LightPass;
use super::plane::{Plane, planes};
use super::points::PointRow;
use super::small::{BATCH, Batch, Mapped};
use super::trace::LARGE;
use super::{Bins, Entry, Lists};
use crate::Triangles;
use crate::light_grid::face::VertexErrors;
use crate::listed::sorted::Sorted;
use crate::shot::{Counts, OpacityOfSides};
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;

/// What one range of triangles has in cells.
#[derive(Default)]
pub(super) struct Range {
    pub(super) bins: Bins,
    /// Its large triangles; their entries count from the range's first one.
    large: Vec<(u32, Plane)>,
    /// How many large triangles earlier ranges have.
    large_before: u32,
    batch: Batch,
}

impl Range {
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + self.bins.bytes() + self.large.capacity() * size_of::<(u32, Plane)>()
    }

    /// The entries of a row, with large triangles counted from the first of all.
    fn row(&self, row: usize) -> impl Iterator<Item = Entry> + Clone {
        let before = self.large_before;
        let counted = move |item: u32| if item & LARGE != 0 { item + before } else { item };
        self.bins.row(row).iter().map(move |entry| Entry { item: counted(entry.item), ..*entry })
    }
}

impl Lists {
    /// Lists each triangle in the cells that it may shadow points of.
    pub(super) fn list(&mut self, pass: &mut LightPass, triangles: Triangles<'_>, opacity: &OpacityOfSides<'_>) {
        const SMALLEST_RANGE: usize = 4096;
        const MOST_RANGES: usize = 64;
        let Self { cells, point_rows, ranges, large, .. } = self;
        let vertex_errors = VertexErrors::new(&pass.face);
        let mapped = Mapped { face: &pass.face, vertex_errors, cells, vertices: &pass.vertices };
        let listing = Listing { mapped, triangles, opacity, margin: cells.margin, point_rows };
        let count = triangles.len();
        // Ranges don't depend on the number of threads.
        ranges.resize_with(count.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES), Range::default);
        let length = count.div_ceil(ranges.len());
        let level = pass.level.0;
        ranges.par_iter_mut().enumerate().with_max_len(1).for_each(|(index, range)| {
            let ids = (index * length).min(count)..((index + 1) * length).min(count);
            dispatch!(level, simd => listing.run(simd, range, ids));
            range.bins.sort(cells.down.count);
        });
        large.clear();
        for range in ranges {
            range.large_before = large.len() as u32;
            large.extend_from_slice(&range.large);
        }
        pass.counts.large_triangles += large.len() as u64;
    }

    /// Sorts pairs of triangles and cells by cell.
    pub(super) fn sort_pairs(&mut self, counts: &mut Counts) {
        let Self { cells, ranges, triangle_rows, .. } = self;
        triangle_rows.resize_with(cells.down.count, Sorted::default);
        triangle_rows.par_iter_mut().enumerate().with_max_len(1).for_each(|(row, triangles)| {
            let entries = ranges.iter().flat_map(|range| range.row(row));
            triangles.sort(cells.across.count, entries.map(|entry| entry.column_and_item()));
        });
        counts.pairs += triangle_rows.iter().map(|row| row.items().len() as u64).sum::<u64>();
    }
}

/// What triangles are listed in.
struct Listing<'a> {
    mapped: Mapped<'a>,
    triangles: Triangles<'a>,
    opacity: &'a OpacityOfSides<'a>,
    /// How far a point may be from its cell.
    margin: f32,
    point_rows: &'a [PointRow],
}

impl Listing<'_> {
    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, range: &mut Range, ids: Ids<usize>) {
        range.bins.unsorted.clear();
        range.large.clear();
        let end = ids.end;
        for first in ids.step_by(LANES) {
            let triangles = &self.triangles.indices[first..end.min(first + LANES)];
            let survivors = range.batch.set_up(simd, &self.mapped, triangles, 0);
            for lane in bits_of(survivors.small) {
                let id = (first + lane) as u32;
                if self.opacity.is_there(id) {
                    self.list_small(range, lane, id);
                }
            }
            for lane in bits_of(survivors.large) {
                self.list_large(range, (first + lane) as u32);
            }
        }
    }

    /// Lists the triangle in a lane of the batch in the cells that its bounds cover.
    #[inline(always)]
    fn list_small(&self, range: &mut Range, lane: usize, id: u32) {
        let Range { bins, batch, .. } = range;
        let Cells { across, down, .. } = self.mapped.cells;
        let range = |[low, high]: &[[f32; BATCH]; 2]| [low[lane] - self.margin, high[lane] + self.margin];
        let [left, right] = range(&batch.x_range).map(|at| across.cell(at));
        let [top, bottom] = range(&batch.y_range).map(|at| down.cell(at));
        let columns = left..=right;
        for row in top..=bottom {
            let farthest = &self.point_rows[row].farthest[columns.clone()];
            for (column, &farthest) in columns.clone().zip(farthest) {
                if farthest < batch.nearest[lane] {
                    bins.unsorted.push(Entry { column: column as u16, row: row as u16, item: id });
                }
            }
        }
    }

    /// Lists a triangle row by row in the cells that it covers itself.
    #[cold]
    #[inline(never)]
    fn list_large(&self, range: &mut Range, id: u32) {
        let Ok(corners) = self.triangles.usable_corners(id) else { return };
        if !self.opacity.is_there(id) {
            return;
        }
        let cells = self.mapped.cells;
        for plane in planes(self.mapped.face, corners).into_iter().flatten() {
            let item = LARGE | range.large.len() as u32;
            let before = range.bins.unsorted.len();
            let [low, high] = plane.bounds[1];
            for row in cells.down.cell(low - self.margin)..=cells.down.cell(high + self.margin) {
                let Some(([left, right], nearest)) = plane.span(cells, row) else { continue };
                let columns = cells.across.cell(left - self.margin)..=cells.across.cell(right + self.margin);
                let farthest = &self.point_rows[row].farthest[columns.clone()];
                for (column, &farthest) in columns.zip(farthest) {
                    if farthest < nearest {
                        range.bins.unsorted.push(Entry { column: column as u16, row: row as u16, item });
                    }
                }
            }
            if range.bins.unsorted.len() > before {
                range.large.push((id, plane));
            }
        }
    }
}
