use umbrage_rays::shot::TileOrder;

/// The division of the view into cells of the camera's grid (Guntury and Narayanan 2010, §3).
///
/// A cell is a sorting tile between two depths. Tracing tiles of k × k sorting tiles are searched together, which is the
/// paper's indirect mapping: on its GPU k² sorting tiles share a block of threads; here they share the set-up of triangles,
/// 16 at a time, which short lists alone would leave half empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Log₂ of the pixels a side of a sorting tile.
    pub(super) sorting_bits: u32,
    tracing_bits: u32,
    slices: u32,
}

impl Default for Cells {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Cells {
    /// The best by measurement.
    pub const DEFAULT: Self = Self { sorting_bits: 4, tracing_bits: 2, slices: 8 };
    /// The largest number of slices.
    pub const MOST_SLICES: u32 = 64;
    /// Pixels a side of the smallest sorting tile.
    pub const SMALLEST_TILE: u32 = 8;
    /// Pixels a side of the largest sorting or tracing tile.
    pub const LARGEST_TILE: u32 = TileOrder::TILE;

    /// Sorting tiles of `sorting_tile` × `sorting_tile` pixels (8, 16, 32 or 64), `tracing_tiles` × `tracing_tiles` of
    /// them to a tracing tile (a power of two; a tracing tile has at most 64 × 64 pixels), and `slices` depth slices
    /// (1 to [`Cells::MOST_SLICES`]).
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn new(sorting_tile: u32, tracing_tiles: u32, slices: u32) -> Result<Self, ImpossibleCells> {
        let sizes = Self::SMALLEST_TILE..=Self::LARGEST_TILE;
        let possible = sorting_tile.is_power_of_two()
            && sizes.contains(&sorting_tile)
            && tracing_tiles.is_power_of_two()
            && tracing_tiles <= Self::LARGEST_TILE / sorting_tile
            && (1..=Self::MOST_SLICES).contains(&slices);
        if possible {
            Ok(Self { sorting_bits: sorting_tile.ilog2(), tracing_bits: tracing_tiles.ilog2(), slices })
        } else {
            Err(ImpossibleCells { sorting_tile, tracing_tiles, slices })
        }
    }

    /// Pixels a side of a sorting tile.
    #[must_use]
    pub fn sorting_tile(&self) -> u32 {
        1 << self.sorting_bits
    }

    /// Sorting tiles a side of a tracing tile: the paper's k.
    #[must_use]
    pub fn tracing_tiles(&self) -> u32 {
        1 << self.tracing_bits
    }

    /// Depth slices.
    #[must_use]
    pub fn slices(&self) -> u32 {
        self.slices
    }

    /// Log₂ of the sorting tiles a side of a [`TileOrder`] tile.
    pub(super) fn bits_in_tile(&self) -> u32 {
        TileOrder::TILE_BITS - self.sorting_bits
    }

    /// The number of cells in a [`TileOrder`] tile.
    pub(super) fn in_tile(&self) -> usize {
        (self.slices << (2 * self.bits_in_tile())) as usize
    }

    /// The index in its [`TileOrder`] tile of the first cell of a sorting tile, given its column and row in the tile.
    #[inline(always)]
    pub(super) fn first_in_tile(&self, column: u32, row: u32) -> u32 {
        ((row << self.bits_in_tile()) + column) * self.slices
    }
}

/// Numbers that no [`Cells`] can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{tracing_tiles} × {tracing_tiles} sorting tiles of {sorting_tile} pixels and {slices} slices: tiles have 8, 16, 32 or \
     64 pixels a side, a power of two of them makes at most 64 pixels, and there are 1 to {} slices",
    Cells::MOST_SLICES
)]
pub struct ImpossibleCells {
    /// Pixels a side of a sorting tile.
    pub sorting_tile: u32,
    /// Sorting tiles a side of a tracing tile.
    pub tracing_tiles: u32,
    /// Depth slices.
    pub slices: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tiles_that_fill_the_image_order_are_possible() {
        for sorting_tile in 0..=130 {
            for tracing_tiles in 0..=20 {
                let fits = [8, 16, 32, 64].contains(&sorting_tile)
                    && [1, 2, 4, 8].contains(&tracing_tiles)
                    && sorting_tile * tracing_tiles <= 64;
                assert_eq!(Cells::new(sorting_tile, tracing_tiles, 3).is_ok(), fits, "{sorting_tile} {tracing_tiles}");
            }
        }
        assert!(Cells::new(8, 1, 0).is_err() && Cells::new(8, 1, 65).is_err());
        let cells = Cells::new(16, 2, 5).expect("possible cells");
        assert_eq!((cells.sorting_tile(), cells.tracing_tiles(), cells.slices()), (16, 2, 5));
        assert_eq!(cells.in_tile(), 80);
        assert_eq!(cells.first_in_tile(3, 2), 55);
    }
}
