//! A light uniform binning, by which pairs are chosen that a structure would test.

use glam::{DVec3, Vec3};
use umbrage::rays::{Bounds, Ray, Triangles};

/// Cubic cells with the triangles whose bounds overlap them (Wald et al. 2006, §3).
#[derive(Debug)]
pub(super) struct Bins {
    low: DVec3,
    /// Side of a cell.
    side: f64,
    cells: [usize; 3],
    /// Where each cell's triangles start in `ids`, and one more for the end.
    starts: Vec<u32>,
    ids: Vec<u32>,
}

/// Cells a triangle.
const LAMBDA: f64 = 6.0;

impl Bins {
    pub(super) fn new(triangles: Triangles<'_>, bounds: Bounds) -> Self {
        let (low, size) = (bounds.min.as_dvec3(), bounds.size().as_dvec3());
        // Flat bounds still get one layer of cells.
        let sides = size.max(DVec3::splat(1e-3 * size.max_element().max(1e-30)));
        let side = (sides.x * sides.y * sides.z / (LAMBDA * triangles.len() as f64)).cbrt();
        let cells = (sides / side).ceil().max(DVec3::ONE).to_array().map(|cells| cells as usize);
        let mut bins = Self { low, side, cells, starts: vec![0; cells.iter().product::<usize>() + 1], ids: Vec::new() };
        for id in 0..triangles.len() as u32 {
            bins.overlapped(triangles.corners(id)).for_each(|cell| bins.starts[cell + 1] += 1);
        }
        for cell in 1..bins.starts.len() {
            bins.starts[cell] += bins.starts[cell - 1];
        }
        let mut ends = bins.starts.clone();
        let mut ids = vec![0; ends[ends.len() - 1] as usize];
        for id in 0..triangles.len() as u32 {
            for cell in bins.overlapped(triangles.corners(id)) {
                ids[ends[cell] as usize] = id;
                ends[cell] += 1;
            }
        }
        bins.ids = ids;
        bins
    }

    /// Cells that a triangle's bounds overlap; none if a corner isn't finite.
    fn overlapped(&self, corners: [Vec3; 3]) -> impl Iterator<Item = usize> + use<> {
        let is_finite = corners.iter().all(|corner| corner.is_finite());
        let bounds = Bounds::of_points(corners);
        let [first, last] = [bounds.min, bounds.max].map(|corner| self.cell_of(corner.as_dvec3()));
        let [width, height, _] = self.cells;
        let range = |axis: usize| first[axis]..if is_finite { last[axis] + 1 } else { first[axis] };
        let (xs, ys, zs) = (range(0), range(1), range(2));
        zs.flat_map(move |z| {
            let xs = xs.clone();
            ys.clone().flat_map(move |y| xs.clone().map(move |x| (z * height + y) * width + x))
        })
    }

    /// The cell of a point, or the nearest one.
    fn cell_of(&self, point: DVec3) -> [usize; 3] {
        let place = (point - self.low) / self.side;
        // A cast of what is below zero gives zero.
        [0, 1, 2].map(|axis| (place[axis] as usize).min(self.cells[axis] - 1))
    }

    /// Calls `visit` with the triangles of each cell along a ray and the t at which the ray leaves the cell, until it
    /// says that this is enough (Amanatides and Woo 1987).
    pub(super) fn walk(&self, ray: &Ray, mut visit: impl FnMut(&[u32], f64) -> bool) {
        let high = self.low + DVec3::from(self.cells.map(|cells| cells as f64)) * self.side;
        let (at_low, at_high) = ((self.low - ray.origin) / ray.direction, (high - ray.origin) / ray.direction);
        let enter = at_low.min(at_high).max_element().max(0.0);
        let leave = at_low.max(at_high).min_element();
        if enter.is_nan() || leave.is_nan() || enter > leave {
            return;
        }
        let mut cell = self.cell_of(ray.origin + ray.direction * enter);
        // t at the next boundary along each axis.
        let mut next = DVec3::INFINITY;
        for axis in (0..3).filter(|&axis| ray.direction[axis] != 0.0) {
            let ahead = cell[axis] + usize::from(ray.direction[axis] > 0.0);
            next[axis] = (self.low[axis] + ahead as f64 * self.side - ray.origin[axis]) / ray.direction[axis];
        }
        let step = DVec3::splat(self.side) / ray.direction.abs();
        loop {
            let axis = next.min_position();
            let place = (cell[2] * self.cells[1] + cell[1]) * self.cells[0] + cell[0];
            let range = self.starts[place] as usize..self.starts[place + 1] as usize;
            if visit(&self.ids[range], next[axis]) {
                return;
            }
            let moved = if ray.direction[axis] > 0.0 { cell[axis] + 1 } else { cell[axis].wrapping_sub(1) };
            if moved >= self.cells[axis] {
                return;
            }
            (cell[axis], next[axis]) = (moved, next[axis] + step[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use umbrage::rays::predicate;

    use super::*;

    /// Triangles along a spiral, in a plane of their own or in space.
    fn spiral(flatness: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let point = |place: u32| {
            let (angle, radius) = (place as f32 * 0.37, 1.0 + place as f32 * 0.02);
            Vec3::new(radius * angle.cos(), radius * angle.sin(), flatness * (place % 7) as f32)
        };
        ((0..602).map(point).collect(), (0..600).map(|place| [place, place + 1, place + 2]).collect())
    }

    #[test]
    fn walks_come_by_every_triangle_that_rays_hit() {
        for flatness in [0.0, 0.5] {
            let (positions, indices) = spiral(flatness);
            let triangles = Triangles { positions: &positions, indices: &indices };
            let bins = Bins::new(triangles, triangles.bounds());
            let mut hits = 0;
            for place in 0..200 {
                let angle = f64::from(place);
                // Every fourth ray is parallel to an axis.
                let aside = if place % 4 == 0 { 0.0 } else { 0.6 };
                let origin = DVec3::new(9.0 * angle.sin(), 9.0 * angle.cos(), if place < 100 { -4.0 } else { 8.0 });
                let direction = DVec3::new(-aside * angle.sin(), -aside * angle.cos(), -origin.z.signum());
                let ray = Ray::new(origin, direction);
                let mut seen = vec![false; indices.len()];
                let mut before = f64::NEG_INFINITY;
                bins.walk(&ray, |ids, leave| {
                    assert!(leave >= before, "{leave} after {before}");
                    before = leave;
                    ids.iter().for_each(|&id| seen[id as usize] = true);
                    false
                });
                for id in (0..indices.len() as u32).filter(|&id| predicate::hit(&ray, triangles, id).is_some()) {
                    assert!(seen[id as usize], "{ray:?} hits {id}");
                    hits += 1;
                }
                assert!(seen.iter().filter(|&&seen| seen).count() < 300, "{ray:?} comes by most triangles");
            }
            assert!(hits > 100, "{hits}");
        }
    }
}
