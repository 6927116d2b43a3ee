use rayon::prelude::*;
use umbrage_rays::View;
use umbrage_scene::Frame;

use super::Cpu;
use crate::Film;
use crate::sampling::Sample;

impl Cpu {
    /// Finds the triangle that each pixel shows.
    pub(crate) fn see(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { bvh, seen, .. } = self;
        seen.resize(view.width as usize * view.height as usize, Film::NO_TRIANGLE);
        seen.par_iter_mut().enumerate().for_each(|(pixel, seen)| {
            let ray = sample.ray(view, pixel);
            let nearest = bvh.nearest(frame.triangles(), &ray, |hit| frame.is_solid(hit.triangle, hit.barycentric));
            *seen = nearest.map_or(Film::NO_TRIANGLE, |hit| hit.triangle);
        });
    }
}
