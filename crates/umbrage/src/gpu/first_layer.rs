use rayon::prelude::*;
use umbrage_gpu::{Band, Buffer, CameraGrid, Gpu, GpuError, LightGrid, Recorder};
use umbrage_rays::SeenPixels;

use crate::cpu::LightMask;

/// What pixels show first and which lights reach it, kept on the GPU: shading and later layers replace it.
#[derive(Debug)]
pub(super) struct FirstLayer {
    seen: Buffer,
    lit: Buffer,
}

impl FirstLayer {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { seen: Buffer::storage(gpu, "first seen"), lit: Buffer::storage(gpu, "first lit") }
    }

    /// Records that what the grids have found is kept.
    ///
    /// # Errors
    /// Where it needs more than one buffer of the device has room for.
    pub(super) fn record(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        camera: &CameraGrid,
        lights: &LightGrid,
    ) -> Result<(), GpuError> {
        for (kept, found, words) in [
            (&mut self.seen, camera.seen(), camera.slots()),
            (&mut self.lit, lights.lit(), u64::from(lights.light_count()) * u64::from(lights.mask_words())),
        ] {
            kept.reserve(gpu, 4 * words)?;
            recorder.copy_words(found, kept, words);
        }
        Ok(())
    }

    /// Each slot's triangle.
    pub(super) fn seen(&self) -> &Buffer {
        &self.seen
    }

    /// Fetches it for a band. How many pixels show something.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(super) fn fetch(
        &self,
        gpu: &Gpu,
        band: &Band,
        seen: &mut SeenPixels,
        masks: &mut [LightMask],
    ) -> Result<u64, GpuError> {
        let order = band.order();
        // Bands are whole rows of tiles, which follow each other.
        let first = seen.order().place(0, band.rows.start);
        let of_band = &mut seen.triangle[first..first + order.places()];
        self.seen.read_into(gpu, of_band)?;
        let shown = of_band.par_iter_mut().enumerate().filter_map(|(slot, triangle)| {
            if order.pixel(slot).is_none() {
                *triangle = SeenPixels::NONE;
            }
            (*triangle != SeenPixels::NONE).then_some(())
        });
        let shown = shown.count() as u64;

        let words = order.places() / 32;
        let bits: Vec<u32> = self.lit.read(gpu, words * masks.len())?;
        for (mask, bits) in masks.iter_mut().zip(bits.chunks_exact(words)) {
            mask.set_words(band.rows.start, bits);
        }
        Ok(shown)
    }
}
