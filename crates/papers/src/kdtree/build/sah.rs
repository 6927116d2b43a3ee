use super::super::SahCosts;
use super::super::extent::{Extent, Plane};
use super::super::node::Nodes;
use crate::kdtree::KdTree;

/// The surface area heuristic, which rates planes and decides on leaves (Wald and Havran 2006, §3 and §4.1.3).
#[derive(Clone, Copy, Debug)]
pub(super) struct Heuristic {
    pub(super) costs: SahCosts,
    /// The largest number of inner nodes above a leaf.
    pub(super) max_depth: u32,
}

/// A cell to be split.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Its box.
    pub extent: Extent,
    pub(super) depth: u32,
    /// The number of planes above that cost more than they saved.
    failures: u32,
    /// The largest number of references, and of leaves, in the cell.
    budget: f64,
}

/// A plane, and its cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplitCandidate {
    /// Its cost by the heuristic.
    pub cost: f64,
    pub plane: Plane,
    /// Whether triangles inside the plane are listed on the left.
    pub planar_left: bool,
}

impl SplitCandidate {
    /// The cheaper of two.
    pub(super) fn better(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(a), Some(b)) => Some(if b.is_better(&a) { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// At equal costs the lowest axis, then the lowest plane is better, so that the order of planes doesn't matter.
    fn is_better(&self, other: &Self) -> bool {
        let key = |candidate: &Self| (candidate.cost, candidate.plane.axis, candidate.plane.at);
        key(self) < key(other)
    }
}

/// A cell with data for the costs of its planes, and the best plane so far.
pub(super) struct Measure<'a> {
    heuristic: &'a Heuristic,
    pub(super) extent: Extent,
    pub(super) count: usize,
    per_area: f64,
    pub(super) best: Option<SplitCandidate>,
}

impl<'a> Measure<'a> {
    pub(super) fn new(heuristic: &'a Heuristic, extent: Extent, count: usize) -> Self {
        Self { heuristic, extent, count, per_area: 1.0 / extent.half_area(), best: None }
    }

    /// Returns the quantities that planes across an axis share.
    #[inline(always)]
    pub(super) fn axis(&self, axis: usize) -> AxisMeasure {
        let side = |axis: usize| f64::from(self.extent.max[axis]) - f64::from(self.extent.min[axis]);
        let (a, b) = (side((axis + 1) % 3), side((axis + 2) % 3));
        AxisMeasure {
            axis,
            low: self.extent.min[axis],
            high: self.extent.max[axis],
            face: a * b * self.per_area,
            rim: (a + b) * self.per_area,
        }
    }

    /// Keeps the plane at `at` if it is the best so far, given the numbers of triangles left of it, inside it and right of
    /// it.
    ///
    /// A plane through one of the cell's own faces counts if triangles lie inside it: it cuts them off in a flat cell.
    #[inline(always)]
    pub(super) fn consider(&mut self, along: &AxisMeasure, at: f32, [left, planar, right]: [f64; 3]) {
        let (low, high) = (along.low, along.high);
        if !(low <= at && at <= high && low < high) {
            return;
        }
        let shares = along.shares(at);
        let with_left = [left + planar, right];
        let with_right = [left, right + planar];
        if at > low && at < high {
            self.note(along.axis, at, true, with_left, shares);
            if planar > 0.0 {
                self.note(along.axis, at, false, with_right, shares);
            }
        } else if planar > 0.0 {
            let planar_left = at == low;
            self.note(along.axis, at, planar_left, if planar_left { with_left } else { with_right }, shares);
        }
    }

    /// As [`consider`](Self::consider), for a plane that cuts off empty space: on the left, or on the right.
    pub(super) fn consider_empty(&mut self, along: &AxisMeasure, at: f32, is_left: bool) {
        if along.low < at && at < along.high {
            let all = self.count as f64;
            let counts = if is_left { [0.0, all] } else { [all, 0.0] };
            self.note(along.axis, at, !is_left, counts, along.shares(at));
        }
    }

