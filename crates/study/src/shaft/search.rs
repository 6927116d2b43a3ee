use umbrage_rays::internals::{Extent, Nodes, Scale};
use umbrage_rays::{Counts, KdTree, Ray, Triangles};

use super::KdEntry;
use super::shaft::Shaft;

/// A node that a shaft meets: where it is, its cell, and the ways along the shaft's axis that are in there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) node: u32,
    pub(super) cell: Extent,
    pub(super) within: [f64; 2],
}

impl Met {
    /// Where rays enter the tree, along a whole shaft.
    fn entry(entry: &EntryPoint, shaft: &Shaft) -> Self {
        Self { node: entry.node, cell: entry.cell, within: [shaft.from, shaft.to].map(f64::from) }
    }

    /// The left and the right child of an inner node; `None` where the shaft doesn't meet it.
    #[inline(always)]
    pub(super) fn children(&self, tree: &KdTree, scale: &Scale, shaft: &Shaft) -> [Option<Self>; 2] {
        let node = tree.nodes().get(self.node);
        let plane = node.plane();
        let [left, right] = tree.nodes().children(self.node, node);
        let [below, above] = self.cell.cut(plane);
        let [in_left, in_right] = shaft.parts(scale, plane, self.within);
        let child = |node, cell, within: [f64; 2]| (within[0] <= within[1]).then_some(Self { node, cell, within });
        [child(left, below, in_left), child(right, above, in_right)]
    }
}

/// A node below which are all triangles that some rays may hit.
#[derive(Clone, Copy, Debug)]
pub struct EntryPoint {
    pub(super) node: u32,
    pub(super) cell: Extent,
}

impl EntryPoint {
    /// That of all rays.
    #[must_use]
    pub fn root(tree: &KdTree) -> Self {
        Self { node: 0, cell: tree.extent() }
    }

    /// Whether it spares rays some of the way from another one.
    #[must_use]
    pub fn is_below(&self, other: &Self) -> bool {
        self.node != other.node
    }

    /// That of all rays between four that begin at `self`, those of a tile's corners say: rays that cross each plane between
    /// those that cross it at the corners of a rectangle. `None` where none of them can hit anything. Adds what it
    /// takes to `visits`.
    #[must_use]
    pub fn of_tile(
        &self,
        tree: &KdTree,
        triangles: Triangles<'_>,
        corners: &[Ray; 4],
        kind: KdEntry,
        visits: &mut Counts,
    ) -> Option<Self> {
        if self.cell.is_empty() {
            return None;
        }
        let scale = Scale::of(&tree.extent());
        let Some(shaft) = Shaft::between_corners(&scale, &tree.extent(), corners) else { return Some(*self) };
        let mut search = Search { tree, triangles, scale: &scale, shaft: &shaft, kind, visits };
        search.start(self).map(|met| Self { node: met.node, cell: met.cell })
    }
}

/// A node both of whose children the shaft meets.
#[derive(Clone, Copy)]
struct Fork {
    node: Met,
    /// The child that wasn't looked into.
    other: Met,
}

/// Looks for the node from which packets in a shaft begin.
pub(super) struct Search<'a> {
    pub(super) tree: &'a KdTree,
    pub(super) triangles: Triangles<'a>,
    pub(super) scale: &'a Scale,
    pub(super) shaft: &'a Shaft,
    pub(super) kind: KdEntry,
    pub(super) visits: &'a mut Counts,
}

impl Search<'_> {
    /// The lowest node, at an entry or below it, below which are all leaves that matter; `None` where there are none.
    ///
    /// First the first such leaf is looked for, and nodes are kept on the way there whose other child the shaft meets too. If
    /// there is a leaf that matters below that child, rays can't begin below the node. MLRTA looks at these nodes from below,
    /// one after the other; AEPSA from above, and stops at the first, which is the one that MLRTA finds last.
    pub(super) fn start(&mut self, entry: &EntryPoint) -> Option<Met> {
        let root = Met::entry(entry, self.shaft);
        if self.kind == KdEntry::Root {
            return Some(root);
        }
        let mut forks = [Fork { node: root, other: root }; Nodes::MAX_DEPTH];
        let mut count = 0;
        let leaf = self.first_leaf(root, &mut forks, &mut count)?;
        let mut start = leaf;
        if self.kind == KdEntry::Accelerated {
            for fork in &forks[..count] {
                if self.first_leaf(fork.other, &mut [], &mut 0).is_some() {
                    start = fork.node;
                    break;
                }
            }
        } else {
            for fork in forks[..count].iter().rev() {
                if self.first_leaf(fork.other, &mut [], &mut 0).is_some() {
                    start = fork.node;
                }
            }
        }
        Some(start)
    }

    /// The first leaf below a node that matters, and the nodes on the way there with another child to look into: in the first
    /// `count` of `forks`, if there is room for any.
    fn first_leaf(&mut self, from: Met, forks: &mut [Fork], count: &mut usize) -> Option<Met> {
        let mut own = [from; Nodes::MAX_DEPTH];
        let mut waiting = 0;
        let mut met = from;
        loop {
            let node = self.tree.nodes().get(met.node);
            if !node.is_leaf() {
                self.visits.searched += 1;
                let axis = node.plane().axis;
                let [left, right] = met.children(self.tree, self.scale, self.shaft);
                if let (Some(left), Some(right)) = (left, right) {
                    let (first, other) = if self.shaft.is_left_first(axis) { (left, right) } else { (right, left) };
                    own[waiting] = other;
                    if let Some(fork) = forks.get_mut(waiting) {
                        *fork = Fork { node: met, other };
                    }
                    waiting += 1;
                    met = first;
                    continue;
                } else if let Some(only) = left.or(right) {
                    met = only;
                    continue;
                }
            } else if self.matters(&self.tree.ids()[node.ids()]) {
                *count = waiting;
                return Some(met);
            }
            // A node with nothing in its first child is no fork.
            waiting = waiting.checked_sub(1)?;
            met = own[waiting];
        }
    }

    /// Whether a leaf has a triangle, and for AEPSA one in the shaft.
    fn matters(&self, ids: &[u32]) -> bool {
        if self.kind == KdEntry::MultiLevel {
            return !ids.is_empty();
        }
        ids.iter().any(|&id| {
            let corners = self.triangles.corners(id);
            let turned = corners.map(|corner| self.shaft.axes.turned(self.scale.point(corner)));
            !self.shaft.is_beside(&turned)
        })
    }
}
