use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};

use super::block::{Block, Cells};
use super::lanes::LANES;
use super::map::Slab;
use super::{LightGrid, SimdLevel};

impl LightGrid {
    /// Empties all cells.
    pub(super) fn forget_points(&mut self) {
        self.blocks.clear();
        self.cells.ends.clear();
        self.cells.farthest.clear();
        self.cells.padding.clear();
    }

    /// Sorts the mapped points into cells and packs them into blocks: a counting sort for each band.
    pub(super) fn sort(&mut self, triangle_of_pixel: &[u32]) {
        let Self { slabs, cells, blocks, level, .. } = self;
        let bands = cells.bands();
        let count = (0..bands).map(|band| blocks_of(slabs, band)).sum();
        blocks.resize(count, Block::EMPTY);
        cells.farthest.resize(count, 0.0);
        cells.padding.resize(count, 0);
        let mut ends = std::mem::take(&mut cells.ends);
        ends.clear();
        ends.resize(cells.columns * cells.rows + 1, 0);
        let mut farthest = std::mem::take(&mut cells.farthest);
        let mut padding = std::mem::take(&mut cells.padding);
        let sorter = Sorter { slabs, cells, triangle_of_pixel, level: *level };
        let output = Bands { ends: &mut ends[1..], blocks, farthest: &mut farthest, padding: &mut padding };
        sorter.sort(0..bands, 0, output);
        (cells.ends, cells.farthest, cells.padding) = (ends, farthest, padding);
    }
}

fn points_of(slabs: &[Slab], band: usize) -> usize {
    slabs.iter().map(|slab| slab.bands[band].len()).sum()
}

fn blocks_of(slabs: &[Slab], band: usize) -> usize {
    points_of(slabs, band).div_ceil(LANES)
}

/// Where the sorted points of some bands go.
struct Bands<'a> {
    ends: &'a mut [u32],
    blocks: &'a mut [Block],
    farthest: &'a mut [f32],
    padding: &'a mut [u16],
}

struct Sorter<'a> {
    slabs: &'a [Slab],
    cells: &'a Cells,
    triangle_of_pixel: &'a [u32],
    level: SimdLevel,
}

impl Sorter<'_> {
    /// Sorts a range of bands, halving it until one is left; `first` is their first block.
    fn sort(&self, bands: std::ops::Range<usize>, first: usize, output: Bands<'_>) {
        if bands.len() == 1 {
            let level = self.level.0;
            return dispatch!(level, simd => self.sort_band(simd, bands.start, first, output));
        }
        let middle = bands.start + bands.len() / 2;
        let before = (bands.start..middle).map(|band| blocks_of(self.slabs, band)).sum();
        let cells = (middle - bands.start) * self.cells.rows_per_band * self.cells.columns;
        let (ends, later_ends) = output.ends.split_at_mut(cells);
        let (blocks, later_blocks) = output.blocks.split_at_mut(before);
        let (farthest, later_farthest) = output.farthest.split_at_mut(before);
        let (padding, later_padding) = output.padding.split_at_mut(before);
        let earlier = Bands { ends, blocks, farthest, padding };
        let later = Bands { ends: later_ends, blocks: later_blocks, farthest: later_farthest, padding: later_padding };
        rayon::join(
            || self.sort(bands.start..middle, first, earlier),
            || self.sort(middle..bands.end, first + before, later),
        );
    }

    #[inline(always)]
    fn sort_band<S: Simd>(&self, simd: S, band: usize, first_block: usize, output: Bands<'_>) {
        let Bands { ends, blocks, farthest, padding } = output;
        let first_cell = (band * self.cells.rows_per_band * self.cells.columns) as u32;
        ends.fill(0);
        for slab in self.slabs {
            slab.bands[band].iter().for_each(|point| ends[(point.cell - first_cell) as usize] += 1);
        }
        // Each cell's count becomes its beginning, and by counting up again its end.
        let first = (first_block * LANES) as u32;
        let mut sum = first;
        for end in ends.iter_mut() {
            (*end, sum) = (sum, sum + *end);
        }
        for point in self.slabs.iter().flat_map(|slab| &slab.bands[band]) {
            let end = &mut ends[(point.cell - first_cell) as usize];
            let place = (*end - first) as usize;
            *end += 1;
            let block = &mut blocks[place / LANES];
            let lane = place % LANES;
            block.x[lane] = point.x;
            block.y[lane] = point.y;
            block.nearness[lane] = point.nearness;
            block.pixel[lane] = point.pixel;
            block.triangle[lane] = self.triangle_of_pixel[point.pixel as usize];
        }
        let used = (sum - first) as usize % LANES;
        padding.fill(0);
        if let (Some(block), Some(padding), 1..) = (blocks.last_mut(), padding.last_mut(), used) {
            block.pixel[used..].fill(Block::PADDING);
            block.triangle[used..].fill(u32::MAX);
            block.x[used..].fill(0.0);
            block.y[used..].fill(0.0);
            block.nearness[used..].fill(f32::MAX);
            *padding = u16::MAX << used;
        }
        for (block, farthest) in blocks.iter().zip(farthest) {
            *farthest = f32x16::simd_from(simd, block.nearness).reduce_min();
        }
    }
}
