/// The order in which an image's pixels are stored: neighbours in the image are near in memory.
///
/// Tiles of 64×64 pixels follow each other in rows; so do blocks of 4×4 pixels in a tile, and pixels in a block. Tiles at
/// the right and lower border are whole: some of their slots stand for no pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileOrder {
    width: u32,
    height: u32,
}

impl TileOrder {
    /// Pixels a side of a tile.
    pub const TILE: u32 = 1 << Self::TILE_BITS;
    /// Pixels a side of a block.
    pub const BLOCK: u32 = 4;
    /// Pixels in a tile.
    pub const TILE_PIXELS: usize = (Self::TILE * Self::TILE) as usize;
    /// Pixels in a block.
    pub const BLOCK_PIXELS: usize = (Self::BLOCK * Self::BLOCK) as usize;
    /// Log₂ of the pixels a side of a tile.
    pub const TILE_BITS: u32 = 6;

    /// The order of an image of `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Columns and rows of tiles.
    #[must_use]
    pub fn tiles(&self) -> (u32, u32) {
        (self.width.div_ceil(Self::TILE), self.height.div_ceil(Self::TILE))
    }

    /// The number of slots: a multiple of [`TILE_PIXELS`](Self::TILE_PIXELS).
    #[must_use]
    pub fn slots(&self) -> usize {
        let (columns, rows) = self.tiles();
        columns as usize * rows as usize * Self::TILE_PIXELS
    }

    /// The index at which the pixel in column `x` and row `y` is stored.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, x: u32, y: u32) -> usize {
        let tile = (y >> Self::TILE_BITS) * self.tiles().0 + (x >> Self::TILE_BITS);
        tile as usize * Self::TILE_PIXELS + Self::index_in_tile(x, y) as usize
    }

    /// The index of a pixel in its tile.
    #[inline(always)]
    pub fn index_in_tile(x: u32, y: u32) -> u32 {
        const BLOCKS: u32 = TileOrder::TILE / TileOrder::BLOCK;
        let block = (y / Self::BLOCK % BLOCKS) * BLOCKS + x / Self::BLOCK % BLOCKS;
        block * Self::BLOCK_PIXELS as u32 + y % Self::BLOCK * Self::BLOCK + x % Self::BLOCK
    }

    /// Column and row of the slot at `index`; outside of the image for a slot without a pixel.
    #[inline(always)]
    #[must_use]
    pub fn column_and_row(&self, index: usize) -> (u32, u32) {
        const BLOCKS: u32 = TileOrder::TILE / TileOrder::BLOCK;
        let (tile, index) = ((index / Self::TILE_PIXELS) as u32, (index % Self::TILE_PIXELS) as u32);
        let columns = self.tiles().0.max(1);
        let (block, sample) = (index / Self::BLOCK_PIXELS as u32, index % Self::BLOCK_PIXELS as u32);
        let x = tile % columns * Self::TILE + block % BLOCKS * Self::BLOCK + sample % Self::BLOCK;
        let y = tile / columns * Self::TILE + block / BLOCKS * Self::BLOCK + sample / Self::BLOCK;
        (x, y)
    }

    /// Column and row of the pixel that is stored at `index`; `None` for a slot beyond the border.
    #[inline(always)]
    #[must_use]
    pub fn pixel(&self, index: usize) -> Option<(u32, u32)> {
        let (x, y) = self.column_and_row(index);
        (x < self.width && y < self.height).then_some((x, y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_an_index_of_its_own() {
        for (width, height) in [(1, 1), (64, 64), (65, 3), (200, 130), (0, 7), (7, 0)] {
            let order = TileOrder::new(width, height);
            let mut pixels: Vec<_> = (0..order.slots()).filter_map(|index| order.pixel(index)).collect();
            pixels.sort_unstable();
            let expected: Vec<_> = (0..width).flat_map(|x| (0..height).map(move |y| (x, y))).collect();
            assert_eq!(pixels, expected);
            assert!(pixels.iter().all(|&(x, y)| order.pixel(order.index(x, y)) == Some((x, y))));
        }
    }

    #[test]
    fn a_block_is_sixteen_slots_in_a_row() {
        let order = TileOrder::new(300, 200);
        let first = order.index(132, 68);
        assert_eq!(first % TileOrder::BLOCK_PIXELS, 0);
        assert_eq!(order.index(135, 68), first + 3);
        assert_eq!(order.index(132, 69), first + 4);
        assert_eq!(order.index(136, 68), first + 16);
        assert_eq!(order.index(64, 0), TileOrder::TILE_PIXELS);
        assert_eq!(order.index(0, 64), 5 * TileOrder::TILE_PIXELS);
    }
}
