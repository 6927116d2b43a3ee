//! The exact builder with threads that share whole levels near the root: the in-place algorithm of Choi et al. 2010, §4.2
//! (thesis, Algorithm 4.2.2).
//!
//! References stay where they are and say which node they belong to. Events stay in the order of the whole scene, so
//! that one pass over them finds the planes of all nodes of a level. Once there are enough nodes, each gets its
//! references and events, and threads build the nodes in parallel. Choi et al. keep a list of nodes for each triangle
//! and don't clip it. Here the part on the left of a plane replaces the reference that is cut, the part on the right
//! comes last, and the events of both are merged in.

use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::Job;
use super::presorted;
use super::sah::{Cell, Measure, SplitCandidate};
use super::space::{Frame, Space};
use crate::kdtree::KdBuilder;
use crate::kdtree::extent::{Reference, Sides};
use crate::kdtree::layout::Branch;

/// Levels are shared while they have fewer nodes, …
const NODES: usize = 16;
/// … and more references than this.
const REFERENCES: usize = 1 << 14;

/// The number of events, or of references, that a thread takes at once.
const CHUNK: usize = 1 << 13;

/// The node of a reference that is in no cell any more.
const NOWHERE: u32 = u32::MAX;

/// The upper part of a tree.
struct Upper<'a> {
    job: &'a Job<'a>,
    references: Vec<Reference>,
    /// The node of each reference.
    node: Vec<u32>,
    events: [Vec<u64>; 3],
    nodes: Vec<Node>,
    /// The nodes of the last level, which may be cut: the last ones of `nodes`.
    live: std::ops::Range<usize>,
}

struct Node {
    cell: Cell,
    count: usize,
    /// The plane, and the index of the first child; the second follows it.
    cut: Option<(SplitCandidate, usize)>,
}

impl Job<'_> {
    /// Adds the tree of all references of a space.
    pub(super) fn build_in_place(&self, space: &mut Space, cell: Cell, out: &mut Branch) {
        space.list_events(Frame::default());
        let references = std::mem::take(&mut space.references);
        let events = std::mem::take(&mut space.events);
        let nodes = vec![Node { cell, count: references.len(), cut: None }];
        let mut upper = Upper { job: self, node: vec![0; references.len()], references, events, nodes, live: 0..1 };
        while !upper.live.is_empty() && upper.live.len() < NODES && upper.references.len() >= REFERENCES {
            upper.next_level();
        }
        let mut branches = upper.fill();
        emit(&upper.nodes, 0, &mut branches, out);
        branches.into_iter().flatten().for_each(|branch| self.pool.branches.keep(branch));
    }
}

