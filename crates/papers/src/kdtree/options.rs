use super::KdPacketOptions;
use super::node::Nodes;

/// The method of finding the planes of a [`KdTree`](super::KdTree).
///
/// The first five find the plane of least cost among the faces of all triangles' boxes, and so make the same tree. The last
/// four regard no costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdBuilder {
    /// Counts the triangles on both sides of each plane anew: O(N²). For small scenes only.
    Naive,
    /// Sorts the faces of boxes at each node: O(N log² N).
    Resorting,
    /// Sorts them once and keeps them in order: O(N log N) (Wald and Havran 2006).
    #[default]
    Presorted,
    /// As `Presorted`, with threads that share the events and triangles of large nodes (Choi et al., *Parallel SAH k-D Tree
    /// Construction*, 2010, nested).
    Nested,
    /// As `Presorted`, with threads that share the levels near the root, whose events stay in one order (Choi et al. 2010,
    /// in-place).
    InPlace,
    /// Min–max binning between 16 planes across each axis, with initial clustering (Shevtsov et al., *Highly Parallel Fast
    /// KD-tree Construction for Interactive Ray Tracing of Dynamic Scenes*, 2007): by far the fastest. Leaves are
    /// larger than with the other builders.
    Binned,
    /// Level after level with 1024 uniform samples (Popov et al., *Experiences with Streaming Construction of SAH
    /// KD-Trees*, 2006).
    Streaming,
    /// Eight uniform samples, eight more where counts change, and a quadratic fit between them (Hunt et al., *Fast kd-tree
    /// Construction with an Adaptive Error-Bounded Heuristic*, 2006).
    Adaptive,
    /// The middle of the cell's longest side, until four triangles are left or the tree has its largest depth: usual before
    /// planes had costs (thesis, chapter 4). For comparison, as the next three.
    SpatialMedian,
    /// As `SpatialMedian`, across x, y and z in turn.
    SpatialInTurn,
    /// Half of the triangles on each side, across the cell's longest side.
    ObjectMedian,
    /// As `ObjectMedian`, across x, y and z in turn.
    ObjectInTurn,
}

/// The kind of boxes around the parts of triangles that planes cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clipping {
    /// Boxes are cut at the plane.
    Boxes,
    /// A box on one side is shrunk around the part of the triangle on that side (Soupikov et al., *Improving KD-Tree Quality
    /// at a Reasonable Construction Cost*, 2008).
    #[default]
    Triangles,
}

/// The order of nodes in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdLayout {
    /// The left child follows its parent.
    #[default]
    DepthFirst,
    /// Cache lines hold subtrees (Havran, *Heuristic Ray Shooting Algorithms*, 2000; the thesis' ordinary subtrees).
    Subtrees,
    /// Pairs of children in random order: the baseline for the others.
    Scattered,
}

/// The way of leading rays to leaves, alone and in packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdTraversal {
    /// With a stack of all far children that wait.
    #[default]
    Stack,
    /// Without a stack: from the root to each leaf (Foley and Sugerman 2005).
    Restart,
    /// As `Restart`, from the lowest node that holds the rest of the ray (Horn et al. 2007, §3.2).
    PushDown,
    /// With a stack of this number of entries, and as `PushDown` when it has lost some (Horn et al. 2007, §3.3).
    ShortStack(u8),
}

impl KdTraversal {
    /// The largest number of entries of a short stack: more are never needed.
    pub const MOST_ENTRIES: u8 = Nodes::MAX_DEPTH as u8;

    /// Returns the state of a traversal without a whole stack; `None` with one.
    pub(super) fn trail(self) -> Option<Trail> {
        let (entries, pushes_down) = match self {
            Self::Stack => return None,
            Self::Restart => (0, false),
            Self::PushDown => (0, true),
            Self::ShortStack(entries) => (entries.into(), true),
        };
        Some(Trail { stack: ShortStack { entries, top: 0, held: 0 }, pushes_down })
    }
}

/// The state of a traversal without a whole stack.
#[derive(Clone, Copy)]
pub(super) struct Trail {
    pub(super) stack: ShortStack,
    pub(super) pushes_down: bool,
}

/// Slots of the last children that wait. A new one replaces the oldest if there are too many.
#[derive(Clone, Copy)]
pub(super) struct ShortStack {
    /// The number of slots, perhaps none.
    entries: usize,
    /// The slot of the next child.
    top: usize,
    held: usize,
}

impl ShortStack {
    /// Returns the slot of another child; `None` if there are no slots.
    #[inline(always)]
    pub(super) fn push(&mut self) -> Option<usize> {
        let slot = self.top;
        self.top = if slot + 1 >= self.entries { 0 } else { slot + 1 };
        self.held = (self.held + 1).min(self.entries);
        (self.entries > 0).then_some(slot)
    }

