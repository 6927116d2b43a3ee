use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::fit::fit;
use super::moved::{Moved, ROUNDING, magnitudes};
use crate::kdtree::{Extent, Reference};
use umbrage_rays::Triangles;

/// The largest distance of mapped vertices from their places at rest with which trees over triangles are kept, relative to
/// the object's size, and that from their boxes with which trees over boxes are kept.
const MOST_DRIFT: [f64; 2] = [1.0 / (1 << 12) as f64, 1.0 / (1 << 9) as f64];

/// The largest area of all triangles' boxes, relative to that of boxes around the triangles alone.
const MOST_GROWTH: f64 = 32.0;

/// Approximate number of vertices that a map is fitted to.
const FITTED: usize = 512;

/// The number of vertices that a thread takes at once.
const CHUNK: usize = 1 << 12;

/// The place of an object when its tree was built: at rest.
#[derive(Default)]
pub(super) struct Rest {
    /// The object's vertices, ascending.
    vertices: Vec<u32>,
    /// Their positions at rest; NaN if there was none.
    positions: Vec<Vec3>,
    /// Boxes that hold each mapped vertex in the frames that the tree is for: the least and the greatest coordinates. Empty
    /// if the tree is over the triangles.
    boxes: Vec<[Vec3; 2]>,
    /// Triangles that no ray could hit.
    omitted: Vec<u32>,
    /// Indices of some vertices, to which maps are fitted.
    fitted: Vec<u32>,
    /// The bounds of the triangles that rays can hit.
    extent: Extent,
}

/// Returns the position of a vertex; NaN if there is none.
fn at(positions: &[Vec3], vertex: u32) -> Vec3 {
    positions.get(vertex as usize).copied().unwrap_or(Vec3::NAN)
}

impl Rest {
    /// Returns the rest of triangles that have no place yet.
    pub(super) fn new(indices: &[[u32; 3]]) -> Self {
        let mut vertices = indices.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        Self { vertices, ..Self::default() }
    }

    pub(super) fn bytes(&self) -> usize {
        (self.vertices.capacity() + self.omitted.capacity() + self.fitted.capacity()) * size_of::<u32>()
            + self.positions.capacity() * size_of::<Vec3>()
            + self.boxes.capacity() * size_of::<[Vec3; 2]>()
    }

    pub(super) fn extent(&self) -> Extent {
        self.extent
    }

