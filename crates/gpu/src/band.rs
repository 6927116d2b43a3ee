use std::ops::Range;

use umbrage_rays::{TileOrder, View};

use crate::Gpu;

/// Rows of a view's image that are rendered at once. An image that is too large for a device's buffers is rendered in
/// several bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// The whole image.
    pub view: View,
    /// Rows of the band; the first is a multiple of [`TileOrder::TILE`].
    pub rows: Range<u32>,
}

impl From<&View> for Band {
    /// All rows.
    fn from(view: &View) -> Self {
        Self { view: *view, rows: 0..view.height }
    }
}

impl Band {
    /// The most bytes per pixel that a stage of the grids or of shading keeps in one buffer: three planes of the film.
    /// A caller that keeps a fourth plane, for unlit pixels, has to ask for more.
    pub const PIXEL_BYTES: u64 = 48;

    /// Bands of a view from top to bottom, sized so that `pixel_bytes` bytes for each pixel fit one buffer of the device.
    pub fn all(gpu: &Gpu, view: &View, pixel_bytes: u64) -> impl Iterator<Item = Self> + use<> {
        let width = u64::from(view.width.next_multiple_of(TileOrder::TILE));
        let rows = gpu.max_binding_bytes() / (width * pixel_bytes);
        let rows = (rows as u32).min(view.height.next_multiple_of(TileOrder::TILE)) / TileOrder::TILE * TileOrder::TILE;
        // If not even one row of tiles fits, the buffers report it.
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

    /// Storage order of the band's pixels.
    #[must_use]
    pub fn order(&self) -> TileOrder {
        TileOrder::new(self.view.width, self.rows.len() as u32)
    }
}
