//! Finds planes among a few by counting the boxes that begin and end between them: min–max binning (Shevtsov et al. 2007).
//! Planes and boxes are compared in vectors instead of counted in bins, where each box would wait for the one before it.

mod boxes;
mod clip;
mod cluster;
mod crowd;
mod planes;

use std::ops::Range;

use fearless_simd::Simd;
use rayon::prelude::*;
use umbrage_rays::dispatch;

use super::sah::{Cell, Heuristic, SplitCandidate};
use super::{Job, Reused};
use crate::kdtree::extent::{Extent, Reference};
use crate::kdtree::layout::Branch;
use crate::kdtree::{Clipping, SahCosts, Whole};
use boxes::{Around, Boxed, clip_cut, part};
use planes::{Best, Counted, Node};
use umbrage_rays::SimdLevel;
use umbrage_rays::vectorized;

/// The number of triangles that a thread takes at once at the root.
const CHUNK: usize = 1 << 13;

/// Factor of a step's cost in this builder: a higher one makes larger leaves, and so faster builds. 9 instead of 5 makes
/// three fifths of the Bunny's nodes and three quarters of `sibenik.obj`'s, whose rays take up to 5 % longer.
const STEP: f64 = 9.0;

/// Boxes of nodes with fewer of them are cut, but not clipped. In the Bunny and `sibenik.obj` this changes the tree's cost
/// by less than a thousandth.
const CLIPPED_FROM: usize = 9;

impl Job<'_> {
    /// Adds the tree of all triangles that can be hit, and returns the extent of its root.
    pub(super) fn bin(&self, is_any_omitted: bool, out: &mut Branch) -> Extent {
        dispatch!(SimdLevel::default(), simd => self.bin_with(simd, is_any_omitted, out))
    }

    fn bin_with<S: Simd>(&self, simd: S, is_any_omitted: bool, out: &mut Branch) -> Extent {
        let all = self.triangles.len();
        let chunk = |chunk: usize| {
            let ids = (chunk * CHUNK) as u32..all.min((chunk + 1) * CHUNK) as u32;
            let usable = ids.filter(|&id| !is_any_omitted || self.triangles.usable_corners(id).is_ok());
            let mut chunk = self.pool.chunks.take();
            chunk.boxes.extend(usable.map(|id| Boxed::around(self.triangles.corners(id), id)));
            chunk
        };
        let mut chunks = Vec::new();
        (0..all.div_ceil(CHUNK)).into_par_iter().map(chunk).collect_into_vec(&mut chunks);
        let count = chunks.iter().map(|chunk| chunk.boxes.len()).sum();
        if count == 0 {
            out.push_leaf(std::iter::empty());
            return Extent::EMPTY;
        }
        let around = Around::chunks(simd, &chunks);
        let extent = around.extent();
        let binning = self.binning(simd, Whole::new(&extent, self.triangles));
        binning.cluster(chunks, Heuristic::root(extent, count), out);
        extent
    }
}

impl Job<'_> {
    /// Adds the subtree of a few references.
    pub(super) fn bin_references(&self, references: &[Reference], whole: Whole, cell: Cell, out: &mut Branch) {
        let mut arena = self.pool.arenas.take();
        arena.boxes.extend(references.iter().map(Boxed::from));
        dispatch!(SimdLevel::default(), simd => {
            self.binning(simd, whole).grow(&mut arena, 0..references.len(), cell, out);
        });
        self.pool.arenas.keep(arena);
    }

    fn binning<S: Simd>(&self, simd: S, whole: Whole) -> Binning<'_, S> {
        let costs = self.heuristic.costs;
        Binning {
            job: self,
            simd,
            costs: SahCosts { step: costs.step * STEP, ..costs },
            is_clipped: self.clipping == Clipping::Triangles && whole.reach <= clip::LARGEST,
            is_stretched: whole.is_stretched,
        }
    }
}

/// Data that all parts of a binned build share.
struct Binning<'a, S> {
    job: &'a Job<'a>,
    simd: S,
    costs: SahCosts,
    /// Whether boxes are shrunk around the parts of triangles that planes cut.
    is_clipped: bool,
    /// Whether planes may have to be [among most boxes](crowd).
    is_stretched: bool,
}

