use rayon::prelude::*;
use umbrage_gpu::{Band, Buffer, Done, Fetch, Gpu, GpuError, Recorder};
use umbrage_rays::{LightMask, SeenPixels, TileOrder};

use super::finder::Found;

/// The pixels' first hits and the lights that reach them, kept on the GPU: shading and later layers overwrite the originals.
#[derive(Debug)]
pub(super) struct FirstLayer {
    seen: Buffer,
    lit: Buffer,
}

impl FirstLayer {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { seen: Buffer::storage(gpu, "first seen"), lit: Buffer::storage(gpu, "first lit") }
    }

    /// Records a copy of the results.
    ///
    /// # Errors
    /// Where it is larger than one buffer of the device.
    pub(super) fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, found: &Found<'_>) -> Result<(), GpuError> {
        let Found { seen, slots, lit, lit_words } = *found;
        for (kept, buffer, words) in [(&mut self.seen, seen, slots), (&mut self.lit, lit, lit_words)] {
            kept.reserve(gpu, 4 * words)?;
            recorder.copy_words(buffer, kept, words);
        }
        Ok(())
    }

    /// Each slot's triangle.
    pub(super) fn seen(&self) -> &Buffer {
        &self.seen
    }

    /// Fetches it for a band and `lights` lights.
    pub(super) fn fetch(&self, recorder: &mut Recorder<'_>, band: &Band, lights: usize) -> [Fetch; 2] {
        let slots = band.order().slots() as u64;
        [recorder.fetch(&self.seen, slots), recorder.fetch(&self.lit, slots / 32 * lights as u64)]
    }

    /// Stores the fetched results of a band; returns how many pixels show a triangle.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(super) fn take(
        done: &Done,
        [of_seen, of_lit]: [Fetch; 2],
        band: &Band,
        seen: &mut SeenPixels,
        masks: &mut [LightMask],
    ) -> Result<u64, GpuError> {
        let order = band.order();
        // Bands are whole rows of tiles, which follow each other.
        let first = seen.order().index(0, band.rows.start);
        let of_band = &mut seen.triangle[first..first + order.slots()];
        done.read_into(of_seen, of_band)?;
        let shown = of_band.par_iter_mut().enumerate().filter_map(|(slot, triangle)| {
            if order.pixel(slot).is_none() {
                *triangle = SeenPixels::NONE;
            }
            (*triangle != SeenPixels::NONE).then_some(())
        });
        let shown = shown.count() as u64;

        let words = order.slots() / 32;
        let bits: Vec<u32> = done.read(of_lit)?;
        for (mask, bits) in masks.iter_mut().zip(bits.chunks_exact(words)) {
            set_words(mask, band.rows.start, bits);
        }
        Ok(shown)
    }
}

/// Stores a bit for each pixel from a row of tiles on, the first in the lowest bit of its word.
fn set_words(mask: &mut LightMask, first_row: u32, words: &[u32]) {
    let first = mask.order().index(0, first_row) / TileOrder::BLOCK_PIXELS;
    for (blocks, word) in mask.blocks_mut()[first..].chunks_exact_mut(2).zip(words) {
        blocks.copy_from_slice(&[*word as u16, (word >> 16) as u16]);
    }
}
