use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::filter::{Wide, load};
use super::rays::{LANES, Rays};
use super::step::{Way, Within, backward, begin, way};
use super::tester::Tester;
use crate::KdTree;
use crate::kdtree::node::Nodes;

/// A child that waits, and the members of a packet in its cell. 192 bytes.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct WaitingPacket<'a> {
    /// The tree that it is a node of: a whole one, or a subtree that was built when a ray reached it.
    pub(super) tree: &'a KdTree,
    enter: [f32; LANES],
    leave: [f32; LANES],
    pub(super) members: u16,
    pub(super) index: u32,
    /// The number of inner nodes above, if the traversal counts them.
    pub(super) level: u32,
}

impl<'a> WaitingPacket<'a> {
    /// A whole tree, with no member in it.
    pub(super) fn at_root(tree: &'a KdTree) -> Self {
        Self { tree, enter: [0.0; LANES], leave: [0.0; LANES], members: 0, index: 0, level: 0 }
    }

    #[inline(always)]
    pub(super) fn put<S: Simd, V: Wide<S>>(&mut self, tree: &'a KdTree, index: u32, level: u32, within: &Within<V>) {
        (self.tree, self.index, self.level, self.members) = (tree, index, level, within.members as u16);
        within.enter.store_slice(&mut self.enter[..V::LEN]);
        within.leave.store_slice(&mut self.leave[..V::LEN]);
    }

    #[inline(always)]
    pub(super) fn within<S: Simd, V: Wide<S>>(&self, simd: S) -> Within<V> {
        Within {
            members: self.members.into(),
            enter: V::from_slice(simd, &self.enter[..V::LEN]),
            leave: V::from_slice(simd, &self.leave[..V::LEN]),
        }
    }
}

/// All children that wait.
pub(super) type Stack<'a> = [WaitingPacket<'a>; Nodes::MAX_DEPTH];

/// Leads the rays from `first` on to leaves below the node at `root`, with a stack (Wald et al., *Interactive Rendering with
/// Coherent Ray Tracing*, 2001). Rays may have any directions (Reshetov, *Omnidirectional ray tracing traversal
/// algorithm for kd-trees*, 2006): the child that is nearer for most of them comes first.
#[inline(always)]
pub(super) fn visit<'a, S: Simd, V: Wide<S>>(
    simd: S,
    rays: &mut Rays,
    first: usize,
    root: u32,
    stack: &mut Stack<'a>,
    tester: &mut Tester<'a, '_>,
) {
    let (mut tree, scale) = (tester.tree, tester.scale);
    let mut within = begin::<S, V>(simd, rays, first);
    if within.members == 0 {
        return;
    }
    tester.steps.note(|visits| visits.packets += 1);
    tester.mailbox.clear();
    let mut index = root;
    let mut waiting = 0;
    loop {
        let node = tree.nodes.get(index);
        if node.is_leaf() {
            if node.is_deferred() {
                (tree, index) = (tester.subtree(tree, node), 0);
                continue;
            }
            tester.leaf::<S, V>(simd, rays, first, &tree.ids[node.ids()], within.members);
            let end = load::<S, V>(simd, &rays.leave, first);
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                within = stack[waiting].within(simd);
                within.members &= within.enter.simd_le(end).to_bitmask();
                if within.members != 0 {
                    break;
                }
            }
            within.leave = within.leave.min(end);
            (tree, index) = (stack[waiting].tree, stack[waiting].index);
            continue;
        }
        tester.steps.note(|visits| visits.nodes += 1);
        let plane = node.plane();
        let [left, right] = tree.nodes.children(index, node);
        match way(simd, &scale, rays, first, plane, &within) {
            Way::Left => index = left,
            Way::Right => index = right,
            Way::Both([of_left, of_right]) => {
                let turned = (backward::<S, V>(rays, plane.axis % 3, first) & within.members).count_ones();
                if 2 * turned > within.members.count_ones() {
                    stack[waiting].put(tree, left, 0, &of_left);
                    (index, within) = (right, of_right);
                } else {
                    stack[waiting].put(tree, right, 0, &of_right);
                    (index, within) = (left, of_left);
                }
                waiting += 1;
            }
        }
    }
}
