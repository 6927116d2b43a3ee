//! Leads single rays to leaves: `stack` with a stack of all children that wait, `trail` without one or with a short one.
//!
//! **Error bounds.** Along an axis the ray reaches a plane at t = (s − o) / d. The plane s and the origin o are exact, so
//! only three roundings, each of them relative, separate the computed t from that in real numbers: its error is less than
//! 4 · 2⁻⁵³ |t|. With M the largest magnitude of t inside the tree's bounds, a t above 2M is certainly outside. A child gets
//! the interval of t in which the ray may be in its cell, grown by `doubt` = 2⁻⁴⁸ |t| at the plane, and no more than 2⁻⁴⁸ M,
//! and is left out only if that is empty. So every hit's t in real numbers is inside the interval of each cell whose box,
//! with its faces, holds it, and more than 2⁻⁴⁹ |t| from an end at a plane. A hit's computed t is within two units in its
//! last place of the real one: so a cell whose interval starts behind the nearest computed t so far holds no hit with a
//! computed t as low, and none that ties with it. A doubt of 2⁻⁴⁸ M everywhere would do, but a vertex far away makes M so
//! large that nothing near is left out.
//!
//! A ray that runs along a plane never reaches it: t is infinite, with the sign that leads to the ray's side of the plane.
//! Inside the plane it is 0 · ∞, so NaN; no comparison with it holds, so the ray goes to both sides.

mod stack;
mod trail;

use std::ops::ControlFlow;

use super::extent::Plane;
use super::node::Node;
use super::{KdTraversal, KdTree};
use crate::single::{Visit, answers_single_rays};
use crate::statistics::Steps;
use stack::Stacked;
use trail::Trailing;
use umbrage_rays::{Ray, Triangles};

answers_single_rays!(KdTree);

impl Visit for KdTree {
    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.within(triangles).visit(ray, test)
    }
}

impl KdTree {
    fn within<'a>(&'a self, triangles: Triangles<'a>) -> Reachable<'a> {
        Reachable { tree: self, triangles, traversal: self.options.traversal }
    }
}

/// A tree, and the triangles that subtrees are built of when a ray first reaches them.
#[derive(Clone, Copy)]
struct Reachable<'a> {
    tree: &'a KdTree,
    triangles: Triangles<'a>,
    traversal: KdTraversal,
}

impl Reachable<'_> {
    /// Calls `test` with every triangle in a leaf that `ray` visits before `t_max`, nearer leaves first. `test` may lower
    /// `t_max` or break off. Some triangles are tested more than once.
    pub(super) fn visit(&self, ray: &Ray, test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()> {
        let within = *self;
        match self.traversal.trail() {
            None => Stacked(within).visit(ray, test),
            Some(trail) => Trailing { within, trail }.visit(ray, test),
        }
    }
}

/// The start of a ray's traversal.
enum Start {
    /// The ray misses the tree's bounds.
    Miss,
    /// Numbers so large or small that t can't be trusted: all triangles are tested.
    Everything,
    Line(Line),
}

/// A ray prepared for planes.
struct Line {
    origin: [f64; 3],
    inverse: [f64; 3],
    /// Whether the direction is negative along each axis.
    is_backward: [bool; 3],
    /// The interval of t in which the ray may be inside the tree's bounds.
    enter: f64,
    leave: f64,
    /// Error bound of any t on the ray.
    most_doubt: f64,
    /// Whether planes may hold the whole ray.
    is_along_plane: bool,
}

/// The children of a node that a ray may meet.
enum Way {
    Near,
    Far,
    /// The nearer one before a t, the other one after a t.
    Both(f64, f64),
}

impl Line {
    const DOUBT: f64 = 1.0 / (1_u64 << 48) as f64;
    /// Error bound of a t whose last bits underflow.
    const SMALLEST: f64 = 1e-300;

