use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightCells, LightSource, ListedLightOptions, Ray, SeenImage, SeenPixels, TileOrder, View};
use umbrage_scene::{Frame, Light, ShadowingPoints};

use super::single_rays::SingleRays;
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

    /// Takes over a bit for each place from a row of tiles on, the first in the lowest bit of its word.
    #[cfg(feature = "gpu")]
    pub(crate) fn set_words(&mut self, first_row: u32, words: &[u32]) {
        let first = self.order.place(0, first_row) / TileOrder::BLOCK_PLACES;
        for (blocks, word) in self.blocks[first..].chunks_exact_mut(2).zip(words) {
            blocks.copy_from_slice(&[*word as u16, (word >> 16) as u16]);
        }
    }

    /// Lights every pixel that shows a triangle.
    fn light_all(&mut self, seen: &SeenPixels) {
        for (block, shown) in self.blocks.iter_mut().zip(seen.triangle.chunks_exact(TileOrder::BLOCK_PLACES)) {
            let bits = shown.iter().zip(0..).map(|(&triangle, bit)| u16::from(triangle != SeenPixels::NONE) << bit);
            *block = bits.fold(0, |all, bit| all | bit);
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
    pub(super) fn shadow_points(&mut self, frame: &Frame, lights: &[Light], view: &View, sample: &Sample) {
        self.lit.resize(lights.len(), LightMask::default());
        self.lit.iter_mut().for_each(|mask| mask.resize(self.seen.order()));
        match self.structure {
            Structure::Perspective => self.shadow_through_grids(frame, lights, view, sample),
            Structure::Listed { light, .. } => self.shadow_through_lists(frame, lights, view, sample, light),
            Structure::Grid(_) => self.shadow_through_packets(frame, lights, view, sample),
            Structure::KdTree(options) if options.lazy_below == 0 => {
                self.shadow_through_tree(frame, lights, view, sample);
            }
            Structure::KdTree(_) | Structure::Bvh => self.shadow_ray_by_ray(frame, lights, view, sample),
        }
        for (light, mask) in lights.iter().zip(&mut self.lit) {
            if !light.casts_shadow {
                mask.light_all(&self.seen);
            }
        }
        let shadowing = lights.iter().filter(|light| light.casts_shadow).count();
        let points = self.seen.triangle.par_iter().filter(|&&triangle| triangle != SeenPixels::NONE).count();
        self.shadow_rays += (points * shadowing) as u64;
    }

    /// Finds in which cell of a light's grid each point is that was seen last; structures for all rays have no cells.
    pub(super) fn locate(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        light: &LightSource,
        cells: &mut LightCells,
    ) {
        let Self { structure, light_grid, listed_light_grid, seen, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        match structure {
            Structure::Perspective => {
                light_grid.survey(&image);
                light_grid.locate(&image, light, cells);
            }
            Structure::Listed { light: options, .. } => {
                listed_light_grid.set_options(*options);
                listed_light_grid.survey(&image);
                listed_light_grid.locate(&image, light, cells);
            }
            Structure::Grid(_) | Structure::KdTree(_) | Structure::Bvh => *cells = LightCells::default(),
        }
    }

    fn shadow_through_grids(&mut self, frame: &Frame, lights: &[Light], view: &View, sample: &Sample) {
        let Self { light_grid, seen, lit, light_work, settled_tests: [_, settled], .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        light_grid.survey(&image);
        light_work.clear();
        light_work.resize(lights.len(), LightWork::default());
        for ((light, mask), work) in lights.iter().zip(lit).zip(light_work) {
            if light.casts_shadow {
                let is_opaque = |id| frame.is_opaque(id);
                light_grid.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
                *settled += light_grid.counts().asked;
                *work = LightWork { counts: light_grid.counts(), seconds: light_grid.seconds() };
            }
        }
    }

    fn shadow_through_lists(
        &mut self,
        frame: &Frame,
        lights: &[Light],
        view: &View,
        sample: &Sample,
        options: ListedLightOptions,
    ) {
        let Self { listed_light_grid, seen, lit, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        listed_light_grid.set_options(options);
        listed_light_grid.survey(&image);
        for (light, mask) in shadowing(lights, lit) {
            let is_opaque = |id| frame.is_opaque(id);
            listed_light_grid.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
        }
    }

    fn shadow_through_packets(&mut self, frame: &Frame, lights: &[Light], view: &View, sample: &Sample) {
        let Self { uniform_grid, seen, lit, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        for (light, mask) in shadowing(lights, lit) {
            let is_opaque = |id| frame.is_opaque(id);
            uniform_grid.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
        }
    }

    fn shadow_through_tree(&mut self, frame: &Frame, lights: &[Light], view: &View, sample: &Sample) {
        let Self { kd_tree, seen, lit, .. } = self;
        let image = SeenImage { triangles: frame.triangles(), view: *view, offset_pixels: sample.offset_pixels, seen };
        for (light, mask) in shadowing(lights, lit) {
            let is_opaque = |id| frame.is_opaque(id);
            kd_tree.shadow(&image, &light.source, is_opaque, &ShadowingPoints(frame), &mut mask.blocks);
        }
    }

    fn shadow_ray_by_ray(&mut self, frame: &Frame, lights: &[Light], view: &View, sample: &Sample) {
        let mut lit = std::mem::take(&mut self.lit);
        let (rays, seen) = (self.single_rays(), &self.seen);
        let order = seen.order();
        for (light, mask) in shadowing(lights, &mut lit) {
            let blocks = mask.blocks.par_iter_mut().zip(seen.triangle.par_chunks(TileOrder::BLOCK_PLACES));
            blocks.enumerate().for_each(|(block, (bits, seen))| {
                *bits = 0;
                for (place, &seen) in seen.iter().enumerate() {
                    let Some((x, y)) = order.pixel(block * TileOrder::BLOCK_PLACES + place) else { continue };
                    let ray = sample.ray(view, x, y);
                    let Some(hit) = hit_of(frame, &ray, seen) else { continue };
                    let lit = !is_blocked(rays, frame, light, &ray, &hit);
                    *bits |= u16::from(lit) << place;
                }
            });
        }
        self.lit = lit;
    }
}

/// The lights that triangles keep away, with their masks.
fn shadowing<'a>(
    lights: &'a [Light],
    lit: &'a mut [LightMask],
) -> impl Iterator<Item = (&'a Light, &'a mut LightMask)> {
    lights.iter().zip(lit).filter(|(light, _)| light.casts_shadow)
}

/// Whether something stands between `light` and the point that `ray` has hit.
pub(super) fn is_blocked(rays: SingleRays<'_>, frame: &Frame, light: &Light, ray: &Ray, hit: &Hit) -> bool {
    if !light.casts_shadow {
        return false;
    }
    let shadow_ray = ShadowRay::new(&light.source, HitPoint::new(ray, hit.t));
    rays.blocked(frame.triangles(), &shadow_ray, hit.triangle, |id, barycentric| frame.casts_shadow(id, barycentric))
}
