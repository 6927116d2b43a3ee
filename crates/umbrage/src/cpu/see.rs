use rayon::prelude::*;
use umbrage_rays::{Hit, ImageTooLarge, PixelWork, SeenPixels, View};
use umbrage_scene::{Frame, SolidPoints};

use super::{Cpu, counts};
use crate::Structure;
use crate::sampling::Sample;

impl Cpu {
    /// Finds the triangle that each pixel shows, and counts what that took; the hierarchy counts nothing.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(crate) fn see_counting(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        work: &mut PixelWork,
    ) -> Result<(), ImageTooLarge> {
        let Self { structure, camera_grid, listed_grid, seen, camera_work, .. } = self;
        let triangles = frame.triangles();
        match structure {
            Structure::Perspective => {
                camera_grid.build(triangles, view, sample.offset_pixels, |id| frame.is_masked(id))?;
                *camera_work = camera_grid.trace_counting(triangles, SolidPoints(frame), seen, work);
            }
            Structure::Listed { camera: options, .. } => {
                listed_grid.build(triangles, view, sample.offset_pixels, *options, |id| frame.is_masked(id))?;
                listed_grid.trace_counting(triangles, SolidPoints(frame), seen, work);
            }
            Structure::Bvh => self.see(frame, view, sample)?,
        }
        Ok(())
    }

    /// Finds the triangle that each pixel shows.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(crate) fn see(&mut self, frame: &Frame, view: &View, sample: &Sample) -> Result<(), ImageTooLarge> {
        let Self { structure, bvh, camera_grid, listed_grid, seen, camera_work, settled_tests: [settled, _], .. } =
            self;
        let culls_back_faces = self.culls_back_faces;
        let triangles = frame.triangles();
        match structure {
            Structure::Perspective => {
                camera_grid.build(triangles, view, sample.offset_pixels, |id| frame.is_masked(id))?;
                *camera_work = camera_grid.trace(triangles, SolidPoints(frame), seen);
                *settled += camera_work.referred;
            }
            Structure::Listed { camera: options, .. } => {
                listed_grid.build(triangles, view, sample.offset_pixels, *options, |id| frame.is_masked(id))?;
                listed_grid.trace(triangles, SolidPoints(frame), seen);
            }
            Structure::Bvh => {
                seen.resize(view.width, view.height);
                let order = seen.order();
                let SeenPixels { triangle, inverse_depth, .. } = seen;
                let places = triangle.par_iter_mut().zip(inverse_depth).enumerate();
                places.for_each(|(place, (triangle, inverse_depth))| {
                    let pixel = order.pixel(place);
                    let nearest = pixel.and_then(|(x, y)| {
                        let ray = sample.ray(view, x, y);
                        bvh.nearest(triangles, &ray, |hit: &Hit| counts(frame, &ray, hit, culls_back_faces))
                    });
                    *triangle = nearest.map_or(SeenPixels::NONE, |hit| hit.triangle);
                    *inverse_depth = nearest.map_or(f32::NAN, |hit| SeenPixels::inverse_of(hit.t));
                });
            }
        }
        Ok(())
    }
}
