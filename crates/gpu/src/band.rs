use std::ops::Range;

use umbrage_rays::{TileOrder, View};

use crate::Gpu;

/// Some rows of a view's image: what is worked on at once. Images that are too large for the buffers of a device are
/// rendered in several.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// The whole image.
    pub view: View,
    /// Its rows; the first is a multiple of [`TileOrder::TILE`].
    pub rows: Range<u32>,
}

impl From<&View> for Band {
    /// All rows.
    fn from(view: &View) -> Self {
        Self { view: *view, rows: 0..view.height }
    }
}

impl Band {
    /// The most that any stage of the grids and of shading holds for a pixel in one buffer: three planes of the film. A fourth one, of what is shown as it
    /// is, is for those who keep it to ask for.
    pub const PIXEL_BYTES: u64 = 48;

    /// Bands of a view that fit a device, from the top, where no stage holds more than so many bytes for a pixel in one buffer.
    pub fn all(gpu: &Gpu, view: &View, pixel_bytes: u64) -> impl Iterator<Item = Self> + use<> {
        let width = u64::from(view.width.next_multiple_of(TileOrder::TILE));
        let rows = gpu.max_binding_bytes() / (width * pixel_bytes);
        let rows = (rows as u32).min(view.height.next_multiple_of(TileOrder::TILE)) / TileOrder::TILE * TileOrder::TILE;
        // Where not even one row of tiles fits, buffers will say so.
        let (view, rows) = (*view, rows.max(TileOrder::TILE));
        (0..view.height)
            .step_by(rows as usize)
            .map(move |first| Self { view, rows: first..(first + rows).min(view.height) })
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.view.width, self.rows.len() as u32]
    }

    /// Where its pixels are stored.
    #[must_use]
    pub fn order(&self) -> TileOrder {
        TileOrder::new(self.view.width, self.rows.len() as u32)
    }
}
