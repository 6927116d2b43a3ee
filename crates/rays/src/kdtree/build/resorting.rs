//! Finding planes by sorting the faces of boxes at each node: Wald and Havran 2006, §4.2.

use super::presorted;
use super::sah::{Candidate, Measure};
use crate::kdtree::extent::Reference;

/// The best plane among the faces of the references' boxes; `events` is room to work in.
pub(super) fn best(mut measure: Measure<'_>, references: &[Reference], events: &mut Vec<u64>) -> Option<Candidate> {
    for axis in 0..3 {
        events.clear();
        for (reference, index) in references.iter().zip(0..) {
            presorted::push_axis(events, reference.extent.min[axis], reference.extent.max[axis], index);
        }
        events.sort_unstable();
        presorted::sweep(&mut measure, axis, events, |_| 1);
    }
    measure.best
}
