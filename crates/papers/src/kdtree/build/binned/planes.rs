//! Finds the best of sixteen planes across each axis, by comparing every box with all of them at once.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::boxes::{Around, Boxed};
use crate::kdtree::SahCosts;
use crate::kdtree::build::sah::SplitCandidate;
use crate::kdtree::extent::{Extent, Plane};

/// The number of planes across each axis.
pub(super) const PLANES: usize = 16;

/// Maximum number of boxes whose faces all become planes.
pub(super) const EXACT_FROM: usize = PLANES / 2;

/// The numbers of boxes that begin below, and that end above, each of the planes across each axis.
pub(super) type Counts = [[[u32; PLANES]; 2]; 3];

/// Evenly spaced weights from 0 to 1, one for each plane.
const WEIGHTS: [f32; PLANES] = {
    let mut weights = [0.0; PLANES];
    let mut index = 0;
    while index < PLANES {
        weights[index] = index as f32 / (PLANES - 1) as f32;
        index += 1;
    }
    weights
};

/// Returns evenly spaced planes from the lower to the upper end of the boxes: the outermost cut off empty space.
#[inline(always)]
fn spread<S: Simd>(simd: S, around: &Around) -> [f32x16<S>; 3] {
    let [low, high] = around.corners();
    let weight = f32x16::from_slice(simd, &WEIGHTS);
    let rest = 1.0 - weight;
    [rest * low[0] + weight * high[0], rest * low[1] + weight * high[1], rest * low[2] + weight * high[2]]
}

/// Returns the planes of all faces of a few boxes.
#[inline(always)]
fn faces<S: Simd>(simd: S, boxes: &[Boxed]) -> [f32x16<S>; 3] {
    let mut planes = [[f32::INFINITY; PLANES]; 3];
    for (index, boxed) in boxes.iter().enumerate().take(EXACT_FROM) {
        for (axis, planes) in planes.iter_mut().enumerate() {
            planes[index] = boxed.low(axis);
            planes[EXACT_FROM + index] = boxed.high(axis);
        }
    }
    let [x, y, z] = &planes;
    [f32x16::from_slice(simd, x), f32x16::from_slice(simd, y), f32x16::from_slice(simd, z)]
}

/// Planes across each axis, and the numbers of boxes that begin below and end above each.
pub(super) struct Counted<S: Simd> {
    planes: [f32x16<S>; 3],
    counts: [[f32x16<S>; 2]; 3],
}

/// Counts all boxes of a node, fewer than 2²⁴.
#[inline(always)]
pub(super) fn count_all<S: Simd>(simd: S, boxes: &[Boxed]) -> Counted<S> {
    if boxes.len() <= EXACT_FROM {
        let planes = faces(simd, boxes);
        return Counted { planes, counts: count(simd, boxes, &planes) };
    }
    count_within(simd, boxes, &Around::all(simd, boxes))
}

/// Counts boxes of a node at planes within a box.
#[inline(always)]
pub(super) fn count_within<S: Simd>(simd: S, boxes: &[Boxed], around: &Around) -> Counted<S> {
    let planes = spread(simd, around);
    Counted { planes, counts: count(simd, boxes, &planes) }
}

impl<S: Simd> Counted<S> {
    /// The counts as whole numbers.
    #[inline(always)]
    pub(super) fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for (to, from) in counts.as_flattened_mut().iter_mut().zip(self.counts.as_flattened()) {
            for (index, count) in to.iter_mut().enumerate() {
                *count = from[index] as u32;
            }
        }
        counts
    }
}

#[inline(always)]
fn count<S: Simd>(simd: S, boxes: &[Boxed], planes: &[f32x16<S>; 3]) -> [[f32x16<S>; 2]; 3] {
    let (none, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let opposite = [-planes[0], -planes[1], -planes[2]];
    let mut counts = [[none; 2]; 3];
    for Boxed(faces) in boxes {
        for axis in 0..3 {
            let begins = f32x16::splat(simd, faces[axis]).simd_lt(planes[axis]);
            counts[axis][0] += begins.select(one, none);
            let ends = f32x16::splat(simd, faces[4 + axis]).simd_lt(opposite[axis]);
            counts[axis][1] += ends.select(one, none);
        }
    }
    counts
}

/// As [`count_within`], for a part of a node's boxes.
#[inline(always)]
pub(super) fn count_part<S: Simd>(simd: S, boxes: &[Boxed], around: &Around) -> Counts {
    count_within(simd, boxes, around).counts()
}

/// Returns the plane of least cost among those within `around` that `counts` belong to.
#[inline(always)]
pub(super) fn best_of<S: Simd>(simd: S, node: &Node<'_>, around: &Around, counts: &Counts) -> Option<SplitCandidate> {
    let mut all = [[f32x16::splat(simd, 0.0); 2]; 3];
    for axis in 0..3 {
        for side in 0..2 {
            for index in 0..PLANES {
                all[axis][side][index] = counts[axis][side][index] as f32;
            }
        }
    }
    let counted = Counted { planes: spread(simd, around), counts: all };
    least(simd, node, &counted).map(|best| best.candidate)
}

/// A node to be split.
pub(super) struct Node<'a> {
    pub(super) costs: &'a SahCosts,
    pub(super) extent: &'a Extent,
    pub(super) count: usize,
    /// 1 over half of the surface area of the node's cell.
    per_area: f64,
}