impl Upper<'_> {
    /// Cuts the nodes of the last level.
    fn next_level(&mut self) {
        let best = self.planes();
        let first = self.nodes.len();
        for (node, best) in self.live.clone().zip(best) {
            let Node { cell, count, .. } = self.nodes[node];
            if let Some((best, cells)) = self.job.heuristic.split(&cell, count, best) {
                self.nodes[node].cut = Some((best, self.nodes.len()));
                self.nodes.extend(cells.map(|cell| Node { cell, count: 0, cut: None }));
            }
        }
        self.classify();
        // The budget of each child depends on the counts of both.
        for node in self.live.clone() {
            if let Some((_, left)) = self.nodes[node].cut {
                let children = [left, left + 1];
                let cells = Cell::share(
                    children.map(|child| self.nodes[child].cell),
                    children.map(|child| self.nodes[child].count),
                );
                children.into_iter().zip(cells).for_each(|(child, cell)| self.nodes[child].cell = cell);
            }
        }
        self.live = first..self.nodes.len();
    }

    /// Returns the best planes of all nodes of the last level.
    fn planes(&self) -> Vec<Option<SplitCandidate>> {
        let across = (0..3).into_par_iter().map(|axis| self.planes_across(axis));
        across.reduce(|| vec![None; self.live.len()], better)
    }

    fn planes_across(&self, axis: usize) -> Vec<Option<SplitCandidate>> {
        let events = &self.events[axis];
        let first = self.live.start;
        let live_node =
            |index: usize| (self.node[index] as usize).checked_sub(first).filter(|&node| node < self.live.len());
        let chunks: Vec<_> = presorted::chunks(events, CHUNK).collect();
        let counts = chunks.par_iter().map(|chunk| {
            let mut counts = vec![[0; 2]; self.live.len()];
            for &event in &events[chunk.clone()] {
                if let Some(node) = live_node(presorted::index(event)) {
                    let [begun, ended] = presorted::count(&[event]);
                    counts[node] = [counts[node][0] + begun, counts[node][1] + ended];
                }
            }
            counts
        });
        let counts: Vec<_> = counts.collect();
        let mut before: Vec<_> = self.nodes[self.live.clone()].iter().map(|node| [0, node.count]).collect();
        let starts = counts.into_iter().map(|counts| {
            let start = before.clone();
            for (before, [begun, ended]) in before.iter_mut().zip(counts) {
                *before = [before[0] + begun, before[1] - ended];
            }
            start
        });
        let parts: Vec<_> = chunks.into_iter().zip(starts).collect();
        let best = parts.into_par_iter().map(|(chunk, starts)| {
            let nodes = self.nodes[self.live.clone()].iter().zip(starts);
            let mut sweeps: Vec<_> = nodes
                .map(|(node, before)| {
                    let measure = Measure::new(&self.job.heuristic, node.cell.extent, node.count);
                    presorted::Sweep::new(measure, axis, before.map(|count| count as f64))
                })
                .collect();
            for &event in &events[chunk] {
                if let Some(node) = live_node(presorted::index(event)) {
                    sweeps[node].pass(event, 1);
                }
            }
            let best = sweeps.into_iter().zip(&self.nodes[self.live.clone()]).map(|(sweep, node)| {
                let is_cut = node.count > 0 && node.cell.depth < self.job.heuristic.max_depth;
                sweep.end().best.filter(|_| is_cut)
            });
            best.collect()
        });
        best.reduce(|| vec![None; self.live.len()], better)
    }

    /// Gives references of nodes that were cut to their children.
    fn classify(&mut self) {
        let Self { job, references, node, nodes, .. } = self;
        let chunks = references.par_chunks(CHUNK).zip(node.par_chunks_mut(CHUNK)).enumerate();
        // The references that were cut, and their parts.
        let cut: Vec<_> = chunks
            .map(|(chunk, (references, node))| {
                let mut cut = Vec::new();
                for (index, (reference, node)) in references.iter().zip(node).enumerate() {
                    let Some((best, left)) = nodes.get(*node as usize).and_then(|node| node.cut) else { continue };
                    match reference.sides(best.plane, best.planar_left) {
                        Sides::Left => *node = left as u32,
                        Sides::Right => *node = left as u32 + 1,
                        Sides::Both => {
                            let corners = || job.triangles.corners(reference.id);
                            *node = left as u32;
                            cut.push((chunk * CHUNK + index, reference.cut(best.plane, job.clipping, corners)));
                        }
                    }
                }
                cut
            })
            .collect();
        let mut is_cut = vec![false; references.len()];
        let mut fresh: [Vec<u64>; 3] = Default::default();
        for (index, [below, above]) in cut.into_iter().flatten() {
            is_cut[index] = true;
            let left = node[index];
            if let Some(above) = above {
                presorted::push_events(&mut fresh, &above.extent, references.len() as u32);
                references.push(above);
                node.push(left + 1);
            }
            if let Some(below) = below {
                presorted::push_events(&mut fresh, &below.extent, index as u32);
                references[index] = below;
            } else {
                node[index] = NOWHERE;
            }
        }
        for &node in node.iter().filter(|&&node| node != NOWHERE && node as usize >= self.live.end) {
            nodes[node as usize].count += 1;
        }
        self.events.par_iter_mut().zip(&mut fresh).each(|(events, fresh)| {
            fresh.par_sort_unstable();
            events.retain(|&event| !is_cut[presorted::index(event)]);
            let old = std::mem::take(events);
            presorted::merge([&old[..]].into_iter(), fresh, events);
        });
    }

    /// Returns the subtrees of nodes that weren't cut, by node.
    fn fill(&mut self) -> Vec<Option<Branch>> {
        let Self { job, references, node, events, nodes, .. } = self;
        let mut spaces: Vec<_> = nodes.iter().map(|node| node.cut.is_none().then(|| job.pool.spaces.take())).collect();
        // The references of each space are in the order of ids.
        let mut order: Vec<_> = (0..references.len() as u32).filter(|&index| node[index as usize] != NOWHERE).collect();
        order.par_sort_unstable_by_key(|&index| references[index as usize].id);
        let mut indices = vec![0; references.len()];
        for index in order.into_iter().map(|index| index as usize) {
            let space = spaces[node[index] as usize].as_mut().expect("a node that wasn't cut");
            indices[index] = space.references.len() as u32;
            space.references.push(references[index]);
        }
        for (axis, events) in events.iter().enumerate() {
            for &event in events {
                let index = presorted::index(event);
                if let Some(Some(space)) = spaces.get_mut(node[index] as usize) {
                    space.events[axis].push(presorted::with_index(event, indices[index]));
                }
            }
        }
        let branches = spaces.into_par_iter().zip(nodes.par_iter()).with_max_len(1).map(|(space, node)| {
            let mut space = space?;
            let mut branch = job.pool.branches.take();
            job.grow(&mut space, Frame::default(), KdBuilder::Presorted, true, node.cell, &mut branch);
            job.pool.spaces.keep(space);
            Some(branch)
        });
        branches.collect()
    }
}

fn better(mut a: Vec<Option<SplitCandidate>>, b: Vec<Option<SplitCandidate>>) -> Vec<Option<SplitCandidate>> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a = SplitCandidate::better(*a, b));
    a
}

/// Adds the subtree of a node, whose parts are built.
fn emit(nodes: &[Node], node: usize, branches: &mut [Option<Branch>], out: &mut Branch) {
    if let Some((best, left)) = nodes[node].cut {
        let index = out.open(best.plane);
        emit(nodes, left, branches, out);
        out.turn_right(index);
        emit(nodes, left + 1, branches, out);
    } else if let Some(branch) = &branches[node] {
        out.append(branch);
    }
}
