use super::sah::{Candidate, Cell, Measure};
use super::space::{Frame, Space};
use super::{Job, adaptive, naive, resorting};
use crate::kdtree::KdBuilder;
use crate::kdtree::layout::Branch;

/// How planes of a subtree are found.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    Naive,
    Resorting,
    /// With events yet to be listed.
    Unsorted,
    /// With events that are listed.
    Presorted,
    Adaptive,
}

impl From<KdBuilder> for Method {
    fn from(builder: KdBuilder) -> Self {
        match builder {
            KdBuilder::Naive => Self::Naive,
            KdBuilder::Resorting => Self::Resorting,
            KdBuilder::Presorted
            | KdBuilder::Nested
            | KdBuilder::InPlace
            | KdBuilder::Streaming
            | KdBuilder::Binned => Self::Unsorted,
            KdBuilder::Adaptive => Self::Adaptive,
        }
    }
}

impl Method {
    /// How small nodes are split: there, counting exactly takes no longer.
    fn for_count(self, count: usize) -> Self {
        match self {
            Self::Adaptive if count <= adaptive::EXACT_FROM => Self::Unsorted,
            method => method,
        }
    }
}

/// Nodes of so many references have their children built on two threads.
const PARALLEL: usize = 1 << 12;

impl Job<'_> {
    /// Adds the subtree of the references from `at` on to `out`, and removes them.
    pub(super) fn grow(&self, space: &mut Space, at: Frame, method: Method, cell: Cell, out: &mut Branch) {
        let count = space.references.len() - at.references;
        if self.is_deferred(count, &cell) {
            out.push_deferred(space.references[at.references..].iter().copied(), cell);
            space.truncate(at);
            return;
        }
        let mut method = method.for_count(count);
        if method == Method::Unsorted {
            space.list_events(at);
            method = Method::Presorted;
        }
        let best = self.best(space, at, method, &cell);
        let Some((best, cells)) = self.heuristic.split(&cell, count, best) else {
            out.push_leaf(space.references[at.references..].iter().map(|reference| reference.id));
            space.truncate(at);
            return;
        };
        let counts = space.part(self, at, &best, method == Method::Presorted);
        let cells = Cell::share(cells, counts);
        if count >= PARALLEL {
            let mut left = self.pool.spaces.take();
            space.give_left(&mut left);
            let grow_left = |out: &mut Branch| {
                self.grow(&mut left, Frame::default(), method, cells[0], out);
                self.pool.spaces.keep(left);
            };
            self.join(best.plane, out, grow_left, |out| self.grow(space, at, method, cells[1], out));
        } else {
            let index = out.open(best.plane);
            let left = space.push_left();
            self.grow(space, left, method, cells[0], out);
            out.turn_right(index);
            self.grow(space, at, method, cells[1], out);
        }
    }

    fn best(&self, space: &mut Space, at: Frame, method: Method, cell: &Cell) -> Option<Candidate> {
        let references = &space.references[at.references..];
        if references.is_empty() || cell.depth >= self.heuristic.max_depth {
            return None;
        }
        let measure = Measure::new(&self.heuristic, cell.extent, references.len());
        match method {
            Method::Naive => naive::best(measure, references),
            Method::Resorting => resorting::best(measure, references, |one| (one.extent, 1), &mut space.events[0]),
            Method::Unsorted | Method::Presorted => space.sweep(measure, at),
            Method::Adaptive => adaptive::best(measure, references),
        }
    }
}
