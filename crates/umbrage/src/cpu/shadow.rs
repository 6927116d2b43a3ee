use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, Ray, SeenImage, SeenPixels, View};
use umbrage_scene::{Frame, Light};

use super::{Cpu, hit_of};
use crate::Structure;
use crate::sampling::Sample;

/// Which pixels a light reaches: one bit each, in pixel order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMask {
    words: Vec<u64>,
}

impl LightMask {
    const PIXELS: usize = u64::BITS as usize;

    /// Whether nothing stands between the light and what a pixel shows, given the pixel's place in the rows of the
    /// image; false where it shows no triangle. Cones and ranges of lights don't count here.
    ///
    /// # Panics
    /// If `pixel` is out of range.
    #[must_use]
    pub fn is_lit(&self, pixel: usize) -> bool {
        self.words[pixel / Self::PIXELS] >> (pixel % Self::PIXELS) & 1 == 1
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice())
    }
}

impl Cpu {
    /// Finds which of the points that pixels show each light reaches.
    pub(crate) fn shadow(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        self.lit.resize(frame.lights.len(), LightMask::default());
        for mask in &mut self.lit {
            mask.words.resize(self.seen.triangle.len().div_ceil(LightMask::PIXELS), 0);
        }
        match self.structure {
            Structure::Perspective => self.shadow_through_grids(frame, view, sample),
            Structure::Bvh => self.shadow_through_hierarchy(frame, view, sample),
        }
        let points = self.seen.triangle.par_iter().filter(|&&triangle| triangle != SeenPixels::NONE).count();
        self.shadow_rays += (points * frame.lights.len()) as u64;
    }

    fn shadow_through_grids(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { light_grid, seen, lit, .. } = self;
        let image = SeenImage {
            triangles: frame.triangles(),
            view: *view,
            offset_pixels: sample.offset_pixels,
            triangle_of_pixel: &seen.triangle,
        };
        light_grid.locate(&image);
        for (light, mask) in frame.lights.iter().zip(lit) {
            let is_opaque = |id| frame.is_opaque(id);
            let casts = |id, barycentric| frame.casts_shadow(id, barycentric);
            light_grid.shadow(&image, &light.source, is_opaque, casts, &mut mask.words);
        }
    }

    fn shadow_through_hierarchy(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { bvh, seen, lit, .. } = self;
        for (light, mask) in frame.lights.iter().zip(lit) {
            let words = mask.words.par_iter_mut().zip(seen.triangle.par_chunks(LightMask::PIXELS)).enumerate();
            words.for_each(|(chunk, (word, seen))| {
                *word = 0;
                for (place, &seen) in seen.iter().enumerate() {
                    let ray = sample.ray(view, chunk * LightMask::PIXELS + place);
                    let Some(hit) = hit_of(frame, &ray, seen) else { continue };
                    let lit = !is_blocked(bvh, frame, light, &ray, &hit);
                    *word |= u64::from(lit) << place;
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
