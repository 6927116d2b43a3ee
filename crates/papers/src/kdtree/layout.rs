use super::build::{Cell, Reused};
use super::extent::{Plane, Reference};
use super::node::{Node, Nodes};
use super::{KdLayout, KdTree};

/// A subtree as builders make it: nodes depth first. An inner node holds the distance to its right child, a leaf the number
/// of its ids, which follow those of the leaves before.
#[derive(Debug, Default)]
pub(crate) struct Branch {
    nodes: Vec<Node>,
    ids: Vec<u32>,
    /// The cells of deferred leaves, in order.
    deferred: Vec<Cell>,
    /// The references of deferred leaves, one leaf after the other.
    references: Vec<Reference>,
}

impl Reused for Branch {
    fn clear(&mut self) {
        self.nodes.clear();
        self.ids.clear();
        self.deferred.clear();
        self.references.clear();
    }

    fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.ids.capacity() * size_of::<u32>()
            + self.deferred.capacity() * size_of::<Cell>()
            + self.references.capacity() * size_of::<Reference>()
    }
}

impl Branch {
    /// Adds a leaf.
    pub(crate) fn push_leaf(&mut self, ids: impl Iterator<Item = u32>) {
        let start = self.ids.len();
        self.ids.extend(ids);
        self.nodes.push(Node::leaf(0, (self.ids.len() - start) as u32));
    }

    /// Adds a leaf that a subtree of these references replaces later.
    pub(super) fn push_deferred(&mut self, references: impl Iterator<Item = Reference>, cell: Cell) {
        let start = self.references.len();
        self.references.extend(references);
        let references = &self.references[start..];
        self.ids.extend(references.iter().map(|reference| reference.id));
        self.nodes.push(Node::deferred(0, references.len() as u32));
        self.deferred.push(cell);
    }

    /// Adds an inner node and returns its index. The node that is added next is its left child.
    pub(crate) fn open(&mut self, plane: Plane) -> usize {
        self.nodes.push(Node::inner(plane, 0));
        self.nodes.len() - 1
    }

    /// Makes the node that is added next the right child of the inner node at `index`.
    pub(crate) fn turn_right(&mut self, index: usize) {
        let distance = (self.nodes.len() - index) as u32;
        self.nodes[index] = Node::inner(self.nodes[index].plane(), distance);
    }

    /// Adds a whole subtree.
    pub(crate) fn append(&mut self, other: &Self) {
        self.nodes.extend_from_slice(&other.nodes);
        self.ids.extend_from_slice(&other.ids);
        self.deferred.extend_from_slice(&other.deferred);
        self.references.extend_from_slice(&other.references);
    }
}

impl KdTree {
    /// Lays out the nodes of the branch that was built, and takes its ids.
    pub(super) fn lay_out(&mut self) {
        let Self { nodes, branch, ids, deferred, options, .. } = self;
        std::mem::swap(ids, &mut branch.ids);
        deferred.take_references(&mut branch.references);
        let mut cells = branch.deferred.iter();
        let (mut start, mut first_reference) = (0, 0);
        for node in branch.nodes.iter_mut().filter(|node| node.is_leaf()) {
            let count = node.count() as u32;
            if node.is_deferred() {
                deferred.push(*cells.next().expect("a cell for each"), start as usize, first_reference);
                first_reference += count as usize;
                *node = Node::deferred(start, count);
            } else {
                *node = Node::leaf(start, count);
            }
            start += count;
        }
        nodes.clear(options.layout == KdLayout::DepthFirst);
        match options.layout {
            KdLayout::DepthFirst => {
                nodes.grow_to(branch.nodes.len());
                for (index, &node) in branch.nodes.iter().enumerate() {
                    let moved = Node::inner(node.plane(), index as u32 + node.child());
                    nodes.set(index, if node.is_leaf() { node } else { moved });
                }
            }
            KdLayout::Subtrees => lay_out_subtrees(&branch.nodes, nodes),
            KdLayout::Scattered => lay_out_scattered(&branch.nodes, nodes),
        }
    }
}

/// Lays out cache lines that hold subtrees.
///
/// Children lie in pairs. A subtree is up to four pairs, the nearest to its top; the pairs below start subtrees of
/// their own, which follow depth first. Small ones share a line, but none is spread over two.
fn lay_out_subtrees(branch: &[Node], nodes: &mut Nodes) {
    const PAIRS: usize = Nodes::LINE / 2;
    // The root has a pair of its own, whose second slot is never read.
    nodes.grow_to(2);
    nodes.set(0, branch[0]);
    // Parents whose children have no slots yet: their indices in the branch and in the layout.
    let mut waiting = Vec::new();
    if !branch[0].is_leaf() {
        waiting.push((0, 0));
    }
    let mut subtree = Vec::with_capacity(PAIRS + 1);
    while let Some(top) = waiting.pop() {
        subtree.clear();
        subtree.push(top);
        // Breadth first: parents whose pairs are in this line.
        let mut next = 0;
        while next < subtree.len() && subtree.len() < PAIRS {
            let (parent, _) = subtree[next];
            let inner = children(branch, parent).into_iter().filter(|&child| !branch[child].is_leaf());
            subtree.extend(inner.take(PAIRS - subtree.len()).map(|child| (child, usize::MAX)));
            next += 1;
        }
        let room = Nodes::LINE - nodes.len() % Nodes::LINE;
        let mut index = if 2 * subtree.len() <= room { nodes.len() } else { nodes.len() + room };
        nodes.grow_to(index + 2 * subtree.len());
        let below = waiting.len();
        for at in 0..subtree.len() {
            let (parent, parent_index) = subtree[at];
            nodes.set(parent_index, Node::inner(branch[parent].plane(), index as u32));
            for (child, child_index) in children(branch, parent).into_iter().zip(index..) {
                nodes.set(child_index, branch[child]);
                if branch[child].is_leaf() {
                    continue;
                }
                match subtree.iter_mut().find(|(node, _)| *node == child) {
                    Some((_, index)) => *index = child_index,
                    None => waiting.push((child, child_index)),
                }
            }
            index += 2;
        }
        waiting[below..].reverse();
    }
}

/// Lays out pairs of children in an order that is as good as random, and always the same.
fn lay_out_scattered(branch: &[Node], nodes: &mut Nodes) {
    let pairs = branch.iter().filter(|node| !node.is_leaf()).count();
    let mut starts: Vec<u32> = (1..=pairs as u32).map(|pair| 2 * pair).collect();
    let mut state = 1_u64;
    for last in (1..pairs).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        starts.swap(last, (((state >> 32) * (last as u64 + 1)) >> 32) as usize);
    }
    // The root has a pair of its own, whose second slot is never read.
    nodes.grow_to(2 * (pairs + 1));
    let mut waiting = vec![(0, 0)];
    while let Some((node, slot)) = waiting.pop() {
        if branch[node].is_leaf() {
            nodes.set(slot, branch[node]);
            continue;
        }
        let start = starts.pop().expect("a pair for each inner node");
        nodes.set(slot, Node::inner(branch[node].plane(), start));
        waiting.extend(children(branch, node).into_iter().zip(start as usize..));
    }
}

/// Returns the indices, in a branch, of the children of the inner node at `parent`.
fn children(branch: &[Node], parent: usize) -> [usize; 2] {
    [parent + 1, parent + branch[parent].child() as usize]
}