    fn start(tree: &KdTree, ray: &Ray) -> Start {
        if tree.extent.is_empty() {
            return Start::Miss;
        }
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let inverse = direction.map(f64::recip);
        let (mut enter, mut leave) = (ray.t_min, ray.t_max);
        for axis in 0..3 {
            let faces = [tree.extent.min[axis], tree.extent.max[axis]].map(f64::from);
            if direction[axis] == 0.0 {
                if !(faces[0]..=faces[1]).contains(&origin[axis]) {
                    return Start::Miss;
                }
                continue;
            }
            let [a, b] = faces.map(|face| (face - origin[axis]) * inverse[axis]);
            if !(inverse[axis].is_finite() && a.is_finite() && b.is_finite()) {
                return Start::Everything;
            }
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        let doubt = enter.abs().max(leave.abs()) * Self::DOUBT + Self::SMALLEST;
        let (enter, leave) = (enter - doubt, leave + doubt);
        if !(enter.is_finite() && leave.is_finite()) {
            return Start::Everything;
        }
        if enter > leave {
            return Start::Miss;
        }
        let is_backward = direction.map(f64::is_sign_negative);
        let is_along_plane = direction.contains(&0.0);
        Start::Line(Self { origin, inverse, is_backward, enter, leave, most_doubt: doubt, is_along_plane })
    }

    /// Returns the error bound of this t at a plane.
    #[inline(always)]
    fn doubt(&self, t: f64) -> f64 {
        (t.abs() * Self::DOUBT + Self::SMALLEST).min(self.most_doubt)
    }

    /// Returns the children of a node that a ray may meet, given that it is in the node's cell from `enter` to `leave`.
    #[inline(always)]
    fn way(&self, plane: Plane, enter: f64, leave: f64) -> Way {
        let t = (f64::from(plane.at) - self.origin[plane.axis]) * self.inverse[plane.axis];
        let doubt = self.doubt(t);
        let (early, late) = (t - doubt, t + doubt);
        if early > leave {
            Way::Near
        } else if late < enter {
            Way::Far
        } else {
            // NaN gives way to the end of the node's interval.
            Way::Both(if late < leave { late } else { leave }, if early > enter { early } else { enter })
        }
    }

    /// Whether the nearest hit ends the ray, once it is done with a cell that it leaves at `leave`.
    ///
    /// Children that wait begin at the end of a nearer cell that holds this one, or up to twice the doubt there before. Only
    /// if the ray may run inside planes, neither child is the nearer one.
    #[inline(always)]
    fn is_over(&self, leave: f64, t_max: f64) -> bool {
        // The third doubt is more than the difference of the doubts at both ends.
        leave - 3.0 * self.doubt(leave) > t_max && !self.is_along_plane
    }

    /// The nearer of two children, and the other one.
    #[inline(always)]
    fn sort(&self, plane: Plane, [left, right]: [u32; 2]) -> [u32; 2] {
        if self.is_backward[plane.axis] { [right, left] } else { [left, right] }
    }
}

/// Tests the triangles of leaves; most are tested only once.
struct Tester<'a, Test> {
    within: Reachable<'a>,
    ray: &'a Ray,
    test: Test,
    t_max: f64,
    /// Triangles that the ray remembers to have tested (Kirk and Arvo, *Improved Ray Tagging for Voxel-Based Ray Tracing*,
    /// 1991).
    mailbox: [u32; MAILBOX],
    steps: Steps<'a>,
}

const MAILBOX: usize = 16;

impl<'a, Test: FnMut(u32, &mut f64) -> ControlFlow<()>> Tester<'a, Test> {
    fn new(within: Reachable<'a>, ray: &'a Ray, test: Test) -> Self {
        let mut steps = Steps::new(&within.tree.visits);
        steps.note(|visits| visits.rays += 1);
        Self { within, ray, test, t_max: ray.t_max, mailbox: [u32::MAX; MAILBOX], steps }
    }

    #[inline(always)]
    fn leaf(&mut self, leaf: Node) -> ControlFlow<()> {
        if leaf.is_deferred() { self.subtree(leaf) } else { self.ids(leaf.ids()) }
    }

    /// Visits the subtree in a leaf's place as a tree of its own, with a ray that ends at the nearest hit so far.
    #[cold]
    #[inline(never)]
    fn subtree(&mut self, leaf: Node) -> ControlFlow<()> {
        let tree = self.within.tree.reach(self.within.triangles, leaf.ids().start);
        let ray = Ray { t_max: self.t_max, ..*self.ray };
        let mut test = |id: u32, t_max: &mut f64| {
            (self.test)(id, &mut self.t_max)?;
            *t_max = self.t_max;
            ControlFlow::Continue(())
        };
        let test: &mut dyn FnMut(u32, &mut f64) -> ControlFlow<()> = &mut test;
        Reachable { tree, ..self.within }.visit(&ray, test)
    }

    #[inline(always)]
    fn ids(&mut self, ids: std::ops::Range<usize>) -> ControlFlow<()> {
        self.steps.note(|visits| visits.leaves += 1);
        for &id in &self.within.tree.ids[ids] {
            if std::mem::replace(&mut self.mailbox[id as usize % MAILBOX], id) != id {
                self.steps.note(|visits| visits.tests += 1);
                (self.test)(id, &mut self.t_max)?;
            }
        }
        ControlFlow::Continue(())
    }

    #[cold]
    fn everything(&mut self) -> ControlFlow<()> {
        self.ids(0..self.within.tree.ids.len())
    }
}
