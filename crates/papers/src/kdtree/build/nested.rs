//! The exact builder with threads that share large nodes: the nested algorithm of Choi et al., *Parallel SAH k-D Tree
//! Construction*, 2010, §4.1 (thesis, §4.2.2).
//!
//! Events and references of a node are split into chunks. The planes of a chunk are judged once the numbers of triangles
//! that begin and end in the chunks before are known. The references of a chunk are parted alone, and get their indices once
//! the counts of the chunks before are known. Choi et al. leave the second to one thread; with clipping that is too much
//! work. All counts are integers, so the tree is the one that a single thread builds.

use std::ops::Range;

use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::Job;
use super::presorted::{self, CUT, RIGHT};
use super::sah::{Cell, Measure, SplitCandidate};
use super::space::{Frame, Space};
use crate::kdtree::KdBuilder;
use crate::kdtree::extent::Reference;
use crate::kdtree::layout::Branch;

/// Nodes of fewer references are built by one thread, next to others.
const SHARED_FROM: usize = 1 << 14;

/// The number of events, or of references, that a thread takes at once.
const CHUNK: usize = 1 << 13;

/// A chunk of references after a plane has parted them, with indices counted in the chunk.
struct Parted {
    children: [Vec<Reference>; 2],
    indices: Vec<u32>,
    /// Events of references that were cut, by child and axis.
    fresh: [[Vec<u64>; 3]; 2],
}

impl Job<'_> {
    /// Adds the tree of all references of a space.
    pub(super) fn nest(&self, mut space: Space, cell: Cell, out: &mut Branch) {
        space.list_events(Frame::default());
        self.nest_listed(space, cell, out);
    }

    fn nest_listed(&self, mut space: Space, cell: Cell, out: &mut Branch) {
        let count = space.references.len();
        if count < SHARED_FROM {
            self.grow(&mut space, Frame::default(), KdBuilder::Presorted, true, cell, out);
            return self.pool.spaces.keep(space);
        }
        let best = if cell.depth < self.heuristic.max_depth { self.best_of_chunks(&space, &cell) } else { None };
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(space.references.iter().map(|reference| reference.id));
            return self.pool.spaces.keep(space);
        };
        let [left, right] = self.part_chunks(space, &best);
        let cells = Cell::share(cells, [&left, &right].map(|space| space.references.len()));
        let [left_cell, right_cell] = cells;
        self.join(
            best.plane,
            out,
            |out| self.nest_listed(left, left_cell, out),
            |out| self.nest_listed(right, right_cell, out),
        );
    }

    fn best_of_chunks(&self, space: &Space, cell: &Cell) -> Option<SplitCandidate> {
        let count = space.references.len();
        let best_across = |axis: usize| {
            let events = &space.events[axis];
            let chunks: Vec<_> = presorted::chunks(events, CHUNK).collect();
            let counts: Vec<_> = chunks.par_iter().map(|chunk| presorted::count(&events[chunk.clone()])).collect();
            let mut before = [0, count];
            let starts = counts.into_iter().map(|[begun, ended]| {
                let [left, right] = before;
                before = [left + begun, right - ended];
                [left as f64, right as f64]
            });
            let parts: Vec<(Range<usize>, [f64; 2])> = chunks.into_iter().zip(starts).collect();
            let best = parts.into_par_iter().map(|(chunk, before)| {
                let measure = Measure::new(&self.heuristic, cell.extent, count);
                presorted::sweep(measure, axis, &events[chunk], before, |_| 1).best
            });
            best.merge(SplitCandidate::better).flatten()
        };
        (0..3).into_par_iter().map(best_across).merge(SplitCandidate::better).flatten()
    }

    /// The left and the right child of a node.
    fn part_chunks(&self, space: Space, best: &SplitCandidate) -> [Space; 2] {
        let parted: Vec<_> = space.references.par_chunks(CHUNK).map(|chunk| self.part_chunk(chunk, best)).collect();
        let mut children = [self.pool.spaces.take(), self.pool.spaces.take()];
        let mut indices = Vec::with_capacity(space.references.len());
        let mut fresh: [[Vec<u64>; 3]; 2] = Default::default();
        for chunk in &parted {
            let starts = children.each_ref().map(|child| child.references.len() as u32);
            indices.extend(chunk.indices.iter().map(|&index| match index {
                CUT.. => index,
                RIGHT.. => index + starts[1],
                _ => index + starts[0],
            }));
            for side in 0..2 {
                children[side].references.extend_from_slice(&chunk.children[side]);
                for (fresh, of_chunk) in fresh[side].iter_mut().zip(&chunk.fresh[side]) {
                    fresh.extend(of_chunk.iter().map(|event| event + u64::from(starts[side])));
                }
            }
        }
        let parts: Vec<_> = (0..3)
            .into_par_iter()
            .map(|axis| {
                let chunks = space.events[axis].par_chunks(CHUNK);
                chunks.map(|chunk| presorted::part_kept(chunk, &indices)).collect::<Vec<_>>()
            })
            .collect();
        for (side, (child, fresh)) in children.iter_mut().zip(&mut fresh).enumerate() {
            child.events.par_iter_mut().zip(fresh).zip(&parts).each(|((events, fresh), parts)| {
                fresh.par_sort_unstable();
                presorted::merge(parts.iter().map(|part| &part[side][..]), fresh, events);
            });
        }
        self.pool.spaces.keep(space);
        children
    }

    fn part_chunk(&self, references: &[Reference], best: &SplitCandidate) -> Parted {
        let mut children = [Vec::with_capacity(references.len()), Vec::with_capacity(references.len())];
        let mut fresh: [[Vec<u64>; 3]; 2] = Default::default();
        let indices = references.iter().map(|reference| {
            let (sides, parts) = self.part(reference, best);
            let next = children.each_ref().map(|child| child.len() as u32);
            children.iter_mut().zip(&parts).for_each(|(child, part)| child.extend(part));
            presorted::place(sides, &parts, next, &mut fresh)
        });
        let indices = indices.collect();
        Parted { children, indices, fresh }
    }
}
