//! The tree as plain words, the form that shaders traverse.

use crate::KdTree;
use crate::kdtree::Plane;

/// The rest of the form that [`write_words`] writes: the rule for finding children, and the bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KdTreeForm {
    /// Whether an inner node's left child follows it and its own word has the index of the right child; else the word
    /// has the index of the left child, and the right child follows that.
    pub(super) left_follows: bool,
    /// Lower corner of the bounds of all triangles that can be hit; above `max` if there are none.
    pub(super) min: [f32; 3],
    /// Upper corner of these bounds.
    pub(super) max: [f32; 3],
}

/// Replaces `nodes` by the tree's nodes, two words each, the root first; none before the first build.
///
/// The lowest two bits of a node's second word are the axis of an inner node's plane; the first word has the bits of
/// its coordinate, and the bits above the axis are a child's index. For a leaf both bits are set: the first word is the
/// index of its first id in [`KdTree::ids`], and the bits above are the number of its ids.
pub(super) fn write_words(tree: &KdTree, words: &mut Vec<[u32; 2]>) -> KdTreeForm {
    words.clear();
    let (nodes, extent) = (tree.nodes(), tree.extent());
    words.extend((0..nodes.len() as u32).map(|index| {
        let node = nodes.get(index);
        if node.is_leaf() {
            [node.ids().start as u32, (node.count() as u32) << 2 | 3]
        } else {
            let Plane { axis, at } = node.plane();
            [at.to_bits(), node.child() << 2 | axis as u32]
        }
    }));
    let root = (nodes.len() > 0).then(|| nodes.get(0)).filter(|root| !root.is_leaf());
    // Otherwise the second slot stays empty.
    let left_follows = root.is_some_and(|root| nodes.children(0, root)[0] == 1);
    KdTreeForm { left_follows, min: extent.min, max: extent.max }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use umbrage_rays::Triangles;

    use super::write_words;
    use crate::{KdLayout, KdTree, KdTreeOptions};

    /// Collects the ids below a node of the words, and returns the number of nodes.
    fn ids_below(nodes: &[[u32; 2]], ids: &[u32], left_follows: bool, index: u32, found: &mut Vec<u32>) -> usize {
        let [first, second] = nodes[index as usize];
        if second & 3 == 3 {
            found.extend(&ids[first as usize..(first + (second >> 2)) as usize]);
            return 1;
        }
        let child = second >> 2;
        let children = if left_follows { [index + 1, child] } else { [child, child + 1] };
        1 + children.map(|child| ids_below(nodes, ids, left_follows, child, found)).into_iter().sum::<usize>()
    }

    #[test]
    fn words_lead_to_every_leaf() {
        let at = |index: usize, corner: usize| {
            Vec3::new((index * 7 % 31) as f32, (index * 11 % 29) as f32, (index * 5 % 23) as f32)
                + [Vec3::X, Vec3::Y, Vec3::Z][corner]
        };
        let positions: Vec<Vec3> = (0..300).map(|vertex| at(vertex / 3, vertex % 3)).collect();
        let indices: Vec<[u32; 3]> = (0..100).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let mut nodes = vec![[7, 7]];
        let mut tree = KdTree::default();
        assert!(write_words(&tree, &mut nodes).min[0] > 0.0 && nodes.is_empty());
        for layout in [KdLayout::DepthFirst, KdLayout::Subtrees, KdLayout::Scattered] {
            tree.set_options(KdTreeOptions { layout, ..KdTreeOptions::DEFAULT }).expect("possible options");
            tree.build(triangles);
            let form = write_words(&tree, &mut nodes);
            assert_eq!(form.left_follows, layout == KdLayout::DepthFirst);
            assert_eq!((form.min, form.max), (tree.extent().min, tree.extent().max));
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
