//! The CPU engine: a frame's stages on the threads of the current rayon pool.

mod see;
mod shade;
mod shadow;

use umbrage_rays::{Bvh, Hit, Omitted};
use umbrage_scene::Frame;

pub use shadow::LightMask;

/// Finds what each pixel sees and which lights reach it, through a hierarchy rebuilt for every frame.
#[derive(Debug, Default)]
pub(crate) struct Cpu {
    bvh: Bvh,
    /// What each pixel sees at the current sample, in rows.
    hits: Vec<Option<Hit>>,
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

    /// What each pixel saw at the last sample.
    pub(crate) fn hits(&self) -> &[Option<Hit>] {
        &self.hits
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
        size_of_val(self.hits.as_slice()) + self.lit.iter().map(LightMask::bytes).sum::<usize>()
    }
}
