use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Bvh, Hit, Ray, SeenPixels, View};
use umbrage_scene::{Frame, Light};

use super::{Cpu, hit_of};
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
        let Self { bvh, seen, lit, shadow_rays, .. } = self;
        let seen = &seen.triangle;
        lit.resize(frame.lights.len(), LightMask::default());
        for (light, mask) in frame.lights.iter().zip(lit) {
            mask.words.resize(seen.len().div_ceil(LightMask::PIXELS), 0);
            let words = mask.words.par_iter_mut().zip(seen.par_chunks(LightMask::PIXELS)).enumerate();
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
        let points = seen.par_iter().filter(|&&triangle| triangle != SeenPixels::NONE).count();
        *shadow_rays += (points * frame.lights.len()) as u64;
    }
}

/// Whether something stands between `light` and the point that `ray` has hit.
pub(super) fn is_blocked(bvh: &Bvh, frame: &Frame, light: &Light, ray: &Ray, hit: &Hit) -> bool {
    let shadow_ray = ShadowRay::new(&light.source, HitPoint::new(ray, hit.t));
    bvh.blocked(frame.triangles(), &shadow_ray, hit.triangle, |id, barycentric| frame.casts_shadow(id, barycentric))
}