    #[inline(always)]
    fn note(&mut self, axis: usize, at: f32, planar_left: bool, counts: [f64; 2], shares: [f64; 2]) {
        let candidate = SplitCandidate {
            cost: self.heuristic.cost(self.count as f64, counts, shares),
            plane: Plane { axis, at },
            planar_left,
        };
        if self.best.is_none_or(|best| candidate.is_better(&best)) && candidate.cost.is_finite() {
            self.best = Some(candidate);
        }
    }
}

/// Quantities that planes across one axis of a cell share.
#[derive(Clone, Copy)]
pub(super) struct AxisMeasure {
    pub(super) axis: usize,
    pub(super) low: f32,
    pub(super) high: f32,
    /// The area of the cell's face across the axis, relative to half of the cell's surface.
    face: f64,
    /// Half the length of that face's rim, relative to the same.
    rim: f64,
}

impl AxisMeasure {
    /// The chances that a ray through the cell meets the parts left and right of a plane.
    #[inline(always)]
    pub(super) fn shares(&self, at: f32) -> [f64; 2] {
        let at = f64::from(at);
        [at - f64::from(self.low), f64::from(self.high) - at].map(|depth| self.face + depth * self.rim)
    }
}

impl Heuristic {
    /// Makes the heuristic for `count` triangles. The depth is at most 5 + 1.2 log₂ N, k₁ and k₂ of the thesis' §4.1 (Havran
    /// 2000). Five levels more double the nodes of Sibenik, and no ray gets faster.
    pub(super) fn new(costs: SahCosts, count: usize) -> Self {
        let depth = 5.0 + 1.2 * (count.max(1) as f64).log2();
        Self { costs, max_depth: (depth as u32).min(Nodes::MAX_DEPTH as u32) }
    }

    /// The cell of the root.
    pub(super) fn root(extent: Extent, count: usize) -> Cell {
        let budget = count as f64 * KdTree::MOST_REFERENCES as f64 + KdTree::LEAST_LIMIT as f64;
        Cell { extent, depth: 0, failures: 0, budget }
    }

    /// Cost of a cell of `count` triangles that is cut in two (thesis, equation 4.6, and for mailboxes Hunt 2008).
    #[inline(always)]
    fn cost(&self, count: f64, [left, right]: [f64; 2], shares: [f64; 2]) -> f64 {
        let SahCosts { step, test, empty, mailbox, .. } = self.costs;
        let twice = if mailbox { (left + right - count) * (shares[0] + shares[1] - 1.0) } else { 0.0 };
        let cost = step + test * (left * shares[0] + right * shares[1] - twice);
        if left == 0.0 || right == 0.0 { cost * empty } else { cost }
    }

    /// Returns the two cells of the best plane, unless a leaf is better. Once triangles are parted, [`Cell::share`] sets the
    /// largest number of references of each.
    pub(super) fn split(
        &self,
        cell: &Cell,
        count: usize,
        best: Option<SplitCandidate>,
    ) -> Option<(SplitCandidate, [Cell; 2])> {
        let best = best?;
        let failures = cell.failures + u32::from(best.cost >= self.costs.test * count as f64);
        let most = 2.0 * (count as f64).max(1.0);
        if cell.depth >= self.max_depth || failures > self.costs.failures || most > cell.budget {
            return None;
        }
        let depth = cell.depth + 1;
        Some((best, cell.extent.cut(best.plane).map(|extent| Cell { extent, depth, failures, ..*cell })))
    }
}

impl Cell {
    /// Shares the budget of a cell between its children, in proportion to their references.
    ///
    /// A cell is split only if its budget is at least twice its references. So the budget of each child is at least its own
    /// references, for any triangles, and all leaves together hold no more than the root's budget.
    pub(crate) fn share(mut cells: [Self; 2], counts: [usize; 2]) -> [Self; 2] {
        let weights = counts.map(|count| count.max(1) as f64);
        for (cell, weight) in cells.iter_mut().zip(weights) {
            cell.budget *= weight / (weights[0] + weights[1]);
        }
        cells
    }
}