    /// Returns the slot of the last child, and frees it.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<usize> {
        if self.held == 0 {
            return None;
        }
        self.held -= 1;
        self.top = if self.top == 0 { self.entries - 1 } else { self.top - 1 };
        Some(self.top)
    }
}

/// Costs of the surface area heuristic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SahCosts {
    /// Cost of a traversal step.
    pub step: f64,
    /// Cost of testing a triangle.
    pub test: f64,
    /// Factor of the cost of a plane with an empty side, 0 to 1.
    pub empty: f64,
    /// Whether a triangle on both sides costs a ray through both only one test.
    pub mailbox: bool,
    /// The largest number of planes on the way to a leaf that cost more than they save: later planes may make up for it.
    /// With 0, nodes are leaves as soon as the best plane costs more than a leaf; with
    /// [`MOST_FAILURES`](Self::MOST_FAILURES), only at the largest depth.
    pub failures: u32,
}

impl SahCosts {
    /// As many as there can be: no plane is too expensive.
    pub const MOST_FAILURES: u32 = Nodes::MAX_DEPTH as u32;
}

/// Options of a [`KdTree`](super::KdTree).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdTreeOptions {
    /// The method of finding planes.
    pub builder: KdBuilder,
    /// The kind of boxes around the parts of cut triangles.
    pub clipping: Clipping,
    /// The costs by which planes are judged.
    pub costs: SahCosts,
    /// The order of nodes in memory.
    pub layout: KdLayout,
    /// The way of leading rays to leaves, alone and in packets.
    pub traversal: KdTraversal,
    /// Options of packets of rays.
    pub packets: KdPacketOptions,
    /// Nodes of fewer triangles are built when a ray or packet first reaches them, by the thread that traces it; 0 builds
    /// all at once. The tree and its answers are the same. Rays in only a part of a scene are served sooner; those through
    /// many subtrees take up to a third longer. [`reached`](super::KdTreeCounts::reached) counts those that were built.
    pub lazy_below: u32,
}

impl KdTreeOptions {
    /// The exact builder, with the costs that measured best.
    pub const DEFAULT: Self = Self {
        builder: KdBuilder::Presorted,
        clipping: Clipping::Triangles,
        costs: SahCosts { step: 1.0, test: 2.0, empty: 0.8, mailbox: true, failures: 2 },
        layout: KdLayout::DepthFirst,
        traversal: KdTraversal::Stack,
        packets: KdPacketOptions::DEFAULT,
        lazy_below: 0,
    };

    /// With the fastest builder: for trees that serve a single frame.
    pub const FAST: Self = Self { builder: KdBuilder::Binned, ..Self::DEFAULT };

    /// The largest [`lazy_below`](Self::lazy_below), since the thread of one ray builds such a node.
    pub const MOST_LAZY: u32 = 1 << 12;

    /// Checks that a tree can have these options.
    ///
    /// # Errors
    /// If a cost isn't finite or below zero, the test's cost is zero, the factor for empty space isn't between zero and one,
    /// more than [`MOST_FAILURES`](SahCosts::MOST_FAILURES) planes may fail, a short stack has no entry or more than
    /// [`KdTraversal::MOST_ENTRIES`], or nodes of more than [`MOST_LAZY`](Self::MOST_LAZY) triangles are to be built lazily.
    pub fn check(self) -> Result<(), ImpossibleKdTreeOptions> {
        let SahCosts { step, test, empty, failures, .. } = self.costs;
        let is_cost = |cost: f64| cost.is_finite() && cost >= 0.0;
        let has_entries = match self.traversal {
            KdTraversal::ShortStack(entries) => (1..=KdTraversal::MOST_ENTRIES).contains(&entries),
            _ => true,
        };
        let is_lazy_enough = self.lazy_below <= Self::MOST_LAZY;
        let is_possible = is_cost(step) && is_cost(test) && test > 0.0 && (0.0..=1.0).contains(&empty);
        let is_possible = is_possible && failures <= SahCosts::MOST_FAILURES && has_entries && is_lazy_enough;
        if is_possible { Ok(()) } else { Err(ImpossibleKdTreeOptions(self)) }
    }
}

impl Default for KdTreeOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Options that no kd-tree can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a kd-tree can't have costs of {} a step and {} a test, {} of them for empty space, {} planes that fail, traversal \
     {:?} and lazy nodes of fewer than {} triangles",
    .0.costs.step, .0.costs.test, .0.costs.empty, .0.costs.failures, .0.traversal, .0.lazy_below
)]
pub struct ImpossibleKdTreeOptions(pub KdTreeOptions);
