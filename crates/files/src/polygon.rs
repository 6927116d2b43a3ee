//! Triangulation of polygons.

mod ears;

use glam::Vec3;

use self::ears::{Ears, concave_in};
use crate::memory::Budget;

/// Maximum number of corners of polygons that become fans.
const MOST_IN_A_FAN: usize = 256;

/// Cuts a file's polygons into triangles, two fewer than each has corners.
///
/// Concave polygons, including those with holes joined to the outline by bridges, are cut by ear clipping. Convex polygons,
/// those without area and those with a coordinate that isn't finite are cut by [`convex`].
#[derive(Debug, Default)]
pub(crate) struct Cutter {
    ears: Ears,
    /// Polygons with corners whose positions follow later in the file; cut as convex ones for now.
    waiting: Vec<Waiting>,
    corners_waiting: Vec<u32>,
    /// Number of polygons cut without all tests, which would have taken too long.
    hasty: usize,
    /// Capacity of `ears` in corners.
    room: usize,
    budget: Budget,
}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    first_triangle: usize,
    corners: usize,
}

impl Cutter {
    /// Makes a cutter that takes memory from `budget`.
    pub(crate) fn new(budget: &Budget) -> Self {
        Self { budget: budget.clone(), ..Self::default() }
    }

    /// Appends the triangles of a polygon; `position` returns `None` for vertices that the file hasn't listed yet.
    ///
    /// # Errors
    /// Where memory is too small.
    pub(crate) fn cut(
        &mut self,
        corners: &[u32],
        position: impl Fn(u32) -> Option<Vec3>,
        triangles: &mut Vec<[u32; 3]>,
    ) -> Result<(), String> {
        self.budget.reserve(triangles, corners.len().saturating_sub(2), "triangles")?;
        if corners.len() > 3 {
            if corners.iter().any(|&corner| position(corner).is_none()) {
                self.budget.reserve(&mut self.waiting, 1, "faces")?;
                self.budget.reserve(&mut self.corners_waiting, corners.len(), "faces' corners")?;
                self.waiting.push(Waiting { first_triangle: triangles.len(), corners: corners.len() });
                self.corners_waiting.extend_from_slice(corners);
            } else if self.cut_concave(corners, &position, |triangle| triangles.push(triangle))? {
                return Ok(());
            }
        }
        convex(corners, |triangle| triangles.push(triangle));
        Ok(())
    }

    /// Cuts the waiting polygons again, once all positions are known.
    ///
    /// # Errors
    /// Where memory is too small.
    pub(crate) fn finish(
        &mut self,
        position: impl Fn(u32) -> Option<Vec3>,
        triangles: &mut [[u32; 3]],
    ) -> Result<(), String> {
        let all = std::mem::take(&mut self.corners_waiting);
        let mut rest = &all[..];
        for Waiting { first_triangle, corners } in std::mem::take(&mut self.waiting) {
            let (corners, others) = rest.split_at(corners);
            rest = others;
            let mut slots = triangles[first_triangle..].iter_mut();
            if corners.iter().all(|&corner| position(corner).is_some()) {
                self.cut_concave(corners, &position, |triangle| {
                    if let Some(slot) = slots.next() {
                        *slot = triangle;
                    }
                })?;
            }
        }
        Ok(())
    }

    /// Cuts a polygon if it is concave; returns whether it is.
    fn cut_concave(
        &mut self,
        corners: &[u32],
        position: impl Fn(u32) -> Option<Vec3>,
        mut add: impl FnMut([u32; 3]),
    ) -> Result<bool, String> {
        let points = corners.iter().map(|&corner| position(corner).unwrap_or(Vec3::NAN));
        let Some(axes) = concave_in(points.clone()) else { return Ok(false) };
        if let Some(more @ 1..) = corners.len().checked_sub(self.room) {
            // Lists grow to twice their size.
            self.budget.take_for::<[u8; 2 * Ears::BYTES_OF_CORNER]>(more, "a face's corners")?;
            self.room = corners.len();
        }
        let is_careful = self.ears.cut(points, axes, |ear| add(ear.map(|at| corners[at as usize])));
        self.hasty += usize::from(!is_careful);
        Ok(true)
    }

    /// A warning, if polygons were too large to be cut exactly.
    pub(crate) fn warning(&self) -> Option<String> {
        (self.hasty > 0)
            .then(|| format!("{} faces have so many corners that notches and holes in them may be filled", self.hasty))
    }
}

/// Cuts a convex polygon: into a fan for up to [`MOST_IN_A_FAN`] corners. In larger polygons every second remaining corner
/// is cut off, repeatedly. That makes triangles between near corners; a fan would have a million slivers across the polygon,
/// which take minutes to render.
///
/// Takes linear time.
fn convex(corners: &[u32], mut add: impl FnMut([u32; 3])) {
    if corners.len() <= MOST_IN_A_FAN {
        if let Some((&first, others)) = corners.split_first() {
            others.windows(2).for_each(|two| add([first, two[0], two[1]]));
        }
        return;
    }
    let count = corners.len();
    let mut step = 1;
    // While more than two corners are left.
    while 2 * step < count {
        for at in (0..count - step).step_by(2 * step) {
            let behind = corners.get(at + 2 * step).unwrap_or(&corners[0]);
            add([corners[at], corners[at + step], *behind]);
        }
        step *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(count: u32) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = (0..count).map(|corner| 10 * corner).collect();
        let mut cut = Vec::new();
        convex(&corners, |triangle| cut.push(triangle));
        cut
    }

    #[test]
    fn small_polygons_are_fans() {
        assert!((0..3).all(|count| cut(count).is_empty()));
        assert_eq!(cut(5), [[0, 10, 20], [0, 20, 30], [0, 30, 40]]);
        assert!(cut(256).iter().all(|triangle| triangle[0] == 0));
    }

    #[test]
    fn large_polygons_are_covered_once_by_triangles_that_share_their_edges() {
        for count in [257, 258, 300, 511, 512, 513, 1000] {
            let triangles = cut(count);
            assert_eq!(triangles.len() as u32, count - 2, "{count}");
            let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let mut alone = std::collections::BTreeSet::new();
            for [from, to] in edges {
                assert!(from != to);
                if !alone.remove(&[to, from]) {
                    assert!(alone.insert([from, to]), "{count}: {from} to {to} twice");
                }
            }
            let outline = (0..count).map(|corner| [10 * corner, 10 * ((corner + 1) % count)]);
            assert!(alone.into_iter().eq(std::collections::BTreeSet::from_iter(outline)), "{count}");
            let longest = triangles.iter().filter(|triangle| triangle[0] == 0).count();
            assert!(longest < 24, "{longest} triangles of {count} meet in a corner");
        }
    }
}
