//! Finding planes by sorting the faces of boxes at each node: Wald and Havran 2006, §4.2.

use super::presorted;
use super::sah::{Measure, SplitCandidate};
use crate::kdtree::extent::Extent;

/// Returns the best plane among the faces of items. `of` returns an item's box and the number of triangles that it counts
/// as; `events` is working memory.
pub(super) fn best<T>(
    mut measure: Measure<'_>,
    all: &[T],
    of: impl Fn(&T) -> (Extent, u32),
    events: &mut Vec<u64>,
) -> Option<SplitCandidate> {
    for axis in 0..3 {
        events.clear();
        for (one, index) in all.iter().zip(0..) {
            let (extent, _) = of(one);
            presorted::push_axis(events, extent.min[axis], extent.max[axis], index);
        }
        events.sort_unstable();
        let before = [0.0, measure.count as f64];
        measure = presorted::sweep(measure, axis, events, before, |index| of(&all[index]).1);
    }
    measure.best
}
