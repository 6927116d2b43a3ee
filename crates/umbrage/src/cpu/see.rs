//! The stages `see` and `shadow`: hits of camera rays, and the lights that reach them.

use std::mem;

use rayon::prelude::*;
use umbrage_rays::{ImageTooLarge, LightMask, LightSource, SeenPixels, View};
use umbrage_scene::{Frame, Light};

use super::{Cpu, opacities, shot};
use crate::sampling::Samples;

/// The lights that cast shadows, and their masks during the query.
#[derive(Debug, Default)]
pub(super) struct Casting {
    sources: Vec<LightSource>,
    masks: Vec<LightMask>,
}

impl Cpu {
    /// Finds the triangle that each pixel shows at some samples.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(super) fn see_pixels(&mut self, frame: &Frame, view: &View, samples: &Samples) -> Result<(), ImageTooLarge> {
        let opacities = opacities(frame);
        let shot = shot(self.copies.triangles(frame), &opacities, view, samples, self.sides.get());
        self.camera_work = self.structure.see(&shot, &mut self.seen)?;
        self.settled_tests[0] += self.camera_work.counts.settled;
        Ok(())
    }

    /// Finds the seen points that each light reaches.
    pub(super) fn shadow_points(&mut self, frame: &Frame, lights: &[Light], view: &View, samples: &Samples) {
        let Self {
            structure, copies, seen, masks, casting, smooth_terminator, shadow_rays, settled_tests, sides, ..
        } = self;
        let opacities = opacities(frame);
        let shot = shot(copies.triangles(frame), &opacities, view, samples, sides.get());
        masks.resize(lights.len(), LightMask::default());
        let Casting { sources, masks: of_sources } = casting;
        sources.clear();
        of_sources.clear();
        for (light, mask) in lights.iter().zip(&mut *masks) {
            if light.casts_shadow {
                sources.push(light.source);
                of_sources.push(mem::take(mask));
            } else {
                mask.light_all(seen);
            }
        }
        let work = structure.shadow(&shot, seen, sources, of_sources);
        if let Some(smooth) = smooth_terminator {
            smooth.shadow(structure.patches(), (frame, &shot), seen, sources, of_sources);
        }
        let of_casting = lights.iter().zip(masks).filter(|(light, _)| light.casts_shadow);
        of_casting.zip(of_sources.drain(..)).for_each(|((_, mask), found)| *mask = found);

        settled_tests[1] += work.counts.settled;
        let points = seen.triangle.par_iter().filter(|&&triangle| triangle != SeenPixels::NONE).count();
        *shadow_rays += (points * sources.len()) as u64;
    }
}
