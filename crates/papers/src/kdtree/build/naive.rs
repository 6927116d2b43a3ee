//! Finding planes by counting triangles for each one anew: Wald and Havran 2006, §4.1.

use super::sah::{Measure, SplitCandidate};
use crate::kdtree::extent::Reference;

/// Returns the best plane among the faces of the references' boxes.
pub(super) fn best(mut measure: Measure<'_>, references: &[Reference]) -> Option<SplitCandidate> {
    for axis in 0..3 {
        let along = measure.axis(axis);
        for reference in references {
            let (low, high) = (reference.extent.min[axis], reference.extent.max[axis]);
            for at in [low, high] {
                // Most boxes reach to a face of the cell, and a plane there parts only flat ones from the others.
                if low < high && (at <= along.low || at >= along.high) {
                    continue;
                }
                let mut counts = [0_u32; 3];
                for Reference { extent, .. } in references {
                    let (low, high) = (extent.min[axis], extent.max[axis]);
                    counts[0] += u32::from(low < at);
                    counts[1] += u32::from(low == at && high == at);
                    counts[2] += u32::from(high > at);
                }
                measure.consider(&along, at, counts.map(f64::from));
            }
        }
    }
    measure.best
}
