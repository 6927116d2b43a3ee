use super::sah::{Cell, Measure, SplitCandidate};
use super::space::{Frame, Space};
use super::{Job, adaptive, median, naive, resorting};
use crate::kdtree::KdBuilder;
use crate::kdtree::layout::Branch;

/// Number of references from which a node's children are built on two threads.
const PARALLEL: usize = 1 << 12;

impl Job<'_> {
    /// Adds the subtree of the references from `at` on to `out`, and removes them. `is_listed` says whether their events are
    /// listed already; only builders that sort them once need those.
    pub(super) fn grow(
        &self,
        space: &mut Space,
        at: Frame,
        builder: KdBuilder,
        is_listed: bool,
        cell: Cell,
        out: &mut Branch,
    ) {
        let count = space.references.len() - at.references;
        if self.is_deferred(count, &cell) {
            out.push_deferred(space.references[at.references..].iter().copied(), cell);
            space.truncate(at);
            return;
        }
        // Small nodes are split exactly: there, counting exactly takes no longer.
        let is_small = builder == KdBuilder::Adaptive && count <= adaptive::EXACT_FROM;
        let builder = if is_small { KdBuilder::Presorted } else { builder };
        let counts_anew = matches!(builder, KdBuilder::Naive | KdBuilder::Resorting | KdBuilder::Adaptive);
        let has_events = !counts_anew && !builder.takes_medians();
        if has_events && !is_listed {
            space.list_events(at);
        }
        let best = self.best(space, at, builder, &cell);
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(space.references[at.references..].iter().map(|reference| reference.id));
            space.truncate(at);
            return;
        };
        let counts = space.part(self, at, &best, has_events);
        let cells = Cell::share(cells, counts);
        if count >= PARALLEL {
            let mut left = self.pool.spaces.take();
            space.give_left(&mut left);
            let grow_left = |out: &mut Branch| {
                self.grow(&mut left, Frame::default(), builder, has_events, cells[0], out);
                self.pool.spaces.keep(left);
            };
            self.join(best.plane, out, grow_left, |out| self.grow(space, at, builder, has_events, cells[1], out));
        } else {
            let index = out.open(best.plane);
            let left = space.push_left();
            self.grow(space, left, builder, has_events, cells[0], out);
            out.turn_right(index);
            self.grow(space, at, builder, has_events, cells[1], out);
        }
    }

    fn best(&self, space: &mut Space, at: Frame, builder: KdBuilder, cell: &Cell) -> Option<SplitCandidate> {
        let references = &space.references[at.references..];
        if references.is_empty() || cell.depth >= self.heuristic.max_depth {
            return None;
        }
        let measure = Measure::new(&self.heuristic, cell.extent, references.len());
        match builder {
            KdBuilder::Naive => naive::best(measure, references),
            KdBuilder::Resorting => resorting::best(measure, references, |one| (one.extent, 1), &mut space.events[0]),
            KdBuilder::Adaptive => adaptive::best(measure, references),
            builder if builder.takes_medians() => median::best(&measure, references, cell.depth, builder),
            _ => space.sweep(measure, at),
        }
    }
}
