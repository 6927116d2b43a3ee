//! Building: one recursion for all builders, one file for each way to find planes.

mod adaptive;
mod binned;
mod deferred;
mod grow;
mod in_place;
mod median;
mod naive;
mod nested;
mod presorted;
mod resorting;
mod sah;
mod space;
mod streaming;

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::parallel::both;

use super::extent::{Extent, Plane, Reference, Sides};
use super::layout::Branch;
use super::{Clipping, KdBuilder, KdTree, KdTreeOptions, Whole};
use binned::Arena;
pub(super) use deferred::Deferred;
pub(crate) use sah::{Cell, SplitCandidate};
use sah::{Heuristic, Measure};
use space::{Frame, Space};
use umbrage_rays::Triangles;

/// Data that all parts of a build share.
pub(crate) struct Job<'a> {
    /// The triangles of the tree.
    pub triangles: Triangles<'a>,
    /// The kind of boxes around the parts of cut triangles.
    pub clipping: Clipping,
    heuristic: Heuristic,
    /// Nodes of fewer references are built when a ray reaches them.
    lazy_below: usize,
    pool: &'a Pool,
}

/// Memory that builds reuse.
#[derive(Default)]
pub(super) struct Pool {
    spaces: Shelf<Space>,
    branches: Shelf<Branch>,
    /// Parts of a large node's boxes.
    chunks: Shelf<Arena>,
    arenas: Shelf<Arena>,
}

impl Pool {
    pub(super) fn bytes(&self) -> usize {
        self.spaces.bytes() + self.branches.bytes() + self.chunks.bytes() + self.arenas.bytes()
    }
}

/// A value that keeps its memory when it is emptied.
pub(super) trait Reused: Default {
    fn clear(&mut self);

    fn bytes(&self) -> usize;
}

/// Free values of one kind.
#[derive(Default)]
struct Shelf<T>(Mutex<Vec<T>>);

impl<T: Reused> Shelf<T> {
    fn lock(&self) -> MutexGuard<'_, Vec<T>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self) -> T {
        let mut item = self.lock().pop().unwrap_or_default();
        item.clear();
        item
    }

    fn keep(&self, item: T) {
        self.lock().push(item);
    }

    fn bytes(&self) -> usize {
        self.lock().iter().map(T::bytes).sum()
    }
}

impl KdTree {
    /// Replaces the tree by one over `triangles`, on all threads of the current pool. It is the same for every number of
    /// threads.
    ///
    /// # Panics
    /// If there are more than 2³⁰ / [`KdTree::MOST_REFERENCES`] triangles.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        let builder = self.options.builder;
        self.build_by(triangles, |job, count, branch| {
            let is_any_omitted = count < triangles.len();
            if builder == KdBuilder::Binned {
                return job.bin(is_any_omitted, branch);
            }
            let mut space = job.pool.spaces.take();
            collect(triangles, is_any_omitted, &mut space.references);
            let extent = job.root(&mut space, builder, branch);
            job.pool.spaces.keep(space);
            extent
        });
    }

    /// Replaces the tree by the branch that `build` fills. `build` gets the number of triangles that can be hit, and returns
    /// their bounds.
    pub(crate) fn build_by(
        &mut self,
        triangles: Triangles<'_>,
        build: impl FnOnce(&Job<'_>, usize, &mut Branch) -> Extent,
    ) {
        let count = self.start(triangles);
        let heuristic = Heuristic::new(self.options.costs, count);
        let KdTreeOptions { clipping, lazy_below, .. } = self.options;
        let job = Job { triangles, clipping, heuristic, lazy_below: lazy_below as usize, pool: &self.pool };
        self.extent = build(&job, count, &mut self.branch);
        self.is_stretched = Whole::new(&self.extent, triangles).is_stretched;
        self.lay_out();
    }

    /// Asserts that a tree can hold the triangles.
    fn assert_few(triangles: Triangles<'_>) {
        let limit = triangles.len() as u64 * Self::MOST_REFERENCES + Self::LEAST_LIMIT;
        assert!(2 * limit < super::node::Node::MOST, "{} triangles are too many for a kd-tree", triangles.len());
    }

    /// Forgets the tree, checks the triangles of the next one, and returns the number of them that can be hit.
    fn start(&mut self, triangles: Triangles<'_>) -> usize {
        Self::assert_few(triangles);
        self.triangle_count = triangles.len();
        self.omitted = triangles.omitted();
        let count = triangles.len() - self.omitted.total() as usize;
        self.branch.clear();
        self.deferred.clear(self.options, count);
        count
    }

    /// Replaces the tree by one over boxes: its leaves list the boxes' ids instead of triangles'.
    pub(crate) fn build_over_boxes(&mut self, boxes: &[Reference]) {
        let heuristic = Heuristic::new(self.options.costs, boxes.len());
        let triangles = Triangles::default();
        let job = Job { triangles, clipping: Clipping::Boxes, heuristic, lazy_below: 0, pool: &self.pool };
        self.branch.clear();
        self.deferred.clear(self.options, boxes.len());
        let mut space = self.pool.spaces.take();
        space.references.extend_from_slice(boxes);
        self.extent = job.root(&mut space, KdBuilder::Presorted, &mut self.branch);
        self.pool.spaces.keep(space);
        self.lay_out();
    }
}

