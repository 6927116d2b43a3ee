use super::Trace;
use crate::bvh::First;
use crate::parallel::both;
use crate::predicate::hits_of;
use crate::{Bvh, Hit, Ray, Scanned, SimdLevel, SingleRays, Wanted};

/// Rays that are answered one after the other, on one thread.
const CHUNK: usize = 256;

/// Rays that a hierarchy answers.
pub(super) struct Batch<'a> {
    pub(super) hierarchy: &'a Bvh,
    pub(super) trace: &'a Trace<'a>,
    pub(super) level: SimdLevel,
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
    /// Answers the rays from `first` on, and returns the number of those without a direction.
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

    /// Winners that are certain go to the predicate together, eight at a time: their triangles need none.
    fn answer_chunk(&self, first: usize, mut answers: Answers<'_>) -> usize {
        let Self { hierarchy, trace, .. } = *self;
        let mut rays = [Ray::new(glam::DVec3::ZERO, glam::DVec3::ZERO); CHUNK];
        let (mut pairs, mut certain, mut without_direction) = ([(0, 0); CHUNK], 0, 0);
        for (index, ray) in rays[..answers.triangle.len()].iter_mut().enumerate() {
            *ray = trace.ray(first + index);
            without_direction += usize::from(!ray.goes_somewhere());
            let found = if self.all_stop {
                hierarchy.first(trace.triangles, ray)
            } else {
                First::Settled(hierarchy.nearest(trace.triangles, ray, &|hit| trace.stops(ray, hit)))
            };
            match found {
                First::Certain(id) if trace.wanted == Wanted::IDS => answers.triangle[index] = id,
                First::Certain(id) => {
                    pairs[certain] = (index as u32, id);
                    certain += 1;
                }
                First::Settled(hit) => answers.write(index, &hit.unwrap_or(Scanned::MISS)),
            }
        }
        let mut hits = [None; CHUNK];
        hits_of(self.level, trace.triangles, &rays[..], &pairs[..certain], &mut hits[..certain]);
        for (&(index, _), hit) in pairs[..certain].iter().zip(&hits) {
            answers.write(index as usize, &hit.unwrap_or(Scanned::MISS));
        }
        without_direction
    }
}
