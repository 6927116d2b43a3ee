use crate::dispatch;
use crate::parallel::Parallel;
use fearless_simd::prelude::*;
use fearless_simd::u32x16;
use rayon::prelude::*;

use super::TileOrder;
use crate::simd::SimdLevel;

/// The triangle and depth that each pixel of an image sees: the answer of [`Structure::see`](crate::Structure::see).
///
/// Both lists are in [`TileOrder`], which gives a pixel's index. 8 bytes a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenPixels {
    order: TileOrder,
    /// The nearest triangle, at equal distance the one with the lowest id; [`SeenPixels::NONE`] for none.
    pub triangle: Vec<u32>,
    /// About 1/t of the hit, where t is the depth along [`Camera::forward`](crate::Camera::forward), with a relative error
    /// of at most [`SeenPixels::RELATIVE_ERROR`]. NaN for no hit, and for hits with t outside of 10⁻³⁰ … 10³⁰.
    pub inverse_depth: Vec<f32>,
}

impl SeenPixels {
    /// Id that stands for no triangle.
    pub const NONE: u32 = u32::MAX;

    /// Error bound of `inverse_depth`, relative to the true 1/t.
    pub const RELATIVE_ERROR: f32 = 1.0 / (1 << 19) as f32;

    /// Makes room for an image and keeps the memory. The pixels' values are undefined until a structure writes them.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.order = TileOrder::new(width, height);
        self.triangle.resize(self.order.slots(), Self::NONE);
        self.inverse_depth.resize(self.order.slots(), f32::NAN);
    }

    /// The order in which pixels are stored.
    #[must_use]
    pub fn order(&self) -> TileOrder {
        self.order
    }

    /// The triangle that the pixel in column `x` and row `y` shows, or [`SeenPixels::NONE`].
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn triangle_at(&self, x: u32, y: u32) -> u32 {
        self.triangle[self.order.index(x, y)]
    }

    /// A word for each block of 4×4 pixels, with a bit for each that shows a triangle: the first pixel in the lowest bit.
    pub fn shown(&self) -> impl ExactSizeIterator<Item = u16> + '_ {
        self.triangle.chunks_exact(TileOrder::BLOCK_PIXELS).map(Self::shown_of)
    }

    /// The same for the ids of one block.
    #[inline(always)]
    pub fn shown_of(block: &[u32]) -> u16 {
        block.iter().rev().fold(0, |bits, &id| bits << 1 | u16::from(id != Self::NONE))
    }

    /// Turns words with a bit for each shadowed point into words with a bit for each pixel that shows a lit point.
    pub fn light_the_rest(&self, shadowed: &mut [u16], level: SimdLevel) {
        const CHUNK: usize = 4096;
        let pixels = self.triangle.par_chunks(CHUNK * TileOrder::BLOCK_PIXELS);
        shadowed.par_chunks_mut(CHUNK).zip(pixels).each(|(words, pixels)| {
            dispatch!(level, simd => {
                let none = u32x16::splat(simd, Self::NONE);
                for (word, block) in words.iter_mut().zip(pixels.chunks_exact(TileOrder::BLOCK_PIXELS)) {
                    *word = u32x16::from_slice(simd, block).simd_ne(none).to_bitmask() as u16 & !*word;
                }
            });
        });
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.triangle.as_slice()) + size_of_val(self.inverse_depth.as_slice())
    }

    /// The [`inverse_depth`](Self::inverse_depth) of a hit at `t`.
    #[must_use]
    pub fn inverse_of(t: f64) -> f32 {
        let inverse = 1.0 / t;
        if (1e-30..=1e30).contains(&inverse) { inverse as f32 } else { f32::NAN }
    }
}
