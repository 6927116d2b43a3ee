//! A hierarchy of boxes, split at the median of the items' middles.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A box of a hierarchy. 32 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Node {
    pub(super) min: [f32; 3],
    /// Index of its first item, or of the first of its two children.
    pub(super) first: u32,
    pub(super) max: [f32; 3],
    /// Number of its items; zero for a box with children.
    pub(super) count: u32,
}

/// An item of a hierarchy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) id: u32,
    min: Vec3,
    max: Vec3,
}

impl Item {
    pub(super) fn new(id: u32, [a, b, c]: [Vec3; 3]) -> Self {
        Self { id, min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// Twice the middle; f64 can hold the sum of any two f32.
    fn middle(&self, axis: usize) -> f64 {
        f64::from(self.min[axis]) + f64::from(self.max[axis])
    }
}

/// A hierarchy whose leaves have at most `most` items each; sorts the items. Empty for no items. Depends on the items,
/// not on their order.
pub(super) fn hierarchy(items: &mut [Item], most: usize) -> Vec<Node> {
    let mut nodes = Vec::new();
    if !items.is_empty() {
        nodes.push(Node::default());
        grow(&mut nodes, 0, items, 0, most.max(1));
    }
    nodes
}

fn grow(nodes: &mut Vec<Node>, at: usize, items: &mut [Item], first: usize, most: usize) {
    let all = |corner: fn(&Item) -> Vec3, join: fn(Vec3, Vec3) -> Vec3| {
        items.iter().map(corner).reduce(join).unwrap_or_default().to_array()
    };
    let (min, max) = (all(|item| item.min, Vec3::min), all(|item| item.max, Vec3::max));
    if items.len() <= most {
        items.sort_unstable_by_key(|item| item.id);
        nodes[at] = Node { min, max, first: first as u32, count: items.len() as u32 };
        return;
    }
    let children = nodes.len();
    nodes[at] = Node { min, max, first: children as u32, count: 0 };
    nodes.extend([Node::default(); 2]);
    let extent = |axis: usize| {
        let middles = || items.iter().map(|item| item.middle(axis));
        middles().fold(f64::NEG_INFINITY, f64::max) - middles().fold(f64::INFINITY, f64::min)
    };
    let extents = [0, 1, 2].map(extent);
    let axis = (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or_default();
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| a.middle(axis).total_cmp(&b.middle(axis)).then(a.id.cmp(&b.id)));
    let (left, right) = items.split_at_mut(half);
    grow(nodes, children, left, first, most);
    grow(nodes, children + 1, right, first + half, most);
}
