use super::{SeenPixels, TileOrder};

/// The pixels of an image that a light reaches: the answer of [`Structure::shadow`](crate::Structure::shadow).
///
/// One bit a pixel, in [`TileOrder`]. It is set where the pixel shows a triangle and no other triangle stands between that
/// point and the light. A spot lights nothing outside of its [`Cone`](crate::Cone); a light's range plays no part.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMask {
    order: TileOrder,
    /// A word for each block of pixels, the first pixel in the lowest bit.
    blocks: Vec<u16>,
}

impl LightMask {
    /// Makes room for an image and keeps the memory. Its bits are undefined until a structure writes them.
    pub fn resize(&mut self, order: TileOrder) {
        self.order = order;
        self.blocks.resize(order.slots() / TileOrder::BLOCK_PIXELS, 0);
    }

    /// The order in which pixels are stored.
    #[must_use]
    pub fn order(&self) -> TileOrder {
        self.order
    }

    /// Whether the light reaches the point that the pixel in column `x` and row `y` shows; false where it shows no triangle.
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn is_lit(&self, x: u32, y: u32) -> bool {
        let index = self.order.index(x, y);
        self.blocks[index / TileOrder::BLOCK_PIXELS] >> (index % TileOrder::BLOCK_PIXELS) & 1 == 1
    }

    /// A word for each block of 4×4 pixels, with a bit for each that is lit: the first pixel in the lowest bit.
    #[must_use]
    pub fn blocks(&self) -> &[u16] {
        &self.blocks
    }

    /// The same, for a structure to write.
    pub fn blocks_mut(&mut self) -> &mut [u16] {
        &mut self.blocks
    }

    /// The number of lit pixels.
    #[must_use]
    pub fn count(&self) -> usize {
        self.blocks.iter().map(|block| block.count_ones() as usize).sum()
    }

    /// Lights every pixel that shows a triangle.
    pub fn light_all(&mut self, seen: &SeenPixels) {
        self.resize(seen.order());
        for (block, shown) in self.blocks.iter_mut().zip(seen.shown()) {
            *block = shown;
        }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }
}