impl<'a> Node<'a> {
    pub(super) fn new(costs: &'a SahCosts, extent: &'a Extent, count: usize) -> Self {
        Self { costs, extent, count, per_area: 1.0 / extent.half_area() }
    }
}

/// A plane, and whether the left and the right of it are empty.
pub(super) struct Best {
    pub(super) candidate: SplitCandidate,
    pub(super) is_empty: [bool; 2],
}

/// The plane of least cost.
#[inline(always)]
pub(super) fn least<S: Simd>(simd: S, node: &Node<'_>, counted: &Counted<S>) -> Option<Best> {
    let Counted { planes, counts } = counted;
    let infinite = f32x16::splat(simd, f32::INFINITY);
    let mut by_axis = [infinite; 3];
    for axis in 0..3 {
        by_axis[axis] = cost(simd, node, axis, planes[axis], counts[axis]);
    }
    let cost = by_axis[0].min(by_axis[1]).min(by_axis[2]).reduce_min();
    if cost == f32::INFINITY {
        return None;
    }
    let least = f32x16::splat(simd, cost);
    for axis in 0..3 {
        let lanes = by_axis[axis].simd_eq(least).to_bitmask();
        if lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            let at = planes[axis][lane] + 0.0;
            // If a count is 0, no box is on both sides. Boxes inside the plane are on the right if `is_right`, else on the
            // left.
            let [is_left_empty, is_right_empty] = [0, 1].map(|side| counts[axis][side][lane] == 0.0);
            let is_right = (is_left_empty && at > node.extent.min[axis]) || at == node.extent.max[axis];
            let candidate = SplitCandidate { cost: f64::from(cost), plane: Plane { axis, at }, planar_left: !is_right };
            return Some(Best { candidate, is_empty: [is_right && is_left_empty, !is_right && is_right_empty] });
        }
    }
    None
}

