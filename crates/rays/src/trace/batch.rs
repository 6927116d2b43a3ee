use glam::DVec3;
use rayon::prelude::*;

use super::Trace;
use crate::bvh::First;
use crate::parallel::{Parallel, both};
use crate::{Bvh, Hit, Ray, Scanned, SingleRays, Wanted};

/// Rays that are answered one after the other, on one thread.
const CHUNK: usize = 64;

/// Rays that a hierarchy answers.
pub(super) struct Batch<'a> {
    pub(super) hierarchy: &'a Bvh,
    pub(super) trace: &'a Trace<'a>,
    /// Whether all triangles stop all rays.
    pub(super) all_stop: bool,
}

/// Room for the answers of some rays; lists that aren't wanted are empty.
pub(super) struct Answers<'a> {
    pub(super) t: &'a mut [f64],
    pub(super) triangle: &'a mut [u32],
    pub(super) barycentric: &'a mut [[f32; 2]],
}

impl<'a> Answers<'a> {
    fn split_at(self, middle: usize) -> [Self; 2] {
        let (t, other_t) = self.t.split_at_mut(middle.min(self.t.len()));
        let (triangle, other_triangle) = self.triangle.split_at_mut(middle);
        let (barycentric, others) = self.barycentric.split_at_mut(middle.min(self.barycentric.len()));
        [Self { t, triangle, barycentric }, Self { t: other_t, triangle: other_triangle, barycentric: others }]
    }

    fn write(&mut self, index: usize, hit: &Hit) {
        self.triangle[index] = hit.triangle;
        if let Some(t) = self.t.get_mut(index) {
            *t = hit.t;
        }
        if let Some(barycentric) = self.barycentric.get_mut(index) {
            *barycentric = hit.barycentric;
        }
    }
}

impl Batch<'_> {
    /// Finds the first hits of the rays from `first` on. Returns the number of those without a direction.
    pub(super) fn answer(&self, first: usize, answers: Answers<'_>) -> usize {
        let count = answers.triangle.len();
        if count > CHUNK {
            let middle = (count / 2).next_multiple_of(CHUNK);
            let [low, high] = answers.split_at(middle);
            let (low, high) = both(|| self.answer(first, low), || self.answer(first + middle, high));
            return low + high;
        }
        self.answer_chunk(first, answers)
    }

    fn answer_chunk(&self, first: usize, mut answers: Answers<'_>) -> usize {
        let Self { hierarchy, trace, .. } = *self;
        let mut rays = [Ray::new(DVec3::ZERO, DVec3::ZERO); CHUNK];
        let rays = &mut rays[..answers.triangle.len()];
        let without_direction = self.read(first, rays);
        if !self.all_stop {
            for (index, ray) in rays.iter().enumerate() {
                let mask = trace.masks.of_ray(first + index);
                let hit = hierarchy.nearest(trace.triangles, ray, &|hit| trace.stops(ray, mask, hit));
                answers.write(index, &hit.unwrap_or(Scanned::MISS));
            }
            return without_direction;
        }
        hierarchy.first_of_each(
            trace.triangles,
            rays,
            trace.wanted == Wanted::IDS,
            #[inline(always)]
            |index, found| match found {
                First::Certain(id) => answers.triangle[index] = id,
                First::Settled(hit) => answers.write(index, &hit.unwrap_or(Scanned::MISS)),
            },
        );
        without_direction
    }

    /// Writes a value for the number of triangles that each ray hits. No more are counted than `enough`, or a few more.
    pub(super) fn count<T: Send>(&self, enough: u32, to: &mut [T], value: impl Fn(u32) -> T + Sync) {
        to.par_chunks_mut(CHUNK).enumerate().each(|(chunk, to)| {
            let mask = |index: usize| self.trace.masks.of_ray(chunk * CHUNK + index);
            let stops = |index: usize, ray: &Ray, hit: &Hit| self.trace.stops(ray, mask(index), hit);
            let mut rays = [Ray::new(DVec3::ZERO, DVec3::ZERO); CHUNK];
            let rays = &mut rays[..to.len()];
            self.read(chunk * CHUNK, rays);
            self.hierarchy.hits_of_each(
                self.trace.triangles,
                rays,
                (enough, if self.all_stop { None } else { Some(&stops) }),
                #[inline(always)]
                |index, count| to[index] = value(count),
            );
        });
    }

    /// Reads the rays from `first` on. Returns the number of those without a direction.
    fn read(&self, first: usize, rays: &mut [Ray]) -> usize {
        let mut without_direction = 0;
        for (index, ray) in rays.iter_mut().enumerate() {
            *ray = self.trace.ray(first + index);
            without_direction += usize::from(!ray.goes_somewhere());
        }
        without_direction
    }
}
