use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::filter::{Wide, load, splat};
use super::rays::Rays;
use super::stack::{Stack, WaitingPacket};
use super::step::{Way, Within, backward, begin, way};
use super::tester::Tester;
use crate::kdtree::options::Trail;
use umbrage_rays::each;

/// Leads the rays from `first` on to leaves below the node at `root`, with a stack of some entries or none. If that has lost
/// the next child, the packet starts again from above (Horn et al. 2007, appendix A.5, for packets).
///
/// The papers start a packet again with all its rays behind the leaf that they left, and so must separate rays of different
/// signs. Here a bit for each level says whether the packet is in the second of two children. The way there is the same each
/// time, since it doesn't depend on hits. `order` has the second child for each axis.
#[inline(always)]
pub(super) fn visit<'a, S: Simd, V: Wide<S>>(
    simd: S,
    rays: &mut Rays,
    first: usize,
    root: u32,
    positions: &mut Stack<'a>,
    tester: &mut Tester<'a, '_>,
    Trail { stack: mut waiting, pushes_down }: Trail,
) {
    let (mut tree, scale) = (tester.tree, tester.scale);
    let mut within = begin::<S, V>(simd, rays, first);
    if within.members == 0 {
        return;
    }
    tester.steps.note(|visits| visits.packets += 1);
    tester.mailbox.clear();
    let order = Order::new::<S, V>(rays, first, within.members);
    let (mut index, mut level) = (root, 0_u32);
    let mut root = WaitingPacket::at_root(tree);
    root.put(tree, index, level, &within);
    let (mut trail, mut open) = (0_u64, 0_u64);
    // Rays that have ended.
    let mut ended = 0_u64;
    loop {
        let node = tree.nodes.get(index);
        let mut is_done = node.is_leaf();
        if is_done && node.is_deferred() {
            (tree, index) = (tester.subtree(tree, node), 0);
            continue;
        }
        if is_done {
            let end = load::<S, V>(simd, &rays.leave, first);
            let members = within.members & within.enter.simd_le(end).to_bitmask();
            if members != 0 {
                tester.leaf::<S, V>(simd, rays, first, &tree.ids[node.ids()], members);
            }
        } else {
            tester.steps.note(|visits| visits.nodes += 1);
            let plane = node.plane();
            let [left, right] = tree.nodes.children(index, node);
            let bit = 1 << level;
            level += 1;
            match way(simd, &scale, rays, first, plane, &within) {
                Way::Left => index = left,
                Way::Right => index = right,
                Way::Both([of_left, of_right]) => {
                    let [(near, of_near), (far, of_far)] = if order.turned[plane.axis % 3] {
                        [(right, of_right), (left, of_left)]
                    } else {
                        [(left, of_left), (right, of_right)]
                    };
                    if trail & bit != 0 {
                        (index, within) = (far, of_far);
                        is_done = is_over(simd, rays, first, &within);
                    } else {
                        if let Some(slot) = waiting.push() {
                            positions[slot].put(tree, far, level, &of_far);
                        }
                        open |= bit;
                        (index, within) = (near, of_near);
                    }
                }
            }
        }
        while is_done {
            ended |= order.ended(simd, rays, first, &within);
            if open == 0 || !ended & order.members == 0 {
                return;
            }
            let deepest = open.ilog2();
            open &= !(1 << deepest);
            trail = trail & ((1 << deepest) - 1) | 1 << deepest;
            if let Some(slot) = waiting.pop() {
                let position = &positions[slot];
                (tree, index, level) = (position.tree, position.index, position.level);
                within = position.within(simd);
                is_done = is_over(simd, rays, first, &within);
            } else {
                tester.steps.note(|visits| visits.restarts += 1);
                (tree, index, level) = (root.tree, root.index, root.level);
                within = root.within(simd);
                open = 0;
                is_done = false;
            }
        }
        if pushes_down && open == 0 {
            root.put(tree, index, level, &within);
        }
    }
}

/// Whether nothing in a cell matters to any member.
#[inline(always)]
fn is_over<S: Simd, V: Wide<S>>(simd: S, rays: &Rays, first: usize, within: &Within<V>) -> bool {
    let end = load::<S, V>(simd, &rays.leave, first);
    within.members & within.enter.simd_le(end).to_bitmask() == 0
}

/// The order in which a packet visits children.
struct Order {
    members: u64,
    /// By axis, whether the right child comes first.
    turned: [bool; 3],
    /// Members that meet children in this order.
    sorted: u64,
}

impl Order {
    /// Returns the order of most `members`.
    #[inline(always)]
    fn new<S: Simd, V: Wide<S>>(rays: &Rays, first: usize, members: u64) -> Self {
        let mut turned = [false; 3];
        let mut sorted = members;
        for (axis, turned) in turned.iter_mut().enumerate() {
            let backward = backward::<S, V>(rays, axis, first);
            *turned = 2 * (backward & members).count_ones() > members.count_ones();
            sorted &= if *turned { backward } else { !backward };
        }
        Self { members, turned, sorted }
    }

    /// Returns the members of a finished cell that need no other cell: children that wait begin at the end of a nearer cell
    /// that holds this one, or up to twice the doubt before.
    #[inline(always)]
    fn ended<S: Simd, V: Wide<S>>(&self, simd: S, rays: &Rays, first: usize, within: &Within<V>) -> u64 {
        let [x, y, z] = each!(axis in [0, 1, 2] => load::<S, V>(simd, &rays.doubt[axis], first));
        let doubt = x.max(y).max(z);
        let end = load::<S, V>(simd, &rays.leave, first);
        // Four times the doubt instead of two, so that roundings don't matter.
        let four = splat::<S, V>(simd, 4.0);
        (within.leave - four * doubt).simd_gt(end).to_bitmask() & within.members & self.sorted
            | end.simd_lt(splat::<S, V>(simd, f32::MIN)).to_bitmask() & self.members
    }
}