/// Returns the costs of planes across an axis; infinity outside of the node.
#[inline(always)]
fn cost<S: Simd>(simd: S, node: &Node<'_>, axis: usize, at: f32x16<S>, [left, right]: [f32x16<S>; 2]) -> f32x16<S> {
    let SahCosts { step, test, empty, mailbox, .. } = *node.costs;
    let extent = node.extent;
    let side = |axis: usize| f64::from(extent.max[axis]) - f64::from(extent.min[axis]);
    let (length, a, b) = (side(axis), side((axis + 1) % 3), side((axis + 2) % 3));
    let (none, all) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, node.count as f32));
    let infinite = f32x16::splat(simd, f32::INFINITY);
    let face = (a * b * node.per_area) as f32;
    let rim = (length * (a + b) * node.per_area) as f32;
    let low = f32x16::splat(simd, extent.min[axis]);
    let high = f32x16::splat(simd, extent.max[axis]);
    let inverse = 1.0 / length as f32;
    let left_share = (at - low) * inverse * rim + face;
    let right_share = (high - at) * inverse * rim + face;
    // The number of triangles inside the plane, if none is on both sides. In a face of the cell they are cut off, else they
    // go to the side that has others.
    let planar = (all - left - right).max(none);
    let is_face = (at.simd_eq(low) | at.simd_eq(high)) & planar.simd_gt(none);
    let is_right = (left.simd_eq(none) & at.simd_gt(low)) | at.simd_eq(high);
    let right = right + is_right.select(planar, none);
    let left = left + is_right.select(none, planar);
    let twice = if mailbox { (left + right - all) * (left_share + right_share - 1.0) } else { none };
    let cost = (left * left_share + right * right_share - twice) * (test as f32) + step as f32;
    let is_empty = left.simd_eq(none) | right.simd_eq(none);
    let cost = is_empty.select(cost * (empty as f32), cost);
    let is_inside = ((low.simd_lt(at) & at.simd_lt(high)) | is_face) & cost.simd_lt(infinite);
    is_inside.select(cost, infinite)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use umbrage_rays::dispatch;

    use super::*;
    use crate::kdtree::KdTreeOptions;
    use crate::kdtree::build::naive;
    use crate::kdtree::build::sah::{Heuristic, Measure};
    use crate::kdtree::extent::Reference;
    use umbrage_rays::SimdLevel;

    fn boxes(count: u32) -> Vec<Boxed> {
        let point = |step: u32| Vec3::from_array([7.3, 3.1, 5.7].map(|factor| (step as f32 * factor).sin()));
        let small = |id: u32| [id * 3, id * 3 + 1, id * 3 + 2].map(|step| point(id) + point(step) * 0.2);
        (0..count).map(|id| Boxed::around(small(id), id)).collect()
    }

    #[test]
    fn planes_of_few_boxes_are_the_exact_ones() {
        let costs = KdTreeOptions::DEFAULT.costs;
        for count in 1..=EXACT_FROM as u32 {
            let boxes = boxes(count);
            let reference = |boxed: &Boxed| {
                let (min, max) = ([0, 1, 2].map(|axis| boxed.low(axis)), [0, 1, 2].map(|axis| boxed.high(axis)));
                Reference { extent: Extent { min, max }, id: boxed.id() }
            };
            let references: Vec<_> = boxes.iter().map(reference).collect();
            let extent = Extent { min: [-1.5; 3], max: [1.5, 1.25, 2.0] };
            let heuristic = Heuristic::new(costs, 100);
            let exact = naive::best(Measure::new(&heuristic, extent, count as usize), &references).expect("a plane");
            let node = Node::new(&costs, &extent, count as usize);
            for level in SimdLevel::available() {
                let found = dispatch!(level, simd => least(simd, &node, &count_all(simd, &boxes)));
                let found = found.expect("a plane").candidate;
                assert_eq!(found.plane, exact.plane, "{count}");
                assert!((found.cost - exact.cost).abs() < 1e-5 * exact.cost, "{found:?} {exact:?}");
            }
        }
    }

    #[test]
    fn triangles_in_a_face_of_the_cell_are_cut_off() {
        let flat = |z: f32, id: u32| Boxed::around([Vec3::Z * z, Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)], id);
        let middle = Boxed::around([Vec3::new(0.0, 0.0, 1.5), Vec3::new(1.0, 0.0, 1.9), Vec3::new(0.0, 1.0, 2.5)], 9);
        let extent = Extent { min: [0.0; 3], max: [1.0, 1.0, 4.0] };
        for (z, is_left) in [(0.0, true), (4.0, false)] {
            let mut boxes: Vec<_> = (0..7).map(|id| flat(z, id)).collect();
            boxes.push(middle);
            // Without a bonus for an empty side no other plane pays.
            let costs = SahCosts { empty: 1.0, ..KdTreeOptions::DEFAULT.costs };
            let node = Node::new(&costs, &extent, boxes.len());
            for level in SimdLevel::available() {
                let found = dispatch!(level, simd => least(simd, &node, &count_all(simd, &boxes)));
                let found = found.expect("a plane").candidate;
                assert_eq!((found.plane, found.planar_left), (Plane { axis: 2, at: z }, is_left));
            }
        }
    }

    #[test]
    fn sides_without_boxes_are_known() {
        let costs = KdTreeOptions::DEFAULT.costs;
        for count in [3, EXACT_FROM as u32, 100] {
            let boxes = boxes(count);
            // Planes that cut off empty space on the left, on the right, and others.
            for (min, max) in [([-9.0; 3], [1.5; 3]), ([-1.5; 3], [9.0; 3]), ([-1.5; 3], [1.5; 3])] {
                let extent = Extent { min, max };
                let node = Node::new(&costs, &extent, boxes.len());
                for level in SimdLevel::available() {
                    let found = dispatch!(level, simd => least(simd, &node, &count_all(simd, &boxes)));
                    let Best { candidate: SplitCandidate { plane, planar_left, .. }, is_empty } =
                        found.expect("a plane");
                    let low = |boxed: &Boxed| boxed.low(plane.axis);
                    let high = |boxed: &Boxed| boxed.high(plane.axis);
                    let is_left = |boxed| low(boxed) < plane.at || planar_left && high(boxed) <= plane.at;
                    let is_right = |boxed| high(boxed) > plane.at || !planar_left && low(boxed) >= plane.at;
                    assert_eq!(is_empty, [!boxes.iter().any(is_left), !boxes.iter().any(is_right)]);
                    if min[0] == -9.0 || max[0] == 9.0 {
                        assert_eq!(is_empty, [min[0] == -9.0, max[0] == 9.0], "the plane cuts off what is empty");
                    }
                }
            }
        }
    }

    #[test]
    fn parts_of_a_node_count_as_the_whole() {
        let boxes = boxes(100);
        let extent = Extent { min: [-1.5; 3], max: [1.5; 3] };
        let node = Node::new(&KdTreeOptions::DEFAULT.costs, &extent, boxes.len());
        let mut planes = Vec::new();
        for level in SimdLevel::available() {
            let pair = dispatch!(level, simd => {
                let around = Around::all(simd, &boxes);
                let mut counts = Counts::default();
                for part in boxes.chunks(33) {
                    let part = count_part(simd, part, &around);
                    let part = part.iter().flatten().flatten();
                    counts.iter_mut().flatten().flatten().zip(part).for_each(|(count, part)| *count += part);
                }
                let whole = least(simd, &node, &count_all(simd, &boxes)).map(|best| best.candidate);
                [best_of(simd, &node, &around, &counts), whole]
            });
            planes.extend(pair.map(|best| best.expect("a plane").plane));
        }
        assert!(planes.iter().all(|plane| *plane == planes[0]), "{planes:?}");
    }
}
