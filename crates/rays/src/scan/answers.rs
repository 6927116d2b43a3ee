use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::parallel::Parallel;
use crate::{Hit, Ray, Rays, Triangles};

/// The parts of hits that are found, besides their triangles. Those that are given have the same bits as with all others.
///
/// Triangles alone take about 0.6 of the time of a scan for all parts: the filter in f32 nearly always tells which triangle
/// is the nearest, but t and the weights are the predicate's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// [`Scanned::t`].
    pub t: bool,
    /// [`Scanned::barycentric`].
    pub barycentric: bool,
}

impl Wanted {
    /// Everything.
    pub const ALL: Self = Self { t: true, barycentric: true };
    /// The triangles' ids alone.
    pub const IDS: Self = Self { t: false, barycentric: false };
}

/// The hits of directions or [rays](crate::Trace): the requested number for each, nearest first, in the order of the
/// directions.
///
/// Hit k of direction i is at index i × [`returns`](Self::returns) + k of each list. Where there are fewer hits the triangle
/// is [`Scanned::NONE`], t is infinite, and barycentric coordinates are NaN. Lists that aren't [wanted](Wanted) are empty.
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

    pub(crate) const MISS: Hit = Hit { t: f64::INFINITY, triangle: Self::NONE, barycentric: [f32::NAN; 2] };

    /// Makes room for the nearest hits of directions, which are written next.
    pub(crate) fn make_room(&mut self, directions: usize, wanted: Wanted) {
        make_room(&mut self.t, if wanted.t { directions } else { 0 });
        make_room(&mut self.triangle, directions);
        make_room(&mut self.barycentric, if wanted.barycentric { directions } else { 0 });
        (self.returns, self.without_direction) = (1, 0);
    }

    /// Writes the nearest hits of a sweep's directions from `first` on: direction i has the hit at place i.
    pub(super) fn deliver(&mut self, first: usize, nearest: &[Hit], places: &[u32]) {
        let Self { t, triangle, barycentric, .. } = self;
        gather(triangle, first, places, |place| nearest[place].triangle);
        if !t.is_empty() {
            gather(t, first, places, |place| nearest[place].t);
        }
        if !barycentric.is_empty() {
            gather(barycentric, first, places, |place| nearest[place].barycentric);
        }
    }

    /// As [`deliver`](Self::deliver), of the ids of triangles alone.
    pub(super) fn deliver_ids(&mut self, first: usize, nearest: &[u32], places: &[u32]) {
        gather(&mut self.triangle, first, places, |place| nearest[place]);
    }

    pub(super) fn clear(&mut self, directions: usize, returns: usize, wanted: Wanted) {
        let Self { t, triangle, barycentric, .. } = self;
        let slots = directions * returns;
        t.clear();
        t.resize(if wanted.t { slots } else { 0 }, f64::INFINITY);
        triangle.clear();
        triangle.resize(slots, Self::NONE);
        barycentric.clear();
        barycentric.resize(if wanted.barycentric { slots } else { 0 }, [f32::NAN; 2]);
        (self.returns, self.without_direction) = (returns, 0);
    }

    /// Answers each ray, given its index, alone.
    pub(crate) fn fill_nearest(&mut self, rays: Rays<'_>, nearest: impl Fn(usize, &Ray) -> Option<Hit> + Sync) {
        const CHUNK: usize = 256;
        self.make_room(rays.len(), Wanted::ALL);
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
                self.triangle[index] = hit.triangle;
                if let Some(t) = self.t.get_mut(index) {
                    *t = hit.t;
                }
                if let Some(barycentric) = self.barycentric.get_mut(index) {
                    *barycentric = hit.barycentric;
                }
            }
        }
    }

    /// The number of directions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangle.len().checked_div(self.returns).unwrap_or(0)
    }

    /// Whether there are no directions.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangle.is_empty()
    }

    /// The hits of a direction, nearest first.
    ///
    /// # Panics
    /// If `direction` is out of range, or not [all parts](Wanted::ALL) were wanted.
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

/// Makes room for as many values, which are written next. New memory comes as zeros from the system, so that the threads
/// that write to it are the first to touch it.
pub(crate) fn make_room<T: Copy + Default>(list: &mut Vec<T>, count: usize) {
    if list.capacity() < count {
        *list = vec![T::default(); count];
    } else {
        list.resize(count, T::default());
    }
}

/// Writes the values at places to a list, from `first` on.
fn gather<T: Send>(list: &mut [T], first: usize, places: &[u32], at: impl Fn(usize) -> T + Sync) {
    const CHUNK: usize = 1 << 12;
    let to = list[first..first + places.len()].par_chunks_mut(CHUNK);
    places.par_chunks(CHUNK).zip(to).each(|(places, to)| {
        for (&place, to) in places.iter().zip(to) {
            *to = at(place as usize);
        }
    });
}
