use glam::{DVec3, Vec3};

use crate::{Hit, Triangles};

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

    /// Writes the hits of directions, whose numbers count from `first`. Hits of one direction are consecutive, nearest
    /// first.
    pub(super) fn note(&mut self, first: usize, hits: &[(u32, Hit)]) {
        for of_one in hits.chunk_by(|(a, _), (b, _)| a == b) {
            let start = (first + of_one[0].0 as usize) * self.returns;
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
