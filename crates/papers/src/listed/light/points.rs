use std::ops::Range;

use rayon::prelude::*;
use umbrage_rays::light_grid::LightCells;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::simd::lanes::bits_of;
use umbrage_rays::simd::vectors::LANES;

use super::cells::Axis;
use super::map::{LightMap, Place};
use super::pass::LightPass;
use super::{Bins, Entry, Lists};
use crate::listed::sorted::Sorted;

/// Up to 16 points of a cell, which the filter tests at once. About 320 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointGroup<P> {
    pub(super) points: P,
    /// The points' pixels.
    pub(super) indices: [u32; LANES],
    pub(super) count: u32,
    /// The slice of the farthest point.
    pub(super) slice: u32,
}

/// The points of a row of cells.
#[derive(Debug)]
pub(super) struct PointRow<P> {
    /// The points' pixels, by column and slice.
    indices: Sorted<u32>,
    pub(super) groups: Vec<PointGroup<P>>,
    /// For each cell its first group, and finally the end of the last cell's.
    starts: Vec<u32>,
    /// For each cell, an upper bound of its farthest point's distance from the light; −∞ without points.
    pub(super) farthest: Vec<f32>,
}

impl<P> Default for PointRow<P> {
    fn default() -> Self {
        Self { indices: Sorted::default(), groups: Vec::new(), starts: Vec::new(), farthest: Vec::new() }
    }
}

impl<P> PointRow<P> {
    pub(super) fn bytes(&self) -> usize {
        self.indices.bytes()
            + self.groups.capacity() * size_of::<PointGroup<P>>()
            + self.starts.capacity() * size_of::<u32>()
            + self.farthest.capacity() * size_of::<f32>()
    }

    /// The groups of a cell, from near to far.
    pub(super) fn of_cell(&self, column: usize) -> Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// Gathers the points of each cell in groups.
    fn gather<M: LightMap<Points = P>>(&mut self, columns: usize, slices: usize, map: &M) {
        let Self { indices, groups, starts, farthest } = self;
        groups.clear();
        starts.clear();
        farthest.clear();
        starts.push(0);
        for keys in (0..columns).map(|column| column * slices..(column + 1) * slices) {
            let (mut most, mut slice, mut end) = (f32::NEG_INFINITY, 0, indices.range(keys.clone()).start);
            for chunk in indices.of(keys.clone()).chunks(LANES) {
                end += chunk.len();
                while indices.range(keys.start..keys.start + slice + 1).end < end {
                    slice += 1;
                }
                let mut padded = [0; LANES];
                padded[..chunk.len()].copy_from_slice(chunk);
                most = chunk.iter().map(|&index| map.place(index).farthest).fold(most, f32::max);
                let points = map.gather(chunk);
                groups.push(PointGroup { points, indices: padded, count: chunk.len() as u32, slice: slice as u32 });
            }
            starts.push(groups.len() as u32);
            farthest.push(most);
        }
    }
}

impl<M: LightMap> Lists<M> {
    /// Sorts the points of the face by cell (§4.2), and in a cell by slice, and gathers them there.
    pub(super) fn sort_points(&mut self, pass: &LightPass) {
        const MOST_RANGES: usize = 64;
        self.axes = self.map.divide(pass, &self.options);
        let Self { map, axes: [across, down], slices, point_bins, point_rows, options, .. } = self;
        let (map, members) = (&*map, &pass.members);
        let length = members.len().div_ceil(MOST_RANGES).max(1);
        let places = |range: usize| {
            let blocks = range * length..((range + 1) * length).min(members.len());
            let index = |block: usize, lane: usize| (block * LANES + lane) as u32;
            let indices = blocks.flat_map(move |block| bits_of(members[block]).map(move |lane| index(block, lane)));
            indices.map(|index| (index, map.place(index)))
        };
        let ranges = members.len().div_ceil(length);
        *slices = Axis::new([0.0; 2], 1);
        if options.slices() > 1 {
            let nothing = || [f32::INFINITY, f32::NEG_INFINITY];
            let both = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            let depths = |range| places(range).fold(nothing(), |all, (_, place)| both(all, [place.farthest; 2]));
            let depths = (0..ranges).into_par_iter().map(depths).reduce(nothing, both);
            *slices = Axis::new(depths, options.slices() as usize);
        }
        let slices = *slices;
        point_bins.resize_with(ranges, Bins::default);
        point_bins.par_iter_mut().enumerate().with_max_len(1).each(|(range, bins)| {
            bins.unsorted.clear();
            for (item, Place { at: [x, y], farthest, .. }) in places(range) {
                let key = (across.cell(x) * slices.count + slices.cell(farthest)) as u16;
                bins.unsorted.push(Entry { key, row: down.cell(y) as u16, item });
            }
            bins.sort(down.count);
        });
        point_rows.resize_with(down.count, PointRow::default);
        point_rows.par_iter_mut().enumerate().with_max_len(1).each(|(row, points)| {
            let entries = point_bins.iter().flat_map(|bins| bins.row(row));
            points.indices.sort(across.count * slices.count, entries.map(Entry::key_and_item));
            points.gather(across.count, slices.count, map);
        });
    }

    /// Adds the points of the face to `located`, each in the cell that it was sorted to.
    pub(super) fn add_located(&self, located: &mut LightCells) {
        let ([columns, rows], slices) = (self.axes.map(|axis| axis.count), self.slices.count);
        let points = self.point_rows.iter().enumerate().flat_map(|(row, points)| {
            (0..columns).flat_map(move |column| {
                let indices = points.indices.of(column * slices..(column + 1) * slices);
                indices.iter().map(move |&index| (index as usize, [column, row], self.map.place(index).distance))
            })
        });
        located.add_face([columns, rows], |distances| self.map.light_face([columns, rows], distances), points);
    }
}
