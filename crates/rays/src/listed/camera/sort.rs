use super::drop::Range;
use super::list::Pair;
use crate::camera_grid::bins::bytes_of;
use crate::counting_sort::{count, next_index};

/// The cells of one tile of the [`TileOrder`](crate::TileOrder).
#[derive(Clone, Debug, Default)]
pub(super) struct TileCells {
    /// Where each cell's triangles start, and where the last one's end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl TileCells {
    /// The triangles of cells that follow each other, given their indices in the tile.
    #[inline(always)]
    pub(super) fn cells(&self, cells: std::ops::Range<usize>) -> &[u32] {
        &self.triangles[self.starts[cells.start] as usize..self.starts[cells.end] as usize]
    }

    /// How many triangles all cells list together.
    pub(super) fn pairs(&self) -> usize {
        self.triangles.len()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + bytes_of(&self.starts) + bytes_of(&self.triangles)
    }

    /// Sorts what all ranges have for tile `tile` by its `cells` cells. Each cell's triangles stay in order.
    pub(super) fn sort(&mut self, ranges: &[Range], tile: usize, cells: usize) {
        let pairs = || ranges.iter().flat_map(|range| range.pairs_of(tile));
        let count = count(&mut self.starts, cells, pairs().map(Pair::cell_in_tile));
        self.triangles.resize(count, 0);
        for pair in pairs() {
            self.triangles[next_index(&mut self.starts, pair.cell_in_tile())] = pair.triangle;
        }
    }
}

impl Range {
    /// Sorts the pairs by tile, of which there are `tiles`. Each tile's pairs stay in order.
    pub(super) fn sort_by_tile(&mut self, tiles: usize) {
        let Self { unsorted, pairs, starts, .. } = self;
        pairs.resize(count(starts, tiles, unsorted.iter().map(Pair::tile)), Pair::default());
        for pair in unsorted {
            pairs[next_index(starts, pair.tile())] = *pair;
        }
    }

    /// The pairs of a tile.
    fn pairs_of(&self, tile: usize) -> &[Pair] {
        &self.pairs[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }
}
