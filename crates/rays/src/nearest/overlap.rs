//! Triangles that touch boxes.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use rayon::prelude::*;

use super::exact::touches;
use super::{Nearest, Within};
use crate::parallel::Parallel;
use crate::patches::{BoxTree, Patches, SixteenBoxes};
use crate::simd::lanes::{LANES, bits_of, load, splat};
use crate::{Bounds, Triangles, dispatch, vectorized};

/// The inputs of finding the triangles that touch boxes.
struct Search<'a> {
    triangles: Triangles<'a>,
    patches: &'a Patches,
    boxes: &'a BoxTree,
}

impl Nearest {
    /// Lists the triangles that have a point in common with each box, in real numbers; its faces, edges and corners belong to
    /// it. Triangles without area count as segments or points, and a box without a length on an axis as what it is. A box with
    /// `min` above `max` on an axis, or with NaN, touches nothing; it may be infinite.
    ///
    /// # Panics
    /// If it was built for another number of triangles.
    pub fn overlapping(&mut self, triangles: Triangles<'_>, boxes: &[Bounds], found: &mut Within) {
        self.patches.expect(triangles);
        let mut lists = std::mem::take(&mut self.lists);
        lists.iter_mut().for_each(Vec::clear);
        lists.resize_with(boxes.len(), Vec::new);
        let search = Search { triangles, patches: &self.patches, boxes: &self.boxes };
        lists.par_iter_mut().zip(boxes).with_max_len(16).each(|(list, bounds)| {
            // All triangles that count are within these numbers.
            let ends = [bounds.min, bounds.max].map(|end| end.to_array().map(|end| end.clamp(-f32::MAX, f32::MAX)));
            // False for NaN.
            if bounds.min.cmple(bounds.max).all() && search.patches.len() > 0 {
                dispatch!(self.level, simd => search.descend(simd, (search.boxes.top(), 0), ends, list));
                list.sort_unstable();
            }
        });
        let Within { triangle, starts } = found;
        triangle.clear();
        starts.clear();
        starts.push(0);
        for list in &lists {
            triangle.extend_from_slice(list);
            starts.push(triangle.len());
        }
        self.lists = lists;
    }
}

impl Search<'_> {
    /// Lists the triangles below a node of the tree that touch the box between two corners.
    fn descend<S: Simd>(&self, simd: S, (level, number): (usize, usize), ends: [[f32; 3]; 2], list: &mut Vec<u32>) {
        let (boxes, count) = self.boxes.node(self.patches, level, number);
        let touched = vectorized!(simd => touched(simd, boxes, ends));
        for lane in bits_of(touched & (u16::MAX >> (LANES - count))) {
            let below = number * LANES + lane;
            if level > 0 {
                self.descend(simd, (level - 1, below), ends, list);
            } else {
                self.test(below, ends, list);
            }
        }
    }

    /// Tests the triangles of a patch.
    fn test(&self, number: usize, [low, high]: [[f32; 3]; 2], list: &mut Vec<u32>) {
        let patch = self.patches.get(number);
        for &id in &patch.ids[..patch.count] {
            let corners = self.triangles.corners(id);
            let is_beside = (0..3).any(|axis| {
                let of_axis = corners.map(|corner| corner[axis]);
                of_axis.iter().all(|&end| end < low[axis]) || of_axis.iter().all(|&end| end > high[axis])
            });
            let is_inside = |axis: usize, coordinate: f32| low[axis] <= coordinate && coordinate <= high[axis];
            let has_corner = corners.iter().any(|corner| (0..3).all(|axis| is_inside(axis, corner[axis])));
            let is_finite = corners.iter().all(|corner| corner.is_finite());
            if is_finite && !is_beside && (has_corner || touches([low.into(), high.into()], corners)) {
                list.push(id);
            }
        }
    }
}

/// A mask of the boxes, of sixteen, that may have a point in common with the box between two corners. Comparisons are exact,
/// and a box of NaN is all of space.
#[inline(always)]
fn touched<S: Simd>(simd: S, boxes: &SixteenBoxes, [low, high]: [[f32; 3]; 2]) -> u16 {
    let mut beside = 0;
    for axis in 0..3 {
        let (box_low, box_high): (f32x16<S>, f32x16<S>) = (load(simd, &boxes.low[axis]), load(simd, &boxes.high[axis]));
        let is_beside = box_low.simd_gt(splat(simd, high[axis])) | box_high.simd_lt(splat(simd, low[axis]));
        beside |= is_beside.to_bitmask() as u16;
    }
    !beside
}
