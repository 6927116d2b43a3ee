//! Building: one recursion for all builders, one file for each way to find planes.

mod adaptive;
mod binned;
mod bins;
mod deferred;
mod grow;
mod in_place;
mod naive;
mod nested;
mod presorted;
mod resorting;
mod sah;
mod space;
mod streaming;

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::extent::{Extent, Reference};
use super::layout::Branch;
use super::{Clipping, KdBuilder, KdTree, KdTreeOptions};
use crate::Triangles;
use binned::Arena;
pub(super) use deferred::Deferred;
pub use sah::{Candidate, Cell};
use sah::{Heuristic, Measure};
use space::{Frame, Space};

/// What all parts of a build share.
pub struct Job<'a> {
    /// What the tree is built over.
    pub triangles: Triangles<'a>,
    /// How boxes are cut.
    pub clipping: Clipping,
    heuristic: Heuristic,
    /// Nodes of fewer references are built when a ray reaches them.
    lazy_below: usize,
    pool: &'a Pool,
}

/// Memory that builds use again.
#[derive(Default)]
pub(super) struct Pool {
    spaces: Mutex<Vec<Space>>,
    branches: Mutex<Vec<Branch>>,
    chunks: Mutex<Vec<Arena>>,
    arenas: Mutex<Vec<Arena>>,
}

impl Pool {
    fn space(&self) -> Space {
        let mut space = lock(&self.spaces).pop().unwrap_or_default();
        space.clear();
        space
    }

    fn branch(&self) -> Branch {
        let mut branch = lock(&self.branches).pop().unwrap_or_default();
        branch.clear();
        branch
    }

    /// A part of a large node's boxes.
    fn chunk(&self) -> Arena {
        let mut chunk = lock(&self.chunks).pop().unwrap_or_default();
        chunk.clear();
        chunk
    }

    fn keep_chunk(&self, chunk: Arena) {
        lock(&self.chunks).push(chunk);
    }

    fn arena(&self) -> Arena {
        let mut arena = lock(&self.arenas).pop().unwrap_or_default();
        arena.clear();
        arena
    }

    fn keep_arena(&self, arena: Arena) {
        lock(&self.arenas).push(arena);
    }

    fn keep_space(&self, space: Space) {
        lock(&self.spaces).push(space);
    }

    fn keep_branch(&self, branch: Branch) {
        lock(&self.branches).push(branch);
    }

    pub(super) fn bytes(&self) -> usize {
        lock(&self.spaces).iter().map(Space::bytes).sum::<usize>()
            + lock(&self.branches).iter().map(Branch::bytes).sum::<usize>()
            + lock(&self.chunks).iter().map(Arena::bytes).sum::<usize>()
            + lock(&self.arenas).iter().map(Arena::bytes).sum::<usize>()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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
            let mut space = job.pool.space();
            collect(triangles, is_any_omitted, &mut space.references);
            let extent = job.root(&mut space, builder, branch);
            job.pool.keep_space(space);
            extent
        });
    }

    /// Replaces the tree by what `build` adds to a branch. `build` is given how many triangles can be hit, and returns the box
    /// around them.
    #[doc(hidden)]
    pub fn build_by(&mut self, triangles: Triangles<'_>, build: impl FnOnce(&Job<'_>, usize, &mut Branch) -> Extent) {
        let count = self.start(triangles);
        let heuristic = Heuristic::new(self.options.costs, count);
        let KdTreeOptions { clipping, lazy_below, .. } = self.options;
        let job = Job { triangles, clipping, heuristic, lazy_below: lazy_below as usize, pool: &self.pool };
        self.extent = build(&job, count, &mut self.branch);
        self.lay_out();
    }

    /// Asserts that a tree can hold the triangles.
    fn assert_few(triangles: Triangles<'_>) {
        let limit = triangles.len() as u64 * Self::MOST_REFERENCES + Self::LEAST_LIMIT;
        assert!(2 * limit < super::node::Node::MOST, "{} triangles are too many for a kd-tree", triangles.len());
    }

    /// Forgets the tree, checks the triangles of the next one, and returns how many of them can be hit.
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
    #[doc(hidden)]
    pub fn build_over_boxes(&mut self, boxes: &[Reference]) {
        let heuristic = Heuristic::new(self.options.costs, boxes.len());
        let triangles = Triangles::default();
        let job = Job { triangles, clipping: Clipping::Boxes, heuristic, lazy_below: 0, pool: &self.pool };
        self.branch.clear();
        self.deferred.clear(self.options, boxes.len());
        let mut space = self.pool.space();
        space.references.extend_from_slice(boxes);
        self.extent = job.root(&mut space, KdBuilder::Presorted, &mut self.branch);
        self.pool.keep_space(space);
        self.lay_out();
    }
}

impl Job<'_> {
    /// Adds the tree of all references of a space, and returns the extent of its root.
    fn root(&self, space: &mut Space, builder: KdBuilder, out: &mut Branch) -> Extent {
        let extent = space.references.par_iter().map(|r| r.extent).reduce(|| Extent::EMPTY, Extent::union);
        let count = space.references.len();
        if count == 0 {
            out.push_leaf(std::iter::empty());
            return extent;
        }
        let root = Heuristic::root(extent, count);
        match builder {
            KdBuilder::Streaming => self.stream(space, root, out),
            KdBuilder::Nested => self.nest(std::mem::take(space), root, out),
            KdBuilder::InPlace => self.build_in_place(space, root, out),
            builder => self.grow(space, Frame::default(), builder.into(), root, out),
        }
        extent
    }
}

/// What builders that start from something else than all triangles need.
impl Job<'_> {
    /// The cell of a root with so many triangles.
    #[must_use]
    pub fn root_cell(&self, extent: Extent, count: usize) -> Cell {
        Heuristic::root(extent, count)
    }

    /// The best plane across a cell for boxes, each of which counts as so many triangles.
    #[must_use]
    pub fn best_of_boxes(&self, cell: &Cell, boxes: &[(Extent, u32)]) -> Option<Candidate> {
        let count = boxes.iter().map(|&(_, weight)| weight as usize).sum();
        let mut measure = Measure::new(&self.heuristic, cell.extent, count);
        let mut events = Vec::new();
        for axis in 0..3 {
            events.clear();
            for ((extent, _), index) in boxes.iter().zip(0..) {
                presorted::push_axis(&mut events, extent.min[axis], extent.max[axis], index);
            }
            events.sort_unstable();
            presorted::sweep(&mut measure, axis, &events, |index| boxes[index].1);
        }
        measure.best
    }

    /// The two cells of the best plane, unless a leaf of `count` triangles is better. Once triangles are parted,
    /// [`Cell::share`] says how many references each may have.
    #[must_use]
    pub fn split(&self, cell: &Cell, count: usize, best: Candidate) -> Option<[Cell; 2]> {
        self.heuristic.split(cell, count, Some(best)).map(|(_, cells)| cells)
    }

    /// Adds the subtree of references in order of id. `reach` is the largest magnitude of a coordinate of the whole tree.
    pub fn grow_references(
        &self,
        references: &[Reference],
        reach: f32,
        builder: KdBuilder,
        cell: Cell,
        out: &mut Branch,
    ) {
        if builder == KdBuilder::Binned {
            return self.bin_references(references, reach, cell, out);
        }
        let mut space = self.pool.space();
        space.references.extend_from_slice(references);
        self.grow(&mut space, Frame::default(), builder.into(), cell, out);
        self.pool.keep_space(space);
    }
}

/// References to all triangles that can be hit, in order of id.
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
