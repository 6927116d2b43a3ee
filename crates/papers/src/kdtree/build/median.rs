use super::sah::{Measure, SplitCandidate};
use crate::kdtree::KdBuilder;
use crate::kdtree::extent::{Plane, Reference};

/// Maximum number of triangles of a node that stays a leaf.
const LEAF: usize = 4;

impl KdBuilder {
    /// Whether planes are at the median of a cell or of its boxes.
    pub(super) fn takes_medians(self) -> bool {
        matches!(self, Self::SpatialMedian | Self::SpatialInTurn | Self::ObjectMedian | Self::ObjectInTurn)
    }
}

/// Returns the plane through the middle of a cell, or of the boxes in it, regardless of its cost (thesis, chapter 4). Axes
/// across which the cell can't be cut are passed over.
pub(super) fn best(
    measure: &Measure<'_>,
    references: &[Reference],
    depth: u32,
    builder: KdBuilder,
) -> Option<SplitCandidate> {
    if references.len() <= LEAF {
        return None;
    }
    let side = |axis: usize| measure.extent.max[axis] - measure.extent.min[axis];
    let mut axes = [0, 1, 2].map(|axis| (axis + depth as usize) % 3);
    if matches!(builder, KdBuilder::SpatialMedian | KdBuilder::ObjectMedian) {
        axes.sort_by(|&a, &b| side(b).total_cmp(&side(a)));
    }
    let is_of_objects = matches!(builder, KdBuilder::ObjectMedian | KdBuilder::ObjectInTurn);
    let plane = |axis: usize| {
        let (low, high) = (measure.extent.min[axis], measure.extent.max[axis]);
        let at = if is_of_objects { middle_object(references, axis) } else { 0.5 * low + 0.5 * high };
        (low < at && at < high).then_some(Plane { axis, at })
    };
    let plane = axes.into_iter().find_map(plane)?;
    // Below the cost of any leaf: only depth and memory end the recursion.
    Some(SplitCandidate { cost: f64::NEG_INFINITY, plane, planar_left: true })
}

/// Returns the plane with half of the boxes' middles on each side, midway between the two middles next to it.
fn middle_object(references: &[Reference], axis: usize) -> f32 {
    let middle = |r: &Reference| 0.5 * r.extent.min[axis] + 0.5 * r.extent.max[axis];
    let mut middles: Vec<f32> = references.iter().map(middle).collect();
    let half = middles.len() / 2;
    let (before, &mut first, _) = middles.select_nth_unstable_by(half, f32::total_cmp);
    let last = before.iter().copied().max_by(f32::total_cmp).unwrap_or(first);
    0.5 * last + 0.5 * first
}
