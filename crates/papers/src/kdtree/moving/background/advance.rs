use std::sync::mpsc::{TryRecvError, channel};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::parallel::both;

use crate::kdtree::Extent;
use crate::{KdTree, KdTreeOptions};
use umbrage_rays::{Structure as _, Triangles};

use super::{BackgroundKdTree, Built, KdAge};

impl BackgroundKdTree {
    /// Moves on to a frame, on all threads of the current pool, and begins a new tree if the policy demands it.
    ///
    /// A frame waits for its own tree if its indices aren't those that the tree was built with, or if it has a triangle that
    /// can be hit and couldn't be then.
    ///
    /// # Panics
    /// As [`KdTree::build`].
    pub fn advance(&mut self, triangles: Triangles<'_>) -> KdAge {
        self.omitted = triangles.omitted();
        self.frames += 1;
        self.take(false);
        let mut ratio = self.follow(triangles);
        let mut has_waited = false;
        if ratio.is_none_or(|ratio| ratio > self.policy.wait_above) && self.coming.is_some() {
            has_waited = true;
            self.take(true);
            ratio = self.follow(triangles);
        }
        let cost_ratio = match ratio {
            Some(ratio) if ratio <= self.policy.wait_above => ratio,
            _ => {
                has_waited = true;
                self.current.copy(triangles);
                self.current.build(self.options);
                self.frames = 0;
                // Nothing has moved.
                self.follow(triangles).unwrap_or(1.0)
            }
        };
        if cost_ratio > self.policy.rebuild_above {
            self.begin(triangles);
        }
        KdAge { frames: self.frames, cost_ratio, has_waited, is_building: self.coming.is_some() }
    }

    /// Takes the tree that was being built, if there is one that is ready or `waits`.
    fn take(&mut self, waits: bool) {
        let Some((receiver, age)) = &mut self.coming else { return };
        let receiver = receiver.get_mut().unwrap_or_else(PoisonError::into_inner);
        *age += 1;
        let age = *age;
        match if waits { receiver.recv().map_err(|_| TryRecvError::Disconnected) } else { receiver.try_recv() } {
            Ok(built) => {
                self.spare = Some(std::mem::replace(&mut self.current, built));
                // A frame that waits was counted before, in the call that didn't wait.
                self.frames = age - u32::from(waits);
                self.coming = None;
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => self.coming = None,
        }
    }

    /// Begins a tree for a frame, unless one is being built.
    fn begin(&mut self, triangles: Triangles<'_>) {
        if self.coming.is_some() {
            return;
        }
        let mut next = self.spare.take().unwrap_or_default();
        next.copy(triangles);
        let (sender, receiver) = channel();
        let options = self.options;
        self.threads.spawn(move || {
            next.build(options);
            // Sending fails only if the tree isn't needed any more.
            let _ = sender.send(next);
        });
        self.coming = Some((Mutex::new(receiver), 0));
    }

    /// Measures the drift of triangles. Returns the expected cost of rays relative to that when the tree was built; `None`
    /// if the tree isn't of these triangles.
    fn follow(&mut self, triangles: Triangles<'_>) -> Option<f64> {
        let Self { current, drift, triangle_drift, extent, .. } = self;
        let Built { tree, positions, indices, unusable, cost } = &*current;
        let is_same = tree.nodes().len() > 0
            && indices.par_chunks(1 << 14).eq(triangles.indices.par_chunks(1 << 14))
            && positions.len() == triangles.positions.len();
        if !is_same || unusable.iter().any(|&id| triangles.usable_corners(id).is_ok()) {
            return None;
        }
        let of_triangle = |id: u32| {
            // A triangle that isn't usable now can't be hit.
            let Ok(corners) = triangles.usable_corners(id) else { return (0.0, Extent::EMPTY) };
            let moved = corners.into_iter().zip(indices[id as usize]).map(|(now, vertex)| {
                let by = (now.as_dvec3() - positions[vertex as usize].as_dvec3()).abs().max_element();
                // One step above the nearest f32, which covers the rounding of sums with planes as well.
                if by > 0.0 { (by as f32).next_up() } else { 0.0 }
            });
            (moved.fold(0.0, f32::max), Extent::around(corners))
        };
        triangle_drift.resize(triangles.len(), 0.0);
        let all = triangle_drift.par_iter_mut().zip(0..triangles.len() as u32).with_min_len(1 << 12);
        *extent = all
            .map(|(drift, id)| {
                let (by, extent) = of_triangle(id);
                *drift = by;
                extent
            })
            .merge(Extent::union)
            .unwrap_or(Extent::EMPTY);
        drift_of_nodes(tree, triangle_drift, drift);
        if drift[0] == 0.0 {
            return Some(1.0);
        }
        let grown = grown_cost(tree, drift);
        Some(if *cost > 0.0 { grown / cost } else { f64::INFINITY })
    }
}

impl Built {
    fn copy(&mut self, triangles: Triangles<'_>) {
        self.positions.clear();
        self.positions.extend_from_slice(triangles.positions);
        self.indices.clear();
        self.indices.extend_from_slice(triangles.indices);
    }

