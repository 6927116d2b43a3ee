use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, ListedLightOptions, Ray, SeenImage, SeenPixels, TileOrder, View};
use umbrage_scene::{Frame, Light, ShadowingPoints};

use super::{Cpu, LightWork, hit_of};
use crate::Structure;
use crate::sampling::Sample;

/// Which pixels a light reaches: one bit each, in [`TileOrder`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMask {
    order: TileOrder,
    /// One for each block of pixels, the first pixel in the lowest bit.
    blocks: Vec<u16>,
}

impl LightMask {
    /// Whether nothing stands between the light and what the pixel in column `x` and row `y` shows; false where it
    /// shows no triangle. Cones and ranges of lights don't count here.
    ///
    /// # Panics
    /// If the pixel is outside of the image's tiles.
    #[must_use]
    pub fn is_lit(&self, x: u32, y: u32) -> bool {
        let place = self.order.place(x, y);
        self.blocks[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1
    }

    /// Which pixels of a block it reaches, the first one in the lowest bit.
    pub(super) fn block(&self, block: usize) -> u16 {
        self.blocks[block]
    }

    /// One for each block of pixels, the first pixel in the lowest bit.
    #[cfg(feature = "gpu")]
    pub(super) fn blocks(&self) -> &[u16] {
        &self.blocks
    }

    /// Takes over a bit for each place from a row of tiles on, the first in the lowest bit of its word.
    #[cfg(feature = "gpu")]
    pub(crate) fn set_words(&mut self, first_row: u32, words: &[u32]) {
        let first = self.order.place(0, first_row) / TileOrder::BLOCK_PLACES;
        for (blocks, word) in self.blocks[first..].chunks_exact_mut(2).zip(words) {
            blocks.copy_from_slice(&[*word as u16, (word >> 16) as u16]);
        }
    }

    pub(crate) fn resize(&mut self, order: TileOrder) {
        self.order = order;
        self.blocks.resize(order.places() / TileOrder::BLOCK_PLACES, 0);
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }
}

impl Cpu {
    /// Finds which of the points that pixels show each light reaches.
    pub(crate) fn shadow(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        self.lit.resize(frame.lights.len(), LightMask::default());
        self.lit.iter_mut().for_each(|mask| mask.resize(self.seen.order()));
        match self.structure {
            Structure::Perspective => self.shadow_through_grids(frame, view, sample),
            Structure::Listed { light, .. } => self.shadow_through_lists(frame, view, sample, light),
            Structure::Bvh => self.shadow_through_hierarchy(frame, view, sample),
        }
        let points = self.seen.triangle.par_iter().filter(|&&triangle| triangle != SeenPixels::NONE).count();
        self.shadow_rays += (points * frame.lights.len()) as u64;
    }

    fn shadow_through_grids(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { light_grid, seen, lit, light_work, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        light_grid.survey(&image);
        light_work.clear();
        for (light, mask) in frame.lights.iter().zip(lit) {
            let is_opaque = |id| frame.is_opaque(id);
            light_grid.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
            light_work.push(LightWork { counts: light_grid.counts(), seconds: light_grid.seconds() });
        }
    }

    fn shadow_through_lists(&mut self, frame: &Frame, view: &View, sample: &Sample, options: ListedLightOptions) {
        let Self { listed_light_grid, seen, lit, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        listed_light_grid.set_options(options);
        listed_light_grid.survey(&image);
        for (light, mask) in frame.lights.iter().zip(lit) {
            let is_opaque = |id| frame.is_opaque(id);
            listed_light_grid.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
        }
    }

    fn shadow_through_hierarchy(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { bvh, seen, lit, .. } = self;
        let order = seen.order();
        for (light, mask) in frame.lights.iter().zip(lit) {
            let blocks = mask.blocks.par_iter_mut().zip(seen.triangle.par_chunks(TileOrder::BLOCK_PLACES));
            blocks.enumerate().for_each(|(block, (bits, seen))| {
                *bits = 0;
                for (place, &seen) in seen.iter().enumerate() {
                    let Some((x, y)) = order.pixel(block * TileOrder::BLOCK_PLACES + place) else { continue };
                    let ray = sample.ray(view, x, y);
                    let Some(hit) = hit_of(frame, &ray, seen) else { continue };
                    let lit = !is_blocked(bvh, frame, light, &ray, &hit);
                    *bits |= u16::from(lit) << place;
                }
            });
        }
    }
}

/// Whether something stands between `light` and the point that `ray` has hit.
pub(super) fn is_blocked(bvh: &Bvh, frame: &Frame, light: &Light, ray: &Ray, hit: &Hit) -> bool {
    let shadow_ray = ShadowRay::new(&light.source, HitPoint::new(ray, hit.t));
    bvh.blocked(frame.triangles(), &shadow_ray, hit.triangle, |id, barycentric| frame.casts_shadow(id, barycentric))
}
