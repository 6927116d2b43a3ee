use crate::parallel::Parallel;
use glam::Vec3;
use rayon::prelude::*;

use super::leaf::Leaf;
use super::split::{Bins, Extent, Item, Split, middles};
use super::{Bvh, Child, Kind, Node, WIDTH};
use crate::Triangles;

/// The memory of a build, kept for the next one.
#[derive(Default)]
pub(super) struct Builder {
    pub(super) items: Vec<Item>,
    /// Room for divided items; a division swaps it with the items.
    spare: Vec<Item>,
    top: Vec<Node>,
    subtrees: Vec<Subtree>,
}

/// Nodes over items, with the subtrees not yet joined. In the top, leaves stand for subtrees.
pub(super) struct Built<'a> {
    top: &'a [Node],
    trees: Vec<NodeItems<'a>>,
    subtrees: &'a [Subtree],
    /// The first node of each subtree, counted from the top's first, and its first leaf.
    starts: Vec<[usize; 2]>,
    pub(super) nodes: usize,
    pub(super) leaves: usize,
}

/// A subtree built by one thread. Nodes and leaves are numbered from zero.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    leaves: Vec<LeafItems>,
    bins: Bins,
}

/// The items of a leaf.
#[derive(Clone, Copy)]
struct LeafItems {
    first: u32,
    count: u32,
}

impl LeafItems {
    fn of(self, items: &[Item]) -> &[Item] {
        &items[self.first as usize..][..self.count as usize]
    }
}

/// Items that become a node or a leaf.
struct NodeItems<'a> {
    items: &'a mut [Item],
    /// Room of the same length, to divide them.
    spare: &'a mut [Item],
    extent: Extent,
}

/// From this depth on, nodes are divided into halves, which bounds the hierarchy's depth for any input.
const DEEP: usize = 40;

/// Items per thread when all threads divide one node.
const CHUNK: usize = 1 << 13;

impl Builder {
    pub(super) fn bytes(&self) -> usize {
        let of_subtree = |tree: &Subtree| {
            tree.nodes.capacity() * size_of::<Node>() + tree.leaves.capacity() * size_of::<LeafItems>()
        };
        (self.items.capacity() + self.spare.capacity()) * size_of::<Item>()
            + self.top.capacity() * size_of::<Node>()
            + self.subtrees.iter().map(of_subtree).sum::<usize>()
    }
}

impl Bvh {
    /// Maximum number of nodes from the root to a leaf, with up to 2²⁷ triangles. The top has [`DEEP`] levels and one for
    /// each halving from 2²⁷ items to the 2¹⁵ of a subtree; a subtree has as many and one for each halving to a single item;
    /// that may be a patch.
    #[doc(hidden)]
    pub const MOST_LEVELS: usize = (DEEP + 12) + (DEEP + 15) + 1;

    /// Replaces the hierarchy by one over `triangles`, on all threads of the current pool. The result is the same for any
    /// number of threads.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        let [is_any_near, is_any_far] = nearness(triangles);
        self.scale = if is_any_far && !is_any_near { SCALE } else { 1.0 };
        if is_any_near && is_any_far {
            self.build_of_triangles(triangles, Share::Near);
            let far = self.far.get_or_insert_default();
            (far.level, far.scale) = (self.level, SCALE);
            far.build_of_triangles(triangles, Share::Far);
            return;
        }
        self.far = None;
        if !self.build_of_patches(triangles) {
            self.build_of_triangles(triangles, Share::All);
        }
    }

    fn build_of_triangles(&mut self, triangles: Triangles<'_>, share: Share) {
        self.omitted = triangles.omitted();
        let Self { nodes, leaves, scale, root, builder, omitted, .. } = self;
        let scale = *scale;
        builder.collect(triangles, omitted.total() > 0, share, scale);
        let built = builder.build(Leaf::LANES);
        nodes.resize(built.nodes, Node::EMPTY);
        leaves.resize(built.leaves, Leaf::EMPTY);
        *root = Child::node(0);
        built.write_nodes(nodes, 0, |leaf, items| Child::leaf(leaf, items.len()));
        built.fill_leaves(leaves, |id| triangles.corners(id).map(|corner| corner * scale));
    }
}

