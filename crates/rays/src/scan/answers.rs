use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::parallel::Parallel;
use crate::{Hit, Ray, Rays, Triangles};

/// The hits of directions or [rays](crate::Trace): the requested number for each, nearest first, in the order of the
/// directions.
///
/// Hit k of direction i is at index i × [`returns`](Self::returns) + k of each list. Where there are fewer hits the triangle
/// is [`Scanned::NONE`], t is infinite, and barycentric coordinates are NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scanned {
    /// Distance from the origin, in lengths of the direction.
    pub t: Vec<f64>,
    /// Id of the triangle.
    pub triangle: Vec<u32>,
    /// Weights of the triangle's second and third vertex, each in [0, 1].
    pub barycentric: Vec<[f32; 2]>,
    /// The largest number of hits of a direction.
    pub returns: usize,
    /// The number of directions that were zero or not finite: they hit nothing.
    pub without_direction: usize,
}

impl Scanned {
    /// Id that stands for no triangle.
    pub const NONE: u32 = u32::MAX;

    pub(super) const MISS: Hit = Hit { t: f64::INFINITY, triangle: Self::NONE, barycentric: [f32::NAN; 2] };

    /// Makes room for the nearest hits of directions, which are written next.
    pub(super) fn make_room(&mut self, directions: usize) {
        let Self { t, triangle, barycentric, .. } = self;
        t.resize(directions, 0.0);
        triangle.resize(directions, 0);
        barycentric.resize(directions, [0.0; 2]);
        (self.returns, self.without_direction) = (1, 0);
    }

    /// Writes the nearest hits of a sweep's directions from `first` on: direction i has the hit at place i.
    pub(super) fn deliver(&mut self, first: usize, nearest: &[Hit], places: &[u32]) {
        const CHUNK: usize = 1 << 12;
        let range = first..first + places.len();
        let t = self.t[range.clone()].par_chunks_mut(CHUNK);
        let triangle = self.triangle[range.clone()].par_chunks_mut(CHUNK);
        let barycentric = self.barycentric[range].par_chunks_mut(CHUNK);
        places.par_chunks(CHUNK).zip(t.zip(triangle).zip(barycentric)).each(
            |(places, ((t, triangle), barycentric))| {
                for (index, &place) in places.iter().enumerate() {
                    let hit = nearest[place as usize];
                    (t[index], triangle[index], barycentric[index]) = (hit.t, hit.triangle, hit.barycentric);
                }
            },
        );
    }

    pub(crate) fn clear(&mut self, directions: usize, returns: usize) {
        let Self { t, triangle, barycentric, .. } = self;
        let slots = directions * returns;
        t.clear();
        t.resize(slots, f64::INFINITY);
        triangle.clear();
        triangle.resize(slots, Self::NONE);
        barycentric.clear();
        barycentric.resize(slots, [f32::NAN; 2]);
        (self.returns, self.without_direction) = (returns, 0);
    }

    /// Answers each ray, given its index, alone.
    pub(crate) fn fill_nearest(&mut self, rays: Rays<'_>, nearest: impl Fn(usize, &Ray) -> Option<Hit> + Sync) {
        const CHUNK: usize = 256;
        self.make_room(rays.len());
        let Self { t, triangle, barycentric, .. } = self;
        let chunks = t.par_chunks_mut(CHUNK).zip(triangle.par_chunks_mut(CHUNK)).zip(barycentric.par_chunks_mut(CHUNK));
        let without_direction = chunks.enumerate().map(|(chunk, ((t, triangle), barycentric))| {
            let mut without_direction = 0;
            for index in 0..t.len() {
                let number = chunk * CHUNK + index;
                let ray = rays.get(number);
                without_direction += usize::from(!ray.goes_somewhere());
                let hit = nearest(number, &ray).unwrap_or(Self::MISS);
                (t[index], triangle[index], barycentric[index]) = (hit.t, hit.triangle, hit.barycentric);
            }
            without_direction
        });
        self.without_direction = without_direction.sum();
    }

    /// Writes the hits of directions, whose numbers count from `first`. Hits of one direction are consecutive, nearest
    /// first.
    pub(super) fn note(&mut self, first: usize, hits: &[(usize, Hit)]) {
        for of_one in hits.chunk_by(|(a, _), (b, _)| a == b) {
            let start = (first + of_one[0].0) * self.returns;
            for (index, (_, hit)) in (start..start + self.returns).zip(of_one) {
                self.t[index] = hit.t;
                self.triangle[index] = hit.triangle;
                self.barycentric[index] = hit.barycentric;
            }
        }
    }

    /// The number of directions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len().checked_div(self.returns).unwrap_or(0)
    }

    /// Whether there are no directions.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// The hits of a direction, nearest first.
    ///
    /// # Panics
    /// If `direction` is out of range.
    pub fn hits(&self, direction: usize) -> impl Iterator<Item = Hit> {
        let slots = direction * self.returns..(direction + 1) * self.returns;
        let hits = slots.map(|index| self.hit(index));
        hits.take_while(|hit| hit.triangle != Self::NONE)
    }

    fn hit(&self, index: usize) -> Hit {
        Hit { t: self.t[index], triangle: self.triangle[index], barycentric: self.barycentric[index] }
    }

    /// The normal of the triangle at an index of the lists, of unit length, on the side from which corners are seen
    /// counterclockwise; NaN where there is no hit.
    ///
    /// # Panics
    /// If the index is out of range, or `triangles` aren't those of the scan.
    #[must_use]
    pub fn normal(&self, triangles: Triangles<'_>, index: usize) -> Vec3 {
        if self.triangle[index] == Self::NONE {
            return Vec3::NAN;
        }
        let [a, b, c] = triangles.corners(self.triangle[index]).map(Vec3::as_dvec3);
        let normal: DVec3 = (b - a).cross(c - a);
        // Scaled, so that its square doesn't underflow.
        (normal / normal.abs().max_element()).normalize().as_vec3()
    }
}
