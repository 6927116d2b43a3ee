//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod see;
mod shade;
mod shadow;

use umbrage_rays::{Bvh, Hit, Omitted, Ray, predicate};
use umbrage_scene::Frame;

use crate::Film;
pub use shadow::LightMask;

/// Finds what each pixel sees and which lights reach it, through a hierarchy rebuilt for every frame.
#[derive(Debug, Default)]
pub(crate) struct Cpu {
    bvh: Bvh,
    /// The triangle that each pixel shows at the current sample, in rows; [`Film::NO_TRIANGLE`] for none.
    seen: Vec<u32>,
    /// For each light, which pixels it lights at the current sample.
    lit: Vec<LightMask>,
    shadow_rays: u64,
}

impl Cpu {
    /// Rebuilds the structure over the frame's triangles.
    pub(crate) fn build(&mut self, frame: &Frame) {
        self.bvh.build(frame.triangles());
        self.shadow_rays = 0;
    }

    /// The triangle that each pixel showed at the last sample.
    pub(crate) fn seen(&self) -> &[u32] {
        &self.seen
    }

    /// For each light, which pixels it lit at the last sample.
    pub(crate) fn light_masks(&self) -> &[LightMask] {
        &self.lit
    }

    pub(crate) fn omitted(&self) -> &Omitted {
        self.bvh.omitted()
    }

    pub(crate) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        self.bvh.bytes()
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        size_of_val(self.seen.as_slice()) + self.lit.iter().map(LightMask::bytes).sum::<usize>()
    }
}

/// Where `ray` meets the triangle that it is known to show.
fn hit_of(frame: &Frame, ray: &Ray, seen: u32) -> Option<Hit> {
    if seen == Film::NO_TRIANGLE { None } else { predicate::hit(ray, frame.triangles(), seen) }
}
