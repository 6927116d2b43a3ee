use std::ops::Range;

use super::TileOrder;

/// The work of finding one pixel's triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCounts {
    /// Triangles tested on the pixel's sample.
    pub tested: u32,
    /// Cells with triangles that were searched.
    pub cells: u32,
    /// Triangles that the filter left undecided.
    pub undecided: u32,
    /// Pairs of a triangle and a cell that are listed in the pixel's tile, tested or not: the same for all pixels of a tile.
    /// Triangles that are tested during setup aren't listed.
    pub pairs: u32,
}

/// The work of finding each pixel's triangle, in [`TileOrder`]: Guntury and Narayanan 2010, Figure 2.
///
/// 16 bytes a pixel.
#[derive(Clone, Debug, Default)]
pub struct PixelWork {
    order: TileOrder,
    counts: Vec<[u32; KINDS]>,
}

impl PixelWork {
    /// The work of the pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> PixelCounts {
        let [tested, cells, undecided, pairs] = self.counts[self.order.index(x, y)];
        PixelCounts { tested, cells, undecided, pairs }
    }

    /// Clears the counts for an image and returns them for a trace to add to.
    pub fn start(&mut self, order: TileOrder) -> &mut [[u32; KINDS]] {
        self.order = order;
        self.counts.clear();
        self.counts.resize(order.slots(), [0; KINDS]);
        &mut self.counts
    }
}

/// The number of kinds of work.
pub(crate) const KINDS: usize = 4;

/// A count of [`PixelCounts`], as the index to add to.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    Tested,
    Cells,
    Undecided,
    Pairs,
}

/// The counts of the pixels of one tile. With `N` = 0 there are none, and counting costs nothing.
pub struct TileWork<'a, const N: usize>(pub &'a mut [[u32; N]]);

impl<const N: usize> TileWork<'_, N> {
    /// Adds to one kind of work at some pixels.
    #[inline(always)]
    pub fn add(&mut self, kind: Kind, pixels: Range<usize>, times: u32) {
        if N == KINDS {
            self.0[pixels].iter_mut().for_each(|counts| counts[kind as usize] += times);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_counted_where_it_is_done() {
        let mut work = PixelWork::default();
        let counts = work.start(TileOrder::new(100, 70));
        let mut tile = TileWork(&mut counts[TileOrder::TILE_PIXELS..2 * TileOrder::TILE_PIXELS]);
        tile.add(Kind::Tested, 0..16, 5);
        tile.add(Kind::Cells, 4..5, 2);
        tile.add(Kind::Undecided, 4..5, 1);
        tile.add(Kind::Pairs, 0..32, 9);
        assert_eq!(work.at(63, 0), PixelCounts::default());
        assert_eq!(work.at(64, 0), PixelCounts { tested: 5, cells: 0, undecided: 0, pairs: 9 });
        assert_eq!(work.at(64, 1), PixelCounts { tested: 5, cells: 2, undecided: 1, pairs: 9 });
        assert_eq!(work.at(68, 0), PixelCounts { pairs: 9, ..PixelCounts::default() });
        assert_eq!(work.at(72, 0), PixelCounts::default());
        work.start(TileOrder::new(100, 70));
        assert_eq!(work.at(64, 1), PixelCounts::default());
        // Without counts there is nothing to add to.
        TileWork::<0>(&mut [[]; 4]).add(Kind::Tested, 0..16, 1);
    }
}
