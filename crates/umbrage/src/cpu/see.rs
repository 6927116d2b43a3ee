use rayon::prelude::*;
use umbrage_rays::View;
use umbrage_scene::Frame;

use super::Cpu;
use crate::sampling::Sample;

impl Cpu {
    /// Finds the nearest hit of each pixel's ray.
    pub(crate) fn see(&mut self, frame: &Frame, view: &View, sample: &Sample) {
        let Self { bvh, hits, .. } = self;
        hits.resize(view.width as usize * view.height as usize, None);
        hits.par_iter_mut().enumerate().for_each(|(pixel, hit)| {
            let ray = sample.ray(view, pixel);
            *hit = bvh.nearest(frame.triangles(), &ray, |hit| frame.is_solid(hit.triangle, hit.barycentric));
        });
    }
}