impl Job<'_> {
    /// Adds the tree of all references of a space, and returns the extent of its root.
    fn root(&self, space: &mut Space, builder: KdBuilder, out: &mut Branch) -> Extent {
        let extent = space.references.par_iter().map(|r| r.extent).merge(Extent::union).unwrap_or(Extent::EMPTY);
        let count = space.references.len();
        if count == 0 {
            out.push_leaf(std::iter::empty());
            return extent;
        }
        let root = Heuristic::root(extent, count);
        match Whole::new(&extent, self.triangles).builder(builder) {
            KdBuilder::Streaming => self.stream(space, root, out),
            KdBuilder::Nested => self.nest(std::mem::take(space), root, out),
            KdBuilder::InPlace => self.build_in_place(space, root, out),
            builder => self.grow(space, Frame::default(), builder, false, root, out),
        }
        extent
    }
}

/// Steps that builders share.
impl Job<'_> {
    /// Adds an inner node, and builds its children in parallel.
    fn join(
        &self,
        plane: Plane,
        out: &mut Branch,
        left: impl FnOnce(&mut Branch) + Send,
        right: impl FnOnce(&mut Branch) + Send,
    ) {
        let index = out.open(plane);
        let mut right_branch = self.pool.branches.take();
        both(|| left(out), || right(&mut right_branch));
        out.turn_right(index);
        out.append(&right_branch);
        self.pool.branches.keep(right_branch);
    }

    /// Returns the sides of a plane on which a reference is, and its parts there.
    fn part(&self, reference: &Reference, best: &SplitCandidate) -> (Sides, [Option<Reference>; 2]) {
        let sides = reference.sides(best.plane, best.planar_left);
        let parts = match sides {
            Sides::Left => [Some(*reference), None],
            Sides::Right => [None, Some(*reference)],
            Sides::Both => reference.cut(best.plane, self.clipping, || self.triangles.corners(reference.id)),
        };
        (sides, parts)
    }
}

/// Steps of builders that start from something else than all triangles.
impl Job<'_> {
    /// Returns the cell of a root with `count` triangles.
    #[must_use]
    pub(crate) fn root_cell(&self, extent: Extent, count: usize) -> Cell {
        Heuristic::root(extent, count)
    }

    /// Returns the best plane across a cell for boxes, each with the number of triangles that it counts as.
    #[must_use]
    pub(crate) fn best_of_boxes(&self, cell: &Cell, boxes: &[(Extent, u32)]) -> Option<SplitCandidate> {
        let count = boxes.iter().map(|&(_, weight)| weight as usize).sum();
        let measure = Measure::new(&self.heuristic, cell.extent, count);
        resorting::best(measure, boxes, |&of_box| of_box, &mut Vec::new())
    }

    /// Returns the two cells of the best plane, unless a leaf of `count` triangles is better. Once triangles are parted,
    /// [`Cell::share`] sets the largest number of references of each.
    #[must_use]
    pub(crate) fn split(&self, cell: &Cell, count: usize, best: SplitCandidate) -> Option<[Cell; 2]> {
        self.heuristic.split(cell, count, Some(best)).map(|(_, cells)| cells)
    }

    /// Adds the subtree of references in order of id.
    pub(crate) fn grow_references(
        &self,
        references: &[Reference],
        whole: Whole,
        builder: KdBuilder,
        cell: Cell,
        out: &mut Branch,
    ) {
        if builder == KdBuilder::Binned {
            return self.bin_references(references, whole, cell, out);
        }
        let mut space = self.pool.spaces.take();
        space.references.extend_from_slice(references);
        self.grow(&mut space, Frame::default(), whole.builder(builder), false, cell, out);
        self.pool.spaces.keep(space);
    }
}

/// Lists references to all triangles that can be hit, in order of id.
fn collect(triangles: Triangles<'_>, is_any_omitted: bool, references: &mut Vec<Reference>) {
    let reference = |id: u32| Reference { extent: Extent::around(triangles.corners(id)), id };
    let ids = 0..triangles.len() as u32;
    if is_any_omitted {
        references.clear();
        references.extend(ids.filter(|&id| triangles.usable_corners(id).is_ok()).map(reference));
    } else {
        ids.into_par_iter().with_min_len(1 << 12).map(reference).collect_into_vec(references);
    }
}