impl<S: Simd> Binning<'_, S> {
    /// Adds the subtree of the boxes in a range, and may overwrite that range and all after it.
    fn grow(&self, arena: &mut Arena, range: Range<usize>, cell: Cell, out: &mut Branch) {
        let Self { job, simd, costs, .. } = self;
        let count = range.len();
        if job.is_deferred(count, &cell) {
            out.push_deferred(arena.boxes[range].iter().map(Boxed::reference), cell);
            return;
        }
        // Any plane costs a step, so a node of few boxes is always a leaf.
        if count as f64 * costs.test <= costs.step * costs.empty || cell.depth >= job.heuristic.max_depth {
            out.push_leaf(arena.boxes[range].iter().map(Boxed::id));
            return;
        }
        let boxes = &arena.boxes[range.clone()];
        let counted = vectorized!(*simd => planes::count_all(*simd, boxes));
        self.split(arena, range, &counted, cell, out);
    }

    /// As [`grow`](Self::grow), for boxes that are counted.
    fn split(&self, arena: &mut Arena, range: Range<usize>, counted: &Counted<S>, cell: Cell, out: &mut Branch) {
        let Self { job, simd, costs, .. } = self;
        let count = range.len();
        let node = Node::new(costs, &cell.extent, count);
        let mut best = vectorized!(*simd => planes::least(*simd, &node, counted));
        let (mut counted, among) = (counted, self.count_among_most(&arena.boxes[range.clone()], counted));
        if let Some(among) = &among {
            let other = planes::least(*simd, &node, among);
            let cost = |best: &Option<Best>| best.as_ref().map_or(f64::INFINITY, |best| best.candidate.cost);
            if cost(&other) < cost(&best) {
                (best, counted) = (other, among);
            }
        }
        let is_empty = best.as_ref().map_or([false; 2], |best| best.is_empty);
        let Some((best, cells)) = job.heuristic.split(&cell, count, best.map(|best| best.candidate)) else {
            out.push_leaf(arena.boxes[range].iter().map(Boxed::id));
            return;
        };
        // If one side is empty, as at half of the Bunny's planes, the other has the same boxes and the same counts.
        if is_empty[0] {
            let [_, cell] = Cell::share(cells, [0, count]);
            let index = out.open(best.plane);
            out.push_leaf(std::iter::empty());
            out.turn_right(index);
            return self.split(arena, range, counted, cell, out);
        }
        if is_empty[1] {
            let [cell, _] = Cell::share(cells, [count, 0]);
            let index = out.open(best.plane);
            self.split(arena, range, counted, cell, out);
            out.turn_right(index);
            out.push_leaf(std::iter::empty());
            return;
        }
        let Arena { boxes, cut } = arena;
        if boxes.len() < range.end + count {
            boxes.resize((range.end + count).max(boxes.len() * 3 / 2), Boxed::default());
        }
        let (kept, free) = boxes.split_at_mut(range.end);
        let counts = self.part(&mut kept[range.start..], &best, free, cut);
        let [left_cell, right_cell] = Cell::share(cells, counts);
        let index = out.open(best.plane);
        self.grow(arena, range.end..range.end + counts[0], left_cell, out);
        out.turn_right(index);
        self.grow(arena, range.start..range.start + counts[1], right_cell, out);
    }

    /// Counts boxes at planes among most of them, if a few others stretch the node.
    fn count_among_most(&self, boxes: &[Boxed], counted: &Counted<S>) -> Option<Counted<S>> {
        if !self.is_stretched || boxes.len() <= planes::EXACT_FROM {
            return None;
        }
        let around = Around::all(self.simd, boxes);
        let most = crowd::among_most(&around, &counted.counts(), &boxes.iter())?;
        Some(planes::count_within(self.simd, boxes, &most))
    }

    /// As [`part`], with boxes shrunk.
    fn part(
        &self,
        boxes: &mut [Boxed],
        best: &SplitCandidate,
        left: &mut [Boxed],
        cut: &mut Vec<[u32; 2]>,
    ) -> [usize; 2] {
        let Self { job, simd, is_clipped, .. } = self;
        if cut.len() < boxes.len() {
            cut.resize(boxes.len(), [0; 2]);
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let (counts, cut_count) = part(*simd, boxes, best, left, cut);
                if !is_clipped || boxes.len() < CLIPPED_FROM {
                    return counts;
                }
                let children = [&mut left[..counts[0]], &mut boxes[..counts[1]]];
                clip_cut(*simd, job.triangles, best.plane, children, &cut[..cut_count])
            },
        )
    }
}

/// Working memory of one thread: the boxes of the current node, after those of the right children that wait.
#[derive(Default)]
pub(super) struct Arena {
    boxes: Vec<Boxed>,
    /// Indices of the boxes that a plane cuts, in the left and in the right list.
    cut: Vec<[u32; 2]>,
}

impl Reused for Arena {
    fn clear(&mut self) {
        self.boxes.clear();
    }

    fn bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<Boxed>() + self.cut.capacity() * size_of::<[u32; 2]>()
    }
}
