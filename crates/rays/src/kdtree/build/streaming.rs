//! Building from a stream of boxes: while they are written to a node's children, they are counted at the children's samples
//! (Popov et al. 2006, §4).

use super::Job;
use super::bins::Bins;
use super::grow::Method;
use super::sah::{Cell, Measure};
use super::space::{Frame, Space};
use crate::kdtree::extent::Reference;
use crate::kdtree::layout::Branch;

/// Parts between samples along each axis.
const PARTS: usize = 1024;

/// Nodes of fewer references fit in a cache and are split exactly.
const EXACT_FROM: usize = 1 << 12;

type Samples = Box<Bins<PARTS>>;

impl Job<'_> {
    /// Adds the tree of all references of a space, and empties that.
    pub(super) fn stream(&self, space: &mut Space, cell: Cell, out: &mut Branch) {
        let mut samples = Box::new(Bins::over(cell.extent));
        samples.add(&space.references);
        self.stream_samples(space, samples, cell, out);
    }

    fn stream_samples(&self, space: &mut Space, samples: Samples, cell: Cell, out: &mut Branch) {
        let count = space.references.len();
        if count < EXACT_FROM {
            return self.grow(space, Frame::default(), Method::Unsorted, cell, out);
        }
        let best = samples.best(Measure::new(&self.heuristic, cell.extent, count));
        drop(samples);
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(space.references.iter().map(|reference| reference.id));
            space.truncate(Frame::default());
            return;
        };
        let mut children = [self.pool.spaces.take(), self.pool.spaces.take()];
        let mut samples = cells.map(|cell| Box::new(Bins::over(cell.extent)));
        let mut push = |side: usize, reference: Reference| {
            samples[side].add_one(&reference.extent);
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
