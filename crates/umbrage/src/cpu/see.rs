use rayon::prelude::*;
use umbrage_rays::{
    Camera, Hit, ImageTooLarge, Mask, MaskAnswers, MaskPoints, PixelWork, Projection, SeenPixels, View, predicate,
};
use umbrage_scene::{Frame, SolidPoints};

use super::{Cpu, counts};
use crate::Structure;
use crate::sampling::Sample;

impl Cpu {
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
            Structure::Grid(_) | Structure::KdTree(_) | Structure::Bvh => self.see_pixels(frame, view, sample)?,
        }
        Ok(())
    }

    /// Finds the triangle that each pixel shows.
    ///
    /// # Errors
    /// Where the image is larger than the structure's limit.
    pub(super) fn see_pixels(&mut self, frame: &Frame, view: &View, sample: &Sample) -> Result<(), ImageTooLarge> {
        let Self { structure, uniform_grid, kd_tree, camera_grid, listed_grid, seen, camera_work, .. } = self;
        let settled_tests = &mut self.settled_tests;
        let culls_back_faces = self.culls_back_faces;
        let triangles = frame.triangles();
        match structure {
            Structure::Perspective => {
                camera_grid.build(triangles, view, sample.offset_pixels, |id| frame.is_masked(id))?;
                *camera_work = camera_grid.trace(triangles, SolidPoints(frame), seen);
                settled_tests[0] += camera_work.referred;
            }
            Structure::Listed { camera: options, .. } => {
                listed_grid.build(triangles, view, sample.offset_pixels, *options, |id| frame.is_masked(id))?;
                listed_grid.trace(triangles, SolidPoints(frame), seen);
            }
            Structure::Grid(_) => {
                let points = FrontPoints { frame, camera: &view.camera, culls_back_faces };
                let is_opaque = |id| !frame.is_masked(id) && points.is_seen(id);
                uniform_grid.see(triangles, view, sample.offset_pixels, is_opaque, points, seen);
            }
            // Packets know nothing of subtrees that are built when a ray reaches them.
            Structure::KdTree(options) if options.lazy_below == 0 => {
                let points = FrontPoints { frame, camera: &view.camera, culls_back_faces };
                let is_opaque = |id| !frame.is_masked(id) && points.is_seen(id);
                kd_tree.see(triangles, view, sample.offset_pixels, is_opaque, points, seen);
            }
            Structure::KdTree(_) | Structure::Bvh => self.see_ray_by_ray(frame, view, sample),
        }
        Ok(())
    }

    fn see_ray_by_ray(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let mut seen = std::mem::take(&mut self.seen);
        seen.resize(view.width, view.height);
        let (rays, culls_back_faces) = (self.single_rays(), self.culls_back_faces);
        let order = seen.order();
        let places = seen.triangle.par_iter_mut().zip(&mut seen.inverse_depth).enumerate();
        places.for_each(|(place, (triangle, inverse_depth))| {
            let pixel = order.pixel(place);
            let nearest = pixel.and_then(|(x, y)| {
                let ray = sample.ray(view, x, y);
                rays.nearest(frame.triangles(), &ray, |hit: &Hit| counts(frame, &ray, hit, culls_back_faces))
            });
            *triangle = nearest.map_or(SeenPixels::NONE, |hit| hit.triangle);
            *inverse_depth = nearest.map_or(f32::NAN, |hit| SeenPixels::inverse_of(hit.t));
        });
        self.seen = seen;
    }
}

/// The points that stop a camera's rays, where those may go through back faces.
#[derive(Clone, Copy, Debug)]
struct FrontPoints<'a> {
    frame: &'a Frame,
    camera: &'a Camera,
    culls_back_faces: bool,
}

impl FrontPoints<'_> {
    /// Whether rays of the camera that hit a triangle aren't to go through it for the side that it shows.
    fn is_seen(&self, triangle: u32) -> bool {
        if !self.culls_back_faces {
            return true;
        }
        let corners = self.frame.triangles().corners(triangle);
        match self.camera.projection {
            Projection::Perspective { .. } => predicate::is_front_from(self.camera.position.as_dvec3(), corners),
            Projection::Orthographic { .. } => predicate::is_front_along(self.camera.forward.as_dvec3(), corners),
        }
    }
}

impl Mask for FrontPoints<'_> {
    fn is_solid(&self, hit: &Hit) -> bool {
        self.is_seen(hit.triangle) && SolidPoints(self.frame).is_solid(hit)
    }

    fn are_solid(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        if self.is_seen(triangle) {
            SolidPoints(self.frame).are_solid(triangle, points)
        } else {
            MaskAnswers { solid: 0, cut: points.asked }
        }
    }
}
