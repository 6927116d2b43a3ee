//! Planes among most of a node's boxes, where a few others stretch it. In a scene with one far vertex, sixteen evenly spaced
//! planes would have all other boxes between two of them, and so would those of the next nodes, until the tree is as deep as
//! it may be.

use super::boxes::{Around, Boxed};
use super::planes::Counts;

/// One box in this number may lie far from most.
const OUTLIERS: usize = 8;

/// Boxes within this multiple of the extent of most count as near them.
const NEARNESS: f32 = 16.0;

/// Returns the box in which to place planes, if along any axis nearly all boxes are between two neighbours of the planes
/// within `around` that `counts` belong to.
pub(super) fn among_most<'a>(
    around: &Around,
    counts: &Counts,
    boxes: &(impl Iterator<Item = &'a Boxed> + Clone),
) -> Option<Around> {
    let count = boxes.clone().count();
    let is_crowded = |axis: usize| {
        let [left, right] = &counts[axis];
        left.iter().zip(&right[1..]).any(|(left, right)| (left + right) as usize <= count / OUTLIERS)
    };
    let mut most = *around;
    let mut is_any_crowded = false;
    for axis in (0..3).filter(|&axis| is_crowded(axis)) {
        is_any_crowded = true;
        most.set(axis, along(axis, boxes.clone()));
    }
    is_any_crowded.then_some(most)
}

/// Returns the lower and the upper end, along an axis, of most boxes and of all near them.
fn along<'a>(axis: usize, boxes: impl Iterator<Item = &'a Boxed> + Clone) -> [f32; 2] {
    let nth = |faces: &mut Vec<f32>, index: usize| *faces.select_nth_unstable_by(index, f32::total_cmp).1;
    let mut faces: Vec<f32> = boxes.clone().map(|boxed| boxed.low(axis)).collect();
    let outliers = faces.len() / OUTLIERS;
    let low = nth(&mut faces, outliers);
    faces.clear();
    faces.extend(boxes.clone().map(|boxed| boxed.high(axis)));
    let last = faces.len() - 1 - outliers;
    let high = nth(&mut faces, last);
    let margin = (high - low) * NEARNESS;
    let near = boxes.filter(|boxed| boxed.low(axis) >= low - margin && boxed.high(axis) <= high + margin);
    near.fold([low, high], |[low, high], boxed| [low.min(boxed.low(axis)), high.max(boxed.high(axis))])
}
