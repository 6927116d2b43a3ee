use super::KdTree;
use super::extent::Extent;
use umbrage_rays::Counts;

/// Counts of a [`KdTree`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KdTreeCounts {
    /// The number of inner nodes above the deepest leaf.
    pub depth: u32,
    /// Nodes, leaves among them.
    pub nodes: u64,
    /// Leaves, empty ones among them.
    pub leaves: u64,
    /// Leaves that list no triangle.
    pub empty_leaves: u64,
    /// Triangles in all leaves.
    pub references: u64,
    /// The expected cost of a ray through the tree if nothing stops it (thesis, equation 4.5), with the tree's
    /// [costs](super::SahCosts) of a step and a test.
    pub sah_cost: f64,
    /// Subtrees that are built when a ray first [reaches them](super::KdTreeOptions::lazy_below): each counts as a leaf
    /// until then.
    pub deferred: u64,
    /// Those of them that rays have reached.
    pub reached: u64,
}

impl KdTree {
    /// Counts of the tree; all zeros before the first build.
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

    fn count_below(&self, index: u32, cell: Extent, depth: u32, counts: &mut KdTreeCounts) {
        let node = self.nodes.get(index);
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
            for (child, cell) in self.nodes.children(index, node).into_iter().zip(cell.cut(node.plane())) {
                self.count_below(child, cell, depth + 1, counts);
            }
        }
    }

    /// Returns the counts of single rays and packets since the last call, and resets them. All zeros without the feature
    /// `statistics`.
    #[must_use]
    pub fn take_visits(&self) -> Counts {
        let mut visits = self.visits.take();
        for subtree in self.deferred.reached() {
            // The tree itself counts rays.
            visits += Counts { rays: 0, ..subtree.visits.take() };
        }
        visits
    }
}
