use umbrage_rays::{ImageTooLarge, PixelWork, View};
use umbrage_scene::Frame;

use super::{Cpu, opacities, shot};
use crate::sampling::Sample;

impl Cpu {
    /// Finds the triangle that each pixel shows.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(super) fn see_pixels(&mut self, frame: &Frame, view: &View, sample: &Sample) -> Result<(), ImageTooLarge> {
        let opacities = opacities(frame);
        let shot = shot(frame, &opacities, view, sample, self.sides);
        self.camera_work = self.structure.see(&shot, &mut self.seen)?;
        self.settled_tests[0] += self.camera_work.counts.settled;
        Ok(())
    }

    /// Finds the triangle that each pixel shows, and counts what that took; structures for all rays count nothing.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(super) fn see_counting(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        work: &mut PixelWork,
    ) -> Result<(), ImageTooLarge> {
        let opacities = opacities(frame);
        let shot = shot(frame, &opacities, view, sample, self.sides);
        match self.structure.specialised() {
            Some(specialised) => self.camera_work = specialised.see_counting(&shot, &mut self.seen, work)?,
            None => self.see_pixels(frame, view, sample)?,
        }
        Ok(())
    }
}
