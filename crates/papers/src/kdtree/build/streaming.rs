//! Building from a stream of boxes: while they are written to a node's children, they are counted at the children's samples
//! (Popov et al. 2006, §4).

use super::Job;
use super::sah::{Cell, Measure, SplitCandidate};
use super::space::{Frame, Space};
use crate::kdtree::KdBuilder;
use crate::kdtree::extent::{Extent, Reference};
use crate::kdtree::layout::Branch;

/// The number of parts between samples along each axis.
const PARTS: usize = 1024;

/// Nodes of fewer references fit in a cache and are split exactly.
const EXACT_FROM: usize = 1 << 12;

impl Job<'_> {
    /// Adds the tree of all references of a space, and empties that.
    pub(super) fn stream(&self, space: &mut Space, cell: Cell, out: &mut Branch) {
        let mut samples = Samples::over(cell.extent);
        space.references.iter().for_each(|reference| samples.add(&reference.extent));
        self.stream_samples(space, samples, cell, out);
    }

    fn stream_samples(&self, space: &mut Space, samples: Box<Samples>, cell: Cell, out: &mut Branch) {
        let count = space.references.len();
        if count < EXACT_FROM {
            return self.grow(space, Frame::default(), KdBuilder::Presorted, false, cell, out);
        }
        let best = samples.best(Measure::new(&self.heuristic, cell.extent, count));
        drop(samples);
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(space.references.iter().map(|reference| reference.id));
            space.truncate(Frame::default());
            return;
        };
        let mut children = [self.pool.spaces.take(), self.pool.spaces.take()];
        let mut samples = cells.map(|cell| Samples::over(cell.extent));
        let mut push = |side: usize, reference: Reference| {
            samples[side].add(&reference.extent);
            children[side].references.push(reference);
        };
        for reference in space.references.drain(..) {
            let (_, parts) = self.part(&reference, &best);
            parts.into_iter().enumerate().for_each(|(side, part)| part.into_iter().for_each(|part| push(side, part)));
        }
        let cells = Cell::share(cells, [0, 1].map(|side| children[side].references.len()));
        let ([mut left, mut right], [left_samples, right_samples]) = (children, samples);
        self.join(
            best.plane,
            out,
            |out| self.stream_samples(&mut left, left_samples, cells[0], out),
            |out| self.stream_samples(&mut right, right_samples, cells[1], out),
        );
        self.pool.spaces.keep(left);
        self.pool.spaces.keep(right);
    }
}

/// The numbers of boxes that begin and that end in each part of a cell, by axis.
struct Samples {
    begins: [[u32; PARTS]; 3],
    ends: [[u32; PARTS]; 3],
    /// The bounds of all boxes.
    around: Extent,
    low: [f32; 3],
    /// Bins for each unit of length.
    scale: [f32; 3],
}

impl Samples {
    fn over(cell: Extent) -> Box<Self> {
        let scale = [0, 1, 2].map(|axis| PARTS as f32 / (cell.max[axis] - cell.min[axis]));
        let counts = [[0; PARTS]; 3];
        Box::new(Self { begins: counts, ends: counts, around: Extent::EMPTY, low: cell.min, scale })
    }

    /// In flat and in huge cells all coordinates may fall into one bin. That costs quality only: counts just suggest planes.
    #[inline(always)]
    fn bin(&self, axis: usize, coordinate: f32) -> usize {
        (((coordinate - self.low[axis]) * self.scale[axis]) as usize).min(PARTS - 1)
    }

    #[inline(always)]
    fn add(&mut self, extent: &Extent) {
        for axis in 0..3 {
            let [begin, end] = [extent.min[axis], extent.max[axis]].map(|face| self.bin(axis, face));
            self.begins[axis][begin] += 1;
            self.ends[axis][end] += 1;
        }
        self.around = self.around.union(*extent);
    }

    /// Returns the best plane between two bins, or one that cuts off empty space.
    fn best(&self, mut measure: Measure<'_>) -> Option<SplitCandidate> {
        for axis in 0..3 {
            let along = measure.axis(axis);
            let (low, high) = (f64::from(along.low), f64::from(along.high));
            let (mut left, mut right) = (0, measure.count as u32);
            for bin in 0..PARTS - 1 {
                left += self.begins[axis][bin];
                right -= self.ends[axis][bin];
                let at = low + (high - low) * ((bin + 1) as f64 / PARTS as f64);
                measure.consider(&along, at as f32 + 0.0, [f64::from(left), 0.0, f64::from(right)]);
            }
            measure.consider_empty(&along, self.around.min[axis], true);
            measure.consider_empty(&along, self.around.max[axis], false);
        }
        measure.best
    }
}
