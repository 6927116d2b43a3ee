//! The tree as plain words, for those who walk it elsewhere: on a GPU.

use super::KdTree;
use super::extent::Plane;
use super::node::Node;

/// What [`KdTree::write_words`] doesn't write: how nodes find their children, and the bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdTreeForm {
    /// Whether an inner node's left child is the node that follows it and its own word tells the place of the right one;
    /// else the word tells the place of the left child, which the right one follows.
    pub left_follows: bool,
    /// Lower corner of the box around all triangles that can be hit; above `max` where there are none.
    pub min: [f32; 3],
    /// Upper corner of that box.
    pub max: [f32; 3],
}

impl KdTree {
    /// Replaces `nodes` by the tree's nodes, two words each, the root first; none before the first build.
    ///
    /// The lowest two bits of a node's second word are the axis of an inner node's plane, whose coordinate has the bits of
    /// the first word, and the bits above are a child's place. For a leaf both bits are set: the first word is where its
    /// ids start in [`KdTree::ids`], and the bits above are how many it has.
    pub fn write_words(&self, nodes: &mut Vec<[u32; 2]>) -> KdTreeForm {
        nodes.clear();
        nodes.extend((0..self.nodes.len() as u32).map(|place| {
            let node = self.nodes.get(place);
            if node.is_leaf() {
                [node.ids().start as u32, (node.count() as u32) << 2 | 3]
            } else {
                let Plane { axis, at } = node.plane();
                [at.to_bits(), node.child() << 2 | axis as u32]
            }
        }));
        // Asked of a node that isn't there: only the layout counts.
        let apart = Node::inner(Plane { axis: 0, at: 0.0 }, 2);
        let left_follows = self.nodes.children(0, apart) == [1, 2];
        KdTreeForm { left_follows, min: self.extent.min, max: self.extent.max }
    }

    /// Triangle ids, leaf after leaf, ascending in each.
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{KdLayout, KdTree, KdTreeOptions, Triangles};

    /// The ids below a node of the words, and how many nodes there are.
    fn ids_below(nodes: &[[u32; 2]], ids: &[u32], left_follows: bool, place: u32, found: &mut Vec<u32>) -> usize {
        let [first, second] = nodes[place as usize];
        if second & 3 == 3 {
            found.extend(&ids[first as usize..(first + (second >> 2)) as usize]);
            return 1;
        }
        let child = second >> 2;
        let children = if left_follows { [place + 1, child] } else { [child, child + 1] };
        1 + children.map(|child| ids_below(nodes, ids, left_follows, child, found)).into_iter().sum::<usize>()
    }

    #[test]
    fn words_lead_to_every_leaf() {
        let at = |place: usize, corner: usize| {
            Vec3::new((place * 7 % 31) as f32, (place * 11 % 29) as f32, (place * 5 % 23) as f32)
                + [Vec3::X, Vec3::Y, Vec3::Z][corner]
        };
        let positions: Vec<Vec3> = (0..300).map(|vertex| at(vertex / 3, vertex % 3)).collect();
        let indices: Vec<[u32; 3]> = (0..100).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let mut nodes = vec![[7, 7]];
        let mut tree = KdTree::default();
        assert!(tree.write_words(&mut nodes).min[0] > 0.0 && nodes.is_empty());
        for layout in [KdLayout::DepthFirst, KdLayout::Subtrees] {
            tree.set_options(KdTreeOptions { layout, ..KdTreeOptions::DEFAULT }).expect("possible options");
            tree.build(triangles);
            let form = tree.write_words(&mut nodes);
            assert_eq!(form.left_follows, layout == KdLayout::DepthFirst);
            assert_eq!((form.min, form.max), (tree.extent.min, tree.extent.max));
            let mut found = Vec::new();
            let count = ids_below(&nodes, tree.ids(), form.left_follows, 0, &mut found);
            let counts = tree.counts();
            assert_eq!((count as u64, found.len() as u64), (counts.nodes, counts.references));
            found.sort_unstable();
            found.dedup();
            assert_eq!(found, (0..100).collect::<Vec<_>>());
        }
    }
}
