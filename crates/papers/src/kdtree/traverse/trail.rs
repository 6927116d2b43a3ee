use std::ops::ControlFlow;

use super::{Line, Reachable, Start, Tester, Way};
use crate::kdtree::KdTraversal;
use crate::kdtree::options::Trail;
use umbrage_rays::Ray;

/// Visits a tree with a stack that holds the last few far children that wait; if it has lost the next one, the ray starts
/// again from above. Without entries that is Foley and Sugerman's *kd-restart* (2005), and with `pushes_down` Horn et al.'s
/// push-down (2007, §3.2); with entries it is their short stack (§3.3).
///
/// The papers find the way back by moving the ray's start to the end of the last leaf. Intervals of neighbours overlap here,
/// so that may lead to the same leaf again, or past one. Instead a bit for each level says whether the ray is in the farther
/// one of two children that it meets (Laine, *Restart Trail for Stackless BVH Traversal*, 2010): this visits the same leaves
/// as a whole stack, in the same order.
pub(super) struct Trailing<'a> {
    pub(super) within: Reachable<'a>,
    pub(super) trail: Trail,
}

/// A node to visit, and the ray's interval in its cell.
#[derive(Clone, Copy, Default)]
struct Position {
    index: u32,
    /// The number of inner nodes above.
    level: u32,
    enter: f64,
    leave: f64,
}

impl Trailing<'_> {
    pub(super) fn visit(&self, ray: &Ray, test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()> {
        let Reachable { tree, .. } = self.within;
        let mut tester = Tester::new(self.within, ray, test);
        let line = match Line::start(tree, ray) {
            Start::Miss => return ControlFlow::Continue(()),
            Start::Everything => return tester.everything(),
            Start::Line(line) => line,
        };
        let mut positions = [Position::default(); KdTraversal::MOST_ENTRIES as usize];
        let Trail { mut stack, pushes_down } = self.trail;
        // The node from which the ray starts again: nothing waits above.
        let mut root = Position { index: 0, level: 0, enter: line.enter, leave: line.leave };
        let mut at = root;
        // By level, whether the ray is in the farther child of a node both of whose children it meets, …
        let mut trail = 0_u64;
        // … and whether that child still waits.
        let mut open = 0_u64;
        loop {
            let node = tree.nodes.get(at.index);
            // Whether the node is finished.
            let mut is_done = node.is_leaf();
            if is_done {
                tester.leaf(node)?;
            } else {
                tester.steps.note(|visits| visits.nodes += 1);
                let plane = node.plane();
                let [near, far] = line.sort(plane, tree.nodes.children(at.index, node));
                let bit = 1 << at.level;
                at.level += 1;
                match line.way(plane, at.enter, at.leave) {
                    Way::Near => at.index = near,
                    Way::Far => at.index = far,
                    Way::Both(_, far_enter) if trail & bit != 0 => {
                        (at.index, at.enter) = (far, far_enter);
                        is_done = far_enter > tester.t_max;
                    }
                    Way::Both(near_leave, far_enter) => {
                        if let Some(slot) = stack.push() {
                            positions[slot] = Position { index: far, enter: far_enter, ..at };
                        }
                        open |= bit;
                        (at.index, at.leave) = (near, near_leave);
                    }
                }
            }
            while is_done {
                if open == 0 || line.is_over(at.leave, tester.t_max) {
                    return ControlFlow::Continue(());
                }
                let level = open.ilog2();
                open &= !(1 << level);
                trail = trail & ((1 << level) - 1) | 1 << level;
                if let Some(slot) = stack.pop() {
                    at = positions[slot];
                    is_done = at.enter > tester.t_max;
                } else {
                    tester.steps.note(|visits| visits.restarts += 1);
                    (at, open, is_done) = (root, 0, false);
                }
            }
            if pushes_down && open == 0 {
                root = at;
            }
        }
    }
}