impl Built<'_> {
    /// Fills all leaves with the scaled corners of their triangles.
    pub(super) fn fill_leaves(&self, leaves: &mut [Leaf], corners: impl Fn(u32) -> [Vec3; 3] + Sync) {
        let mut rest = leaves;
        let into = self.trees.iter().zip(self.subtrees).map(|(range, subtree)| {
            let leaves;
            (leaves, rest) = std::mem::take(&mut rest).split_at_mut(subtree.leaves.len());
            (&*range.items, subtree, leaves)
        });
        into.collect::<Vec<_>>().into_par_iter().each(|(items, subtree, leaves)| {
            for (leaf, part) in leaves.iter_mut().zip(&subtree.leaves) {
                leaf.fill(part.of(items).iter().map(Item::id), &corners);
            }
        });
    }

    /// Writes all nodes, behind `before` others: first the top's, whose first is the root, then those of each subtree.
    /// `child` makes the reference to a leaf from its number and its items.
    pub(super) fn write_nodes(
        &self,
        nodes: &mut [Node],
        before: usize,
        child: impl Fn(usize, &[Item]) -> Child + Sync,
    ) {
        let (into_top, mut rest) = nodes.split_at_mut(self.top.len());
        for (into, node) in into_top.iter_mut().zip(self.top) {
            let subtree_of = |child: Child| match child.kind() {
                _ if child == Child::NONE => child,
                Kind::Node(index) => Child::node(before + index),
                Kind::Leaf { index, .. } => Child::node(before + self.starts[index][0]),
            };
            *into = Node { children: node.children.map(subtree_of), ..*node };
        }
        let into = self.trees.iter().zip(self.subtrees).zip(&self.starts).map(|((range, subtree), &start)| {
            let nodes;
            (nodes, rest) = std::mem::take(&mut rest).split_at_mut(subtree.nodes.len());
            (&*range.items, subtree, start, nodes)
        });
        into.collect::<Vec<_>>().into_par_iter().each(|(items, subtree, [first_node, first_leaf], nodes)| {
            for (into, node) in nodes.iter_mut().zip(&subtree.nodes) {
                let moved = |of: Child| match of.kind() {
                    _ if of == Child::NONE => of,
                    Kind::Node(index) => Child::node(before + first_node + index),
                    Kind::Leaf { index, .. } => child(first_leaf + index, subtree.leaves[index].of(items)),
                };
                *into = Node { children: node.children.map(moved), ..*node };
            }
        });
    }
}

impl Builder {
    /// Builds nodes over all items, with leaves of at most `most` items.
    pub(super) fn build(&mut self, most: usize) -> Built<'_> {
        let Self { items, spare, top, subtrees } = self;
        top.clear();
        spare.resize(items.len(), Item::default());
        let extent = items.par_chunks(CHUNK).map(bounds).merge(Extent::union).unwrap_or(Extent::EMPTY);
        let mut trees = Vec::new();
        if !items.is_empty() {
            divide_top(NodeItems { items, spare, extent }, most, top, &mut trees);
        }
        subtrees.resize_with(subtrees.len().max(trees.len()), Subtree::default);
        trees.par_iter_mut().zip(&mut *subtrees).each(|(range, subtree)| subtree.build(range, most));
        let (mut nodes, mut leaves) = (top.len(), 0);
        let starts = subtrees[..trees.len()].iter().map(|subtree| {
            let start = [nodes, leaves];
            (nodes, leaves) = (nodes + subtree.nodes.len(), leaves + subtree.leaves.len());
            start
        });
        let starts = starts.collect();
        let subtrees = &subtrees[..trees.len()];
        Built { top, trees, subtrees, starts, nodes, leaves }
    }

    /// Collects the boxes of the triangles of a share that can be hit, in order of id.
    fn collect(&mut self, triangles: Triangles<'_>, some_are_omitted: bool, share: Share, scale: f32) {
        let item = |id: u32, corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(|corner| (corner * scale).extend(0.0));
            Item::new(Extent { low: a.min(b).min(c), high: a.max(b).max(c) }, id)
        };
        let all = 0..triangles.len() as u32;
        if some_are_omitted || share != Share::All {
            let corners = |id: u32| triangles.usable_corners(id).ok().filter(|corners| share.holds(corners));
            self.items.clear();
            self.items.extend(all.filter_map(|id| Some(item(id, corners(id)?))));
        } else {
            all.into_par_iter()
                .with_min_len(CHUNK)
                .map(|id| item(id, triangles.corners(id)))
                .collect_into_vec(&mut self.items);
        }
    }
}

