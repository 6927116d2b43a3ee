//! Finding planes by counting triangles for each one anew: Wald and Havran 2006, §4.1.

use super::sah::{Candidate, Measure};
use crate::kdtree::extent::Reference;

/// The best plane among the faces of the references' boxes.
pub(super) fn best(mut measure: Measure<'_>, references: &[Reference]) -> Option<Candidate> {
    for reference in references {
        for axis in 0..3 {
            let along = measure.axis(axis);
            for at in [reference.extent.min[axis], reference.extent.max[axis]] {
                let mut counts = [0.0; 3];
                for Reference { extent, .. } in references {
                    let (low, high) = (extent.min[axis], extent.max[axis]);
                    counts[0] += f64::from(u8::from(low < at));
                    counts[1] += f64::from(u8::from(low == at && high == at));
                    counts[2] += f64::from(u8::from(high > at));
                }
                measure.consider(&along, at, counts);
            }
        }
    }
    measure.best
}
