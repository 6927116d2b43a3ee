use std::ops::RangeInclusive;

use rayon::prelude::*;
use umbrage_rays::Triangles;
use umbrage_rays::dispatch;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::shot::{Counts, OpacityOfSides};

use super::cells::Axis;
use super::map::LightMap;
use super::pass::LightPass;
use super::points::PointRow;
use super::trace::LARGE;
use super::{Bins, Entry, Lists};
use crate::listed::sorted::Sorted;

/// The entries of one range of triangles in cells.
pub(super) struct ListedRange<M: LightMap> {
    pub(super) bins: Bins,
    /// Its large triangles; their entries count from the range's first one.
    pub(super) large: Vec<(u32, M::Large)>,
    /// The number of large triangles of earlier ranges.
    large_before: u32,
    pub(super) batch: M::Batch,
}

impl<M: LightMap> Default for ListedRange<M> {
    fn default() -> Self {
        Self { bins: Bins::default(), large: Vec::new(), large_before: 0, batch: M::Batch::default() }
    }
}

impl<M: LightMap> ListedRange<M> {
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + self.bins.bytes() + self.large.capacity() * size_of::<(u32, M::Large)>()
    }

    /// The entries of a row; large triangles count from the first of all ranges.
    fn row(&self, row: usize) -> impl Iterator<Item = Entry> + Clone {
        let before = self.large_before;
        let counted = move |item: u32| if item & LARGE != 0 { item + before } else { item };
        self.bins.row(row).iter().map(move |entry| Entry { item: counted(entry.item), ..*entry })
    }
}

impl<M: LightMap> Lists<M> {
    /// Lists each triangle in the cells where it may shadow points, in the slice of its nearest point.
    pub(super) fn list(&mut self, pass: &mut LightPass, triangles: Triangles<'_>, opacity: &OpacityOfSides<'_>) {
        const SMALLEST_RANGE: usize = 4096;
        const MOST_RANGES: usize = 64;
        let Self { map, axes, slices, point_rows, ranges, large, .. } = self;
        let [across, down] = *axes;
        let listing = Listing { map, triangles, opacity, across, down, slices: *slices, point_rows };
        let count = triangles.len();
        // Ranges don't depend on the number of threads.
        ranges.resize_with(count.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES), ListedRange::default);
        let length = count.div_ceil(ranges.len());
        let level = pass.level;
        ranges.par_iter_mut().enumerate().with_max_len(1).each(|(index, range)| {
            let ids = (index * length).min(count)..((index + 1) * length).min(count);
            range.bins.unsorted.clear();
            range.large.clear();
            dispatch!(level, simd => M::list(simd, &listing, range, ids));
            range.bins.sort(down.count);
        });
        large.clear();
        for range in ranges {
            range.large_before = large.len() as u32;
            large.extend_from_slice(&range.large);
        }
        pass.counts.large_triangles += large.len() as u64;
    }

    /// Sorts pairs of triangles and cells by cell, and in a cell by slice.
    pub(super) fn sort_pairs(&mut self, counts: &mut Counts) {
        let Self { axes: [across, down], slices, ranges, triangle_rows, .. } = self;
        triangle_rows.resize_with(down.count, Sorted::default);
        triangle_rows.par_iter_mut().enumerate().with_max_len(1).each(|(row, triangles)| {
            let entries = ranges.iter().flat_map(|range| range.row(row));
            triangles.sort(across.count * slices.count, entries.map(|entry| entry.key_and_item()));
        });
        counts.pairs += triangle_rows.iter().map(|row| row.items().len() as u64).sum::<u64>();
    }
}

/// The inputs of listing triangles.
pub(super) struct Listing<'a, M: LightMap> {
    pub(super) map: &'a M,
    pub(super) triangles: Triangles<'a>,
    pub(super) opacity: &'a OpacityOfSides<'a>,
    pub(super) across: Axis,
    pub(super) down: Axis,
    slices: Axis,
    point_rows: &'a [PointRow<M::Points>],
}

impl<M: LightMap> Listing<'_, M> {
    /// Lists an item, no part of which is nearer to the light than `nearest`, in those cells of some columns and rows that
    /// have a point farther away.
    #[inline(always)]
    pub(super) fn list(
        &self,
        bins: &mut Bins,
        columns: &RangeInclusive<usize>,
        rows: RangeInclusive<usize>,
        nearest: f32,
        item: u32,
    ) {
        let slice = self.slices.cell(nearest);
        for row in rows {
            let farthest = &self.point_rows[row].farthest[columns.clone()];
            for (column, &farthest) in columns.clone().zip(farthest) {
                if nearest < farthest {
                    bins.unsorted.push(Entry {
                        key: (column * self.slices.count + slice) as u16,
                        row: row as u16,
                        item,
                    });
                }
            }
        }
    }
}