/// Divides items into ranges for many threads, and builds the nodes above these.
fn divide_top<'a>(whole: NodeItems<'a>, most: usize, top: &mut Vec<Node>, trees: &mut Vec<NodeItems<'a>>) {
    // Independent of the number of threads.
    const MOST_TREES: usize = 64;
    let largest = (whole.items.len() / MOST_TREES).clamp(1 << 10, 1 << 15);
    if whole.items.len() <= largest {
        trees.push(whole);
        return;
    }
    divide_top_node(whole, [largest, most], 0, top, trees);
}

fn divide_top_node<'a>(
    whole: NodeItems<'a>,
    [largest, most]: [usize; 2],
    depth: usize,
    top: &mut Vec<Node>,
    trees: &mut Vec<NodeItems<'a>>,
) -> Child {
    let index = top.len();
    top.push(Node::EMPTY);
    let children = children_of(whole, largest, |range| {
        let split = if depth < DEEP { best_split_on_all_threads(range.items, most) } else { None };
        range.divided(split)
    });
    for (slot, child) in children.into_iter().enumerate() {
        top[index].set_bounds(slot, child.extent);
        top[index].children[slot] = if child.items.len() > largest {
            divide_top_node(child, [largest, most], depth + 1, top, trees)
        } else {
            trees.push(child);
            Child::leaf(trees.len() - 1, 1)
        };
    }
    Child::node(index)
}

/// The children of a node: the largest child with more than `enough` items is divided until there are enough children.
fn children_of<'a>(
    whole: NodeItems<'a>,
    enough: usize,
    mut divide: impl FnMut(NodeItems<'a>) -> [NodeItems<'a>; 2],
) -> Vec<NodeItems<'a>> {
    let mut children = Vec::with_capacity(WIDTH);
    children.push(whole);
    while children.len() < WIDTH {
        let divisible = children.iter().enumerate().filter(|(_, child)| child.items.len() > enough);
        let Some((index, _)) = divisible.max_by(|(_, a), (_, b)| a.extent.area().total_cmp(&b.extent.area())) else {
            break;
        };
        let [first, second] = divide(children.swap_remove(index));
        children.push(first);
        children.push(second);
    }
    children
}

fn best_split_on_all_threads(items: &[Item], most: usize) -> Option<Split> {
    let middles = items.par_chunks(CHUNK).map(middles).merge(Extent::union).unwrap_or(Extent::EMPTY);
    let none = || {
        let mut bins = Bins::default();
        bins.clear(middles, items.len());
        bins
    };
    let bins = items.par_chunks(CHUNK).fold(none, |mut bins, items| {
        bins.fill(items);
        bins
    });
    let merge = |mut bins: Bins, other: Bins| {
        bins.merge(&other);
        bins
    };
    bins.reduce(none, merge).best(most)
}

impl<'a> NodeItems<'a> {
    /// Divides the range into two, on all threads; into halves where there is no split.
    fn divided(self, split: Option<Split>) -> [Self; 2] {
        let Some(split) = split else { return self.halves() };
        let (items, spare) = (self.spare, self.items);
        let (mut first, mut second) = items.split_at_mut(split.first);
        let counts: Vec<usize> = spare.par_chunks(CHUNK).map(|items| split.count_first(items)).collect();
        let mut parts = Vec::with_capacity(counts.len());
        for (from, count) in spare.chunks(CHUNK).zip(counts) {
            let into;
            let others;
            (into, first) = first.split_at_mut(count);
            (others, second) = second.split_at_mut(from.len() - count);
            parts.push((from, [into, others]));
        }
        parts.into_par_iter().each(|(from, into)| split.scatter(from, &mut { into }));
        Self { items, spare, extent: self.extent }.cut(split.first, split.extents)
    }

    /// The first and the second half.
    fn halves(self) -> [Self; 2] {
        let middle = self.items.len() / 2;
        let (first, second) = self.items.split_at(middle);
        let extents = [bounds(first), bounds(second)];
        self.cut(middle, extents)
    }

    fn cut(self, at: usize, [first, second]: [Extent; 2]) -> [Self; 2] {
        let (items, spare) = (self.items.split_at_mut(at), self.spare.split_at_mut(at));
        [
            Self { items: items.0, spare: spare.0, extent: first },
            Self { items: items.1, spare: spare.1, extent: second },
        ]
    }
}

/// The box around all items.
fn bounds(items: &[Item]) -> Extent {
    items.iter().fold(Extent::EMPTY, |extent, item| extent.union(item.extent()))
}

/// A range of a subtree's items.
#[derive(Clone, Copy)]
struct ItemSpan {
    start: usize,
    end: usize,
    extent: Extent,
}

