use std::ops::ControlFlow;

use super::{Line, Reachable, Start, Tester, Way};
use crate::kdtree::node::Nodes;
use umbrage_rays::Ray;

/// Visits a tree with a stack of the far children that wait (thesis, chapter 5: the recursive traversal, made robust).
pub(super) struct Stacked<'a>(pub(super) Reachable<'a>);

/// A child that waits, and the ray's interval in its cell.
#[derive(Clone, Copy, Default)]
struct WaitingChild {
    index: u32,
    enter: f64,
    leave: f64,
}

impl Stacked<'_> {
    pub(super) fn visit(&self, ray: &Ray, test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()> {
        let Reachable { tree, .. } = self.0;
        let mut tester = Tester::new(self.0, ray, test);
        let line = match Line::start(tree, ray) {
            Start::Miss => return ControlFlow::Continue(()),
            Start::Everything => return tester.everything(),
            Start::Line(line) => line,
        };
        let mut stack = [WaitingChild::default(); Nodes::MAX_DEPTH];
        let mut waiting = 0;
        let (mut index, mut enter, mut leave) = (0, line.enter, line.leave);
        loop {
            let node = tree.nodes.get(index);
            if node.is_leaf() {
                tester.leaf(node)?;
                loop {
                    if waiting == 0 {
                        return ControlFlow::Continue(());
                    }
                    waiting -= 1;
                    if stack[waiting].enter <= tester.t_max {
                        break;
                    }
                }
                WaitingChild { index, enter, leave } = stack[waiting];
                leave = if tester.t_max < leave { tester.t_max } else { leave };
                continue;
            }
            tester.steps.note(|visits| visits.nodes += 1);
            let plane = node.plane();
            let [near, far] = line.sort(plane, tree.nodes.children(index, node));
            match line.way(plane, enter, leave) {
                Way::Near => index = near,
                Way::Far => index = far,
                Way::Both(near_leave, far_enter) => {
                    stack[waiting] = WaitingChild { index: far, enter: far_enter, leave };
                    waiting += 1;
                    (index, leave) = (near, near_leave);
                }
            }
        }
    }
}
