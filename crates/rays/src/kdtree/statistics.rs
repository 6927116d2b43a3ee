#[cfg(feature = "statistics")]
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::KdTree;
use super::extent::Extent;

/// What a [`KdTree`] is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KdTreeCounts {
    /// Inner nodes above the deepest leaf.
    pub depth: u32,
    /// Nodes, leaves among them.
    pub nodes: u64,
    /// Leaves, empty ones among them.
    pub leaves: u64,
    /// Leaves that list no triangle.
    pub empty_leaves: u64,
    /// Triangles in all leaves.
    pub references: u64,
    /// What a ray through the tree is expected to cost if nothing stops it (thesis, equation 4.5), with the tree's
    /// [costs](super::SahCosts) of a step and a test.
    pub sah_cost: f64,
    /// Subtrees that are built when a ray first [reaches them](super::KdTreeOptions::lazy_below): each counts as a leaf until
    /// then.
    pub deferred: u64,
    /// Those of them that rays have reached.
    pub reached: u64,
}

/// What single rays took. All zeros without the feature `statistics`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KdTreeVisits {
    /// Rays that met the tree's bounds.
    pub rays: u64,
    /// Inner nodes that were visited, again where a ray came from above again.
    pub nodes: u64,
    /// Leaves that were visited.
    pub leaves: u64,
    /// Triangles that were tested.
    pub tests: u64,
    /// Times that a ray came from above again.
    pub restarts: u64,
}

impl KdTree {
    /// What the tree is like; all zeros before the first build.
    #[must_use]
    pub fn counts(&self) -> KdTreeCounts {
        let mut counts = KdTreeCounts::default();
        if self.nodes.len() > 0 {
            self.count_below(0, self.extent, 0, &mut counts);
        }
        let area = self.extent.half_area();
        counts.sah_cost = if area > 0.0 { counts.sah_cost / area } else { 0.0 };
        counts
    }

    fn count_below(&self, place: u32, cell: Extent, depth: u32, counts: &mut KdTreeCounts) {
        let node = self.nodes.get(place);
        let costs = self.options.costs;
        if node.is_leaf() && node.is_deferred() {
            counts.deferred += 1;
            if let Some(subtree) = self.deferred.get(node.ids().start) {
                counts.reached += 1;
                return subtree.count_below(0, cell, depth, counts);
            }
        }
        counts.nodes += 1;
        counts.depth = counts.depth.max(depth);
        if node.is_leaf() {
            counts.leaves += 1;
            counts.empty_leaves += u64::from(node.count() == 0);
            counts.references += node.count() as u64;
            counts.sah_cost += costs.test * node.count() as f64 * cell.half_area();
        } else {
            counts.sah_cost += costs.step * cell.half_area();
            for (child, cell) in self.nodes.children(place, node).into_iter().zip(cell.cut(node.plane())) {
                self.count_below(child, cell, depth + 1, counts);
            }
        }
    }

    /// What single rays took since the last time, and forgets it. All zeros without the feature `statistics`.
    #[must_use]
    pub fn take_visits(&self) -> KdTreeVisits {
        let mut visits = self.visits.take();
        for KdTreeVisits { nodes, leaves, tests, restarts, .. } in
            self.deferred.reached().map(|tree| tree.visits.take())
        {
            visits.nodes += nodes;
            visits.leaves += leaves;
            visits.tests += tests;
            visits.restarts += restarts;
        }
        visits
    }
}

/// Sums of what rays took.
#[derive(Debug, Default)]
pub(super) struct Tally {
    #[cfg(feature = "statistics")]
    sums: [AtomicU64; 5],
}

impl Tally {
    fn take(&self) -> KdTreeVisits {
        #[cfg(feature = "statistics")]
        {
            let [rays, nodes, leaves, tests, restarts] = [0, 1, 2, 3, 4].map(|place| self.sums[place].swap(0, Relaxed));
            KdTreeVisits { rays, nodes, leaves, tests, restarts }
        }
        #[cfg(not(feature = "statistics"))]
        KdTreeVisits::default()
    }
}

/// Counts for one ray, and adds that up when it ends, where the feature `statistics` is on; else it is empty.
pub(super) struct Steps<'a> {
    #[cfg(feature = "statistics")]
    tally: &'a Tally,
    #[cfg(feature = "statistics")]
    counts: KdTreeVisits,
    #[cfg(not(feature = "statistics"))]
    tally: std::marker::PhantomData<&'a Tally>,
}

impl<'a> Steps<'a> {
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(unused_variables, reason = "there is nothing to count in"))]
    pub(super) fn of_ray(tally: &'a Tally) -> Self {
        #[cfg(feature = "statistics")]
        return Self { tally, counts: KdTreeVisits { rays: 1, ..KdTreeVisits::default() } };
        #[cfg(not(feature = "statistics"))]
        Self { tally: std::marker::PhantomData }
    }

    /// Counts in what `count` picks.
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(clippy::unused_self, reason = "there is nothing to count in"))]
    pub(super) fn note(&mut self, count: impl FnOnce(&mut KdTreeVisits)) {
        #[cfg(feature = "statistics")]
        count(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        let _ = count;
    }
}

#[cfg(feature = "statistics")]
impl Drop for Steps<'_> {
    fn drop(&mut self) {
        let KdTreeVisits { rays, nodes, leaves, tests, restarts } = self.counts;
        for (sum, count) in self.tally.sums.iter().zip([rays, nodes, leaves, tests, restarts]) {
            sum.fetch_add(count, Relaxed);
        }
    }
}