    /// Whether the tree is over boxes.
    pub(super) fn has_boxes(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// Makes the object's place in a frame the one at rest.
    pub(super) fn settle(&mut self, triangles: Triangles<'_>) {
        self.positions.clear();
        self.positions.extend(self.vertices.iter().map(|&vertex| at(triangles.positions, vertex)));
        self.boxes.clear();
        self.omitted.clear();
        self.extent = Extent::EMPTY;
        for id in 0..triangles.len() as u32 {
            match triangles.usable_corners(id) {
                Ok(corners) => self.extent = self.extent.union(Extent::around(corners)),
                Err(_) => self.omitted.push(id),
            }
        }
        self.choose_fitted();
    }

    /// Chooses the vertices that maps are fitted to.
    fn choose_fitted(&mut self) {
        let usable = (0..self.positions.len()).filter(|&index| self.positions[index].is_finite());
        self.fitted.clear();
        self.fitted.extend(usable.step_by(self.positions.len().div_ceil(FITTED).max(1)).map(|index| index as u32));
    }

    /// Whether all vertices are at rest, bit for bit.
    pub(super) fn is_at(&self, positions: &[Vec3]) -> bool {
        let bits = |at: Vec3| at.to_array().map(f32::to_bits);
        let all = self.vertices.par_chunks(CHUNK).zip(self.positions.par_chunks(CHUNK));
        all.all(|(vertices, rest)| {
            vertices.iter().zip(rest).all(|(&vertex, &rest)| bits(at(positions, vertex)) == bits(rest))
        })
    }

    /// Returns the map of rays to the tree, and the bounds of the vertices now; `None` if the tree can't serve.
    pub(super) fn follow(&self, triangles: Triangles<'_>) -> Option<(Moved, Extent)> {
        if self.has_gained(triangles) {
            return None;
        }
        self.measure(triangles, self.map(triangles.positions)?)
    }

    /// Whether a triangle can be hit that isn't in the tree.
    fn has_gained(&self, triangles: Triangles<'_>) -> bool {
        self.omitted.iter().any(|&id| triangles.usable_corners(id).is_ok())
    }

    /// Returns the map that takes the object best back to rest.
    fn map(&self, positions: &[Vec3]) -> Option<DAffine3> {
        let pair = |&index: &u32| {
            let now = at(positions, self.vertices[index as usize]);
            now.is_finite().then(|| [now.as_dvec3(), self.positions[index as usize].as_dvec3()])
        };
        let pairs: Option<Vec<_>> = self.fitted.iter().map(pair).collect();
        fit(&pairs?)
    }

    /// Measures the distance of mapped vertices from their boxes; `None` if it is too large.
    fn measure(&self, triangles: Triangles<'_>, rest_from_world: DAffine3) -> Option<(Moved, Extent)> {
        let sizes = magnitudes(rest_from_world);
        let of_vertex = |index: usize| {
            let now = at(triangles.positions, self.vertices[index]);
            let rest = self.positions[index];
            if !(now.is_finite() && rest.is_finite()) {
                // Triangles with such a vertex aren't listed, so the vertex must have no position both now and at rest.
                return (now.is_finite() == rest.is_finite()).then_some((DVec3::ZERO, Extent::EMPTY));
            }
            let [low, high] = self.boxes.get(index).copied().unwrap_or([rest; 2]).map(Vec3::as_dvec3);
            let taken = rest_from_world.transform_point3(now.as_dvec3());
            let rounding = (sizes.transform_point3(now.as_dvec3().abs()) + low.abs().max(high.abs())) * ROUNDING;
            Some(((low - taken).max(taken - high).max(DVec3::ZERO) + rounding, Extent::around([now])))
        };
        let most = self.size() * MOST_DRIFT[usize::from(self.has_boxes())];
        let far = |drift: DVec3| !(drift.max_element() <= most && drift.is_finite());
        let vertices = (0..self.vertices.len()).into_par_iter().with_min_len(CHUNK);
        let (drift, extent) = vertices
            .map(|index| of_vertex(index).filter(|(drift, _)| !far(*drift)))
            .try_reduce(|| (DVec3::ZERO, Extent::EMPTY), |a, b| Some((a.0.max(b.0), a.1.union(b.1))))?;
        Some((Moved { rest_from_world, magnitudes: sizes, drift }, extent))
    }

    /// Enlarges the boxes so that they hold the mapped vertices of a frame, and further by `beyond`, relative to the missing
    /// part; false if they can't. Then only [`settle`](Self::settle) makes a tree possible.
    pub(super) fn enclose(&mut self, triangles: Triangles<'_>, beyond: f64) -> bool {
        if self.has_gained(triangles) {
            return false;
        }
        let Some(rest_from_world) = self.map(triangles.positions) else { return false };
        if self.boxes.is_empty() {
            self.boxes.extend(self.positions.iter().map(|&rest| [rest; 2]));
        }
        let vertices = self.boxes.par_iter_mut().zip(&self.vertices).zip(&self.positions).with_min_len(CHUNK);
        vertices.all(|((held, &vertex), rest)| {
            let now = at(triangles.positions, vertex);
            if !(now.is_finite() && rest.is_finite()) {
                return now.is_finite() == rest.is_finite();
            }
            let taken = rest_from_world.transform_point3(now.as_dvec3());
            let [low, high] = held.map(Vec3::as_dvec3);
            let point = (taken + (taken - taken.max(low).min(high)) * beyond).as_vec3();
            *held = [held[0].min(point), held[1].max(point)];
            point.is_finite()
        })
    }

    /// Whether a tree over boxes pays, compared to one for each frame.
    pub(super) fn is_worth_it(&self, triangles: Triangles<'_>) -> bool {
        self.growth(triangles) <= MOST_GROWTH
    }

    /// Drops the boxes if trees over triangles would allow as much drift.
    pub(super) fn drop_small_boxes(&mut self) {
        let sides = self.boxes.iter().map(|[low, high]| f64::from((*high - *low).max_element()));
        if sides.fold(0.0, f64::max) <= 0.5 * MOST_DRIFT[0] * self.size() {
            self.boxes.clear();
        }
    }

    /// The longest side of the box around the triangles.
    fn size(&self) -> f64 {
        let sides = (0..3).map(|axis| f64::from(self.extent.max[axis]) - f64::from(self.extent.min[axis]));
        sides.fold(0.0, f64::max)
    }

    /// Returns the area of triangles' boxes, relative to that of boxes around the triangles alone.
    fn growth(&self, triangles: Triangles<'_>) -> f64 {
        let area = |extent: Extent| extent.half_area();
        let [mut grown, mut own] = [0.0; 2];
        for Reference { extent, id } in self.references(triangles.indices) {
            grown += area(extent);
            own +=
                area(Extent::around(self.corners(triangles.indices[id as usize]).map(|index| self.positions[index])));
        }
        if grown == own { 1.0 } else { grown / own }
    }

    /// Indices of a triangle's vertices.
    fn corners(&self, triangle: [u32; 3]) -> [usize; 3] {
        triangle.map(|vertex| self.vertices.binary_search(&vertex).expect("a vertex of the object"))
    }

    /// Returns the boxes of the triangles that rays could hit.
    pub(super) fn references<'a>(&'a self, indices: &'a [[u32; 3]]) -> impl Iterator<Item = Reference> + 'a {
        let usable = (0..).zip(indices).filter(|(id, _)| self.omitted.binary_search(id).is_err());
        usable.map(|(id, &triangle)| {
            let [a, b, c] = self.corners(triangle).map(|index| Extent::around(self.boxes[index]));
            Reference { extent: a.union(b).union(c), id }
        })
    }

    /// Returns the positions of all vertices at rest, and the triangles with indices of these.
    pub(super) fn triangles(&self, indices: &[[u32; 3]]) -> (&[Vec3], Vec<[u32; 3]>) {
        (&self.positions, indices.iter().map(|&triangle| self.corners(triangle).map(|index| index as u32)).collect())
    }

    /// Returns the box at rest of a vertex, given by its index in the frame.
    pub(super) fn box_of(&self, vertex: u32) -> Option<[Vec3; 2]> {
        let index = self.vertices.binary_search(&vertex).ok()?;
        Some(self.boxes.get(index).copied().unwrap_or([self.positions[index]; 2]))
    }
}
