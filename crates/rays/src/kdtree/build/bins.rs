//! Finding planes by counting boxes that begin and end between them: the samples of Popov et al. 2006.

use super::sah::{Candidate, Measure};
use crate::kdtree::extent::{Extent, Reference};

/// How many boxes begin and end in each of `N` slices of a cell, by axis.
#[derive(Clone)]
pub(super) struct Bins<const N: usize> {
    begins: [[u32; N]; 3],
    ends: [[u32; N]; 3],
    /// Around all boxes.
    around: Extent,
    low: [f32; 3],
    /// Bins for each unit of length.
    scale: [f32; 3],
}

impl<const N: usize> Bins<N> {
    pub(super) fn over(cell: Extent) -> Self {
        let scale = [0, 1, 2].map(|axis| N as f32 / (cell.max[axis] - cell.min[axis]));
        Self { begins: [[0; N]; 3], ends: [[0; N]; 3], around: Extent::EMPTY, low: cell.min, scale }
    }

    /// In flat and in huge cells all coordinates may fall into one bin. That costs quality only: counts just say which plane
    /// may be good.
    #[inline(always)]
    fn bin(&self, axis: usize, coordinate: f32) -> usize {
        (((coordinate - self.low[axis]) * self.scale[axis]) as usize).min(N - 1)
    }

    #[inline(always)]
    pub(super) fn add_one(&mut self, extent: &Extent) {
        for axis in 0..3 {
            let [begin, end] = [extent.min[axis], extent.max[axis]].map(|face| self.bin(axis, face));
            self.begins[axis][begin] += 1;
            self.ends[axis][end] += 1;
        }
        self.around = self.around.union(*extent);
    }

    pub(super) fn add(&mut self, references: &[Reference]) {
        references.iter().for_each(|reference| self.add_one(&reference.extent));
    }

    /// The best plane between two bins, or one that cuts off what is empty.
    pub(super) fn best(&self, mut measure: Measure<'_>) -> Option<Candidate> {
        for axis in 0..3 {
            let along = measure.axis(axis);
            let (low, high) = (f64::from(along.low), f64::from(along.high));
            let (mut left, mut right) = (0, measure.count as u32);
            for bin in 0..N - 1 {
                left += self.begins[axis][bin];
                right -= self.ends[axis][bin];
                let at = low + (high - low) * ((bin + 1) as f64 / N as f64);
                measure.consider(&along, at as f32 + 0.0, [f64::from(left), 0.0, f64::from(right)]);
            }
            measure.consider_empty(&along, self.around.min[axis], true);
            measure.consider_empty(&along, self.around.max[axis], false);
        }
        measure.best
    }
}
