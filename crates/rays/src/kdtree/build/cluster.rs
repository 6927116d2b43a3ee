//! The top of the tree for builders by binning: initial clustering (Shevtsov et al. 2007, §3.2), where the passes over a
//! node's references are what threads share.
//!
//! Planes are those of least cost between bins, not medians: the thesis (§4.2) puts the loss of 30 % in trace time down to
//! these.

use rayon::prelude::*;

use super::Job;
use super::binned::{BINS, Bins};
use super::grow::Method;
use super::sah::{Cell, Measure};
use super::space::{Frame, Space};
use crate::kdtree::extent::{Reference, Sides};
use crate::kdtree::layout::Branch;

/// Nodes of fewer references are clusters, which one thread builds.
const CLUSTER: usize = 1 << 14;

/// References that a thread takes at once at the root.
const CHUNK: usize = 1 << 13;

impl Job<'_> {
    /// Adds the tree of all references of a space, which gets empty.
    pub(super) fn cluster(&self, space: &mut Space, cell: Cell, out: &mut Branch) {
        if space.references.len() < CLUSTER {
            return self.grow(space, Frame::default(), Method::Binned, cell, out);
        }
        let chunks: Vec<_> = space.references.par_chunks(CHUNK).map(<[_]>::to_vec).collect();
        space.clear();
        self.cluster_chunks(chunks, cell, out);
    }

    /// Adds the subtree of references that lie in chunks: they stay in as many, so that none waits for another.
    fn cluster_chunks(&self, chunks: Vec<Vec<Reference>>, cell: Cell, out: &mut Branch) {
        let count = chunks.iter().map(Vec::len).sum();
        if count < CLUSTER {
            let mut space = self.pool.space();
            space.references.reserve(count);
            chunks.iter().for_each(|chunk| space.references.extend_from_slice(chunk));
            drop(chunks);
            self.grow(&mut space, Frame::default(), Method::Binned, cell, out);
            self.pool.keep_space(space);
            return;
        }
        let empty = || Bins::<BINS>::over(cell.extent);
        let bins = chunks.par_iter().map(|chunk| {
            let mut bins = empty();
            bins.add(chunk);
            bins
        });
        let bins = bins.reduce(empty, |a, b| a.plus(&b));
        let best = bins.best(Measure::new(&self.heuristic, cell.extent, count));
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(chunks.iter().flatten().map(|reference| reference.id));
            return;
        };
        let parted = chunks.into_par_iter().map(|chunk| {
            let mut sides = [Vec::with_capacity(chunk.len()), Vec::with_capacity(chunk.len())];
            for reference in chunk {
                match reference.sides(best.plane, best.planar_left) {
                    Sides::Left => sides[0].push(reference),
                    Sides::Right => sides[1].push(reference),
                    Sides::Both => {
                        let corners = || self.triangles.corners(reference.id);
                        let parts = reference.cut(best.plane, self.clipping, corners);
                        sides.iter_mut().zip(parts).for_each(|(side, part)| side.extend(part));
                    }
                }
            }
            let [left, right] = sides;
            (left, right)
        });
        let (left, right): (Vec<_>, Vec<_>) = parted.unzip();
        let counts = [&left, &right].map(|chunks| chunks.iter().map(Vec::len).sum());
        let [left_cell, right_cell] = Cell::share(cells, counts);
        let place = out.open(best.plane);
        let mut right_branch = self.pool.branch();
        rayon::join(
            || self.cluster_chunks(left, left_cell, out),
            || self.cluster_chunks(right, right_cell, &mut right_branch),
        );
        out.turn_right(place);
        out.append(&right_branch);
        self.pool.keep_branch(right_branch);
    }
}