impl ItemSpan {
    fn len(&self) -> usize {
        self.end - self.start
    }
}

impl Subtree {
    fn build(&mut self, range: &mut NodeItems<'_>, most: usize) {
        self.nodes.clear();
        self.leaves.clear();
        let whole = ItemSpan { start: 0, end: range.items.len(), extent: range.extent };
        self.node(range.items, whole, most, 0);
    }

    fn node(&mut self, items: &mut [Item], whole: ItemSpan, most: usize, depth: usize) -> Child {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let mut children = [whole; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let mut widest: Option<(f32, usize)> = None;
            for (slot, child) in children[..count].iter().enumerate() {
                let area = child.extent.area();
                if child.len() > most && widest.is_none_or(|(most, _)| area > most) {
                    widest = Some((area, slot));
                }
            }
            let Some((_, slot)) = widest else { break };
            [children[slot], children[count]] = self.divide(items, children[slot], most, depth);
            count += 1;
        }
        for (slot, part) in children[..count].iter().enumerate() {
            let child = if part.len() > most {
                self.node(items, *part, most, depth + 1)
            } else {
                self.leaves.push(LeafItems { first: part.start as u32, count: part.len() as u32 });
                Child::leaf(self.leaves.len() - 1, part.len())
            };
            let node = &mut self.nodes[index];
            node.set_bounds(slot, part.extent);
            node.children[slot] = child;
        }
        Child::node(index)
    }

    /// Divides a part of the items.
    fn divide(&mut self, items: &mut [Item], part: ItemSpan, most: usize, depth: usize) -> [ItemSpan; 2] {
        let items = &mut items[part.start..part.end];
        let split = if depth < DEEP {
            self.bins.clear(middles(items), items.len());
            self.bins.fill(items);
            self.bins.best(most)
        } else {
            None
        };
        let (first, extents) = match split {
            Some(split) => {
                split.partition(items);
                (split.first, split.extents)
            }
            None => {
                let (first, second) = items.split_at(items.len() / 2);
                (first.len(), [bounds(first), bounds(second)])
            }
        };
        let middle = part.start + first;
        [
            ItemSpan { start: part.start, end: middle, extent: extents[0] },
            ItemSpan { start: middle, end: part.end, extent: extents[1] },
        ]
    }
}

impl Node {
    pub(super) fn set_bounds(&mut self, slot: usize, extent: Extent) {
        for axis in 0..3 {
            self.bounds[2 * axis][slot] = extent.low[axis];
            self.bounds[2 * axis + 1][slot] = extent.high[axis];
        }
    }
}

/// The triangles of a hierarchy.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Share {
    All,
    /// Triangles without a coordinate above [`HUGE`].
    Near,
    /// The others.
    Far,
}

/// Larger coordinates are scaled, so that areas of boxes don't overflow and reciprocals of rays don't underflow.
pub(super) const HUGE: f32 = (1_u64 << 40) as f32;

/// Triangles within this bound, once scaled, have boxes without areas. Where there are both such and huge ones, as with one
/// far vertex, each kind has a hierarchy of its own.
const COMMON: f32 = (1_u64 << 30) as f32;

/// Factor for huge coordinates. It loses less of small ones than boxes are grown by.
pub(super) const SCALE: f32 = 1.0 / (1_u128 << 100) as f32;

impl Share {
    fn holds(self, corners: &[Vec3; 3]) -> bool {
        let is_far = || corners.iter().any(|corner| corner.abs().max_element() > HUGE);
        match self {
            Self::All => true,
            Self::Near => !is_far(),
            Self::Far => is_far(),
        }
    }
}

/// Whether any triangle that can be hit has only common coordinates, and whether any has a huge one.
fn nearness(triangles: Triangles<'_>) -> [bool; 2] {
    let is_huge = |position: &Vec3| (HUGE..f32::INFINITY).contains(&position.abs().max_element());
    if !triangles.positions.par_iter().with_min_len(1 << 14).any(is_huge) {
        return [true, false];
    }
    let any = |holds: fn(&[Vec3; 3]) -> bool| {
        let ids = (0..triangles.len() as u32).into_par_iter().with_min_len(1 << 14);
        ids.any(|id| triangles.usable_corners(id).is_ok_and(|corners| holds(&corners)))
    };
    let is_common = |corners: &[Vec3; 3]| corners.iter().all(|corner| corner.abs().max_element() <= COMMON);
    [any(is_common), any(|corners| Share::Far.holds(corners))]
}
