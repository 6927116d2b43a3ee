use umbrage_rays::{ImageTooLarge, View};
use umbrage_scene::Frame;

use super::{Cpu, opacities, shot};
use crate::sampling::Samples;

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
}
