use crate::KdTree;
use crate::kdtree::{Extent, Nodes, Scale};
use umbrage_rays::{Counts, Ray, Triangles};

use super::KdEntry;
use super::shaft::Shaft;

/// A node that a shaft meets: its index, its cell, and the interval along the shaft's axis inside the cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) node: u32,
    pub(super) cell: Extent,
    pub(super) within: [f64; 2],
}

impl Met {
    /// The tree's entry, for the whole shaft.
    fn entry(entry: &EntryPoint, shaft: &Shaft) -> Self {
        Self { node: entry.node, cell: entry.cell, within: [shaft.from, shaft.to].map(f64::from) }
    }

    /// The left and the right child of an inner node; `None` for a child that the shaft doesn't meet.
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

/// A node above all triangles that some rays may hit.
#[derive(Clone, Copy, Debug)]
pub struct EntryPoint {
    pub(super) node: u32,
    pub(super) cell: Extent,
}

impl EntryPoint {
    /// The root, for any rays.
    #[must_use]
    pub fn root(tree: &KdTree) -> Self {
        Self { node: 0, cell: tree.extent() }
    }

    /// Whether it saves rays a part of the way from another entry.
    #[must_use]
    pub fn is_below(&self, other: &Self) -> bool {
        self.node != other.node
    }

    /// The entry of all rays between the corners of a tile: rays that begin at `self` and cross each plane inside of the
    /// rectangle of the four corner rays' crossings. `None` if none of them can hit anything. Adds its work to `visits`.
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

/// A node whose children the shaft both meets.
#[derive(Clone, Copy)]
struct Fork {
    node: Met,
    /// The child that wasn't searched.
    other: Met,
}

/// Searches the node from which packets in a shaft begin.
pub(super) struct Search<'a> {
    pub(super) tree: &'a KdTree,
    pub(super) triangles: Triangles<'a>,
    pub(super) scale: &'a Scale,
    pub(super) shaft: &'a Shaft,
    pub(super) kind: KdEntry,
    pub(super) visits: &'a mut Counts,
}

impl Search<'_> {
    /// The lowest node, at an entry or below it, above all leaves that matter; `None` if there are none.
    ///
    /// First it searches the first such leaf, and keeps the nodes on the way whose other child the shaft meets too. If
    /// a leaf that matters is below that child, rays can't begin below the node. MLRTA visits these nodes from below,
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

    /// The first leaf below a node that matters. The nodes on the way with another child to search go to the first
    /// `count` of `forks`, if there is room.
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
            // A node whose first child has no such leaf is no fork.
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
