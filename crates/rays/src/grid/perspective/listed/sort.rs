use super::drop::Range;
use super::list::Pair;
use crate::grid::perspective::bins::bytes_of;

/// The cells of one tile of the [`TileOrder`](crate::TileOrder).
#[derive(Clone, Debug, Default)]
pub(super) struct TileCells {
    /// Where each cell's triangles start, and where the last one's end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl TileCells {
    /// The triangles of cells that follow each other, given their places in the tile.
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
            self.triangles[next_place(&mut self.starts, pair.cell_in_tile())] = pair.triangle;
        }
    }
}

impl Range {
    /// Sorts the pairs by tile, of which there are `tiles`. Each tile's pairs stay in order.
    pub(super) fn sort_by_tile(&mut self, tiles: usize) {
        let Self { unsorted, pairs, starts, .. } = self;
        pairs.resize(count(starts, tiles, unsorted.iter().map(Pair::tile)), Pair::default());
        for pair in unsorted {
            pairs[next_place(starts, pair.tile())] = *pair;
        }
    }

    /// The pairs of a tile.
    fn pairs_of(&self, tile: usize) -> &[Pair] {
        &self.pairs[self.starts[tile] as usize..self.starts[tile + 1] as usize]
    }
}

/// The first half of a counting sort: counts how often each of `keys` keys comes, and returns how often all do.
///
/// Once [`next_place`] was asked for each, `starts` holds where each key starts and, one further, where it ends.
fn count(starts: &mut Vec<u32>, keys: usize, of: impl Iterator<Item = usize>) -> usize {
    starts.clear();
    starts.resize(keys + 2, 0);
    // Counted two places on, so that handing out places moves each start to where it belongs.
    of.for_each(|key| starts[key + 2] += 1);
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
    sum as usize
}

/// Where the next one with this key belongs.
#[inline(always)]
fn next_place(starts: &mut [u32], key: usize) -> usize {
    let place = &mut starts[key + 1];
    *place += 1;
    *place as usize - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_sorts_keep_the_order_of_equal_keys() {
        let keys = [3_usize, 0, 3, 1, 5, 0, 3];
        let mut starts = vec![9; 2];
        let mut sorted = vec![usize::MAX; count(&mut starts, 7, keys.into_iter())];
        keys.iter().enumerate().for_each(|(item, &key)| sorted[next_place(&mut starts, key)] = item);
        assert_eq!(sorted, [1, 5, 3, 0, 2, 6, 4]);
        assert_eq!(starts[..8], [0, 2, 3, 3, 6, 6, 7, 7]);
    }
}