    fn build(&mut self, options: KdTreeOptions) {
        let Self { tree, positions, indices, unusable, cost } = self;
        let triangles = Triangles { positions, indices };
        tree.set_options(KdTreeOptions { lazy_below: 0, ..options }).expect("options that were checked");
        tree.build(triangles);
        unusable.clear();
        if tree.omitted().total() > 0 {
            unusable.extend((0..triangles.len() as u32).filter(|&id| triangles.usable_corners(id).is_err()));
        }
        *cost = grown_cost(tree, &vec![0.0; tree.nodes().len()]);
    }
}

/// Sets the largest drift of a triangle below each node, by node.
fn drift_of_nodes(tree: &KdTree, of_triangles: &[f32], drift: &mut Vec<f32>) {
    let of_leaf = |index: u32| {
        let node = tree.nodes().get(index);
        let ids = if node.is_leaf() { node.ids() } else { 0..0 };
        tree.ids()[ids].iter().map(|&id| of_triangles[id as usize]).fold(0.0, f32::max)
    };
    let indices = (0..tree.nodes().len() as u32).into_par_iter().with_min_len(1 << 10);
    indices.map(of_leaf).collect_into_vec(drift);
    if !drift.is_empty() {
        drift_of_inner_nodes(tree, 0, drift);
    }
}

/// Sets the drifts of all inner nodes from one down, in any layout. Returns that of the node itself.
fn drift_of_inner_nodes(tree: &KdTree, index: u32, drift: &mut [f32]) -> f32 {
    let node = tree.nodes().get(index);
    if !node.is_leaf() {
        let children = tree.nodes().children(index, node);
        let [left, right] = children.map(|child| drift_of_inner_nodes(tree, child, drift));
        drift[index as usize] = left.max(right);
    }
    drift[index as usize]
}

/// Returns the expected cost of a ray through the tree's box if each cell grows by its node's drift, times half the area of
/// that box.
fn grown_cost(tree: &KdTree, drift: &[f32]) -> f64 {
    if tree.extent().is_empty() { 0.0 } else { grown_cost_below(tree, drift, 0, tree.extent(), 0) }
}

fn grown_cost_below(tree: &KdTree, drift: &[f32], index: u32, cell: Extent, depth: u32) -> f64 {
    /// Depth from which one thread takes all nodes below.
    const PARALLEL: u32 = 8;
    let node = tree.nodes().get(index);
    let by = drift[index as usize];
    let larger = Extent { min: cell.min.map(|face| face - by), max: cell.max.map(|face| face + by) };
    let area = larger.half_area();
    if node.is_leaf() {
        return tree.options().costs.test * node.count() as f64 * area;
    }
    let ([left, right], [below, above]) = (tree.nodes().children(index, node), cell.cut(node.plane()));
    let cost = |index: u32, cell: Extent| grown_cost_below(tree, drift, index, cell, depth + 1);
    let (left, right) = if depth < PARALLEL {
        both(|| cost(left, below), || cost(right, above))
    } else {
        (cost(left, below), cost(right, above))
    };
    tree.options().costs.step * area + left + right
}
