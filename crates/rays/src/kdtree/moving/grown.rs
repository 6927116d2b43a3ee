//! Leading a ray through a tree whose triangles are no longer where they were when it was built: *at rest*.
//!
//! A ray hits a triangle now at P = o + t d, in real numbers. Let Q be the point of the triangle at rest with the same weights of
//! the corners. The caller knows for each node how far P, or the point that the ray handed over here has instead, may be from Q
//! along an axis, if the triangle is listed below that node: `away` and the node's own `drift`. A leaf that lists the triangle
//! holds Q in its cell, with its faces. So a ray finds the hit if it visits each child of which the cell, grown by as much as
//! the child says, holds the ray's point at t: at a plane s that is where the ray is before s + `away` + drift, and after
//! s − `away` − drift. A node's drift is no less than those below, so that intervals of t lie in each other.
//!
//! The three roundings of such a t are what a doubt of 2⁻⁴⁸ |t| pays for, as in `traverse`; those of s ±
//! `away` ± drift are up to the caller. A plane along the ray is at t = ±∞ from the side where the ray is, or not a number, which
//! leads to both.

use std::ops::{ControlFlow, Range};

use crate::kdtree::{Extent, Nodes, Plane};
use crate::{KdTree, Ray};

/// What a ray's traversal begins with.
pub(super) enum Start {
    /// The ray misses the box.
    Miss,
    /// Numbers so large or small that t can't be trusted: all triangles are tested.
    Everything,
    Line(Line),
}

/// A ray prepared for planes.
pub(super) struct Line {
    origin: [f64; 3],
    inverse: [f64; 3],
    is_backward: [bool; 3],
    /// Whether it runs along the axis' planes.
    is_along: [bool; 3],
    /// The interval of t in which the ray may hit.
    enter: f64,
    leave: f64,
    /// More than what t may be wrong by anywhere.
    most_doubt: f64,
    /// How far, by axis, the ray may be from where the triangle was, but for drift.
    away: [f64; 3],
}

impl Line {
    const DOUBT: f64 = 1.0 / (1_u64 << 48) as f64;
    /// More than what t may be wrong by where its last bits underflow.
    const SMALLEST: f64 = 1e-300;

    /// A ray in a box that holds all hits; nothing is grown yet.
    pub(super) fn start(extent: &Extent, ray: &Ray) -> Start {
        if extent.is_empty() {
            return Start::Miss;
        }
        let direction = ray.direction.to_array();
        let mut line = Self {
            origin: ray.origin.to_array(),
            inverse: direction.map(f64::recip),
            is_backward: direction.map(f64::is_sign_negative),
            is_along: direction.map(|along| along == 0.0),
            enter: ray.t_min,
            leave: ray.t_max,
            most_doubt: 0.0,
            away: [0.0; 3],
        };
        let can_be_trusted = line.clip(extent, 0.0);
        line.most_doubt = line.most() * Self::DOUBT + Self::SMALLEST;
        (line.enter, line.leave) = (line.enter - line.most_doubt, line.leave + line.most_doubt);
        if !(can_be_trusted && line.enter.is_finite() && line.leave.is_finite()) {
            return Start::Everything;
        }
        if line.enter > line.leave { Start::Miss } else { Start::Line(line) }
    }

    /// The same interval of a ray that is somewhere else.
    pub(super) fn with(self, origin: [f64; 3], direction: [f64; 3], away: [f64; 3]) -> Start {
        let is_finite = |numbers: [f64; 3]| numbers.into_iter().all(f64::is_finite);
        if !(is_finite(origin) && is_finite(direction) && is_finite(away)) {
            return Start::Everything;
        }
        Start::Line(Self {
            origin,
            inverse: direction.map(f64::recip),
            is_backward: direction.map(f64::is_sign_negative),
            is_along: direction.map(|along| along == 0.0),
            away,
            ..self
        })
    }

    /// The largest magnitude of t.
    pub(super) fn most(&self) -> f64 {
        self.enter.abs().max(self.leave.abs())
    }

    /// The first t at which the ray may be beyond a plane, and the last at which it may be before it, with drifts of what is
    /// before and beyond.
    #[inline(always)]
    fn reaches(&self, Plane { axis, at }: Plane, [before, beyond]: [f64; 2]) -> [f64; 2] {
        let (at, away) = (f64::from(at), self.away[axis]);
        let sign = if self.is_backward[axis] { -1.0 } else { 1.0 };
        let t = |by: f64| (at + sign * by - self.origin[axis]) * self.inverse[axis];
        let doubt = |t: f64| (t.abs() * Self::DOUBT + Self::SMALLEST).min(self.most_doubt);
        let (first, last) = (t(-(away + beyond)), t(away + before));
        [first - doubt(first), last + doubt(last)]
    }

    /// Leaves the part of the ray that may be inside a box; false where numbers can't be trusted.
    fn clip(&mut self, extent: &Extent, drift: f64) -> bool {
        for axis in 0..3 {
            let [low, high] = [extent.min[axis], extent.max[axis]];
            if self.is_along[axis] {
                let by = self.away[axis] + drift;
                if !(f64::from(low) - by..=f64::from(high) + by).contains(&self.origin[axis]) {
                    (self.enter, self.leave) = (0.0, -1.0);
                    return true;
                }
                continue;
            }
            let (entry, exit) = if self.is_backward[axis] { (high, low) } else { (low, high) };
            let [enter, _] = self.reaches(Plane { axis, at: entry }, [0.0, drift]);
            let [_, leave] = self.reaches(Plane { axis, at: exit }, [drift, 0.0]);
            if !(self.inverse[axis].is_finite() && enter.is_finite() && leave.is_finite()) {
                return false;
            }
            (self.enter, self.leave) = (self.enter.max(enter), self.leave.min(leave));
        }
        true
    }
}

const MAILBOX: usize = 16;

/// Calls `test` with every triangle of a leaf that a ray visits before its end, which is `t_max` at first, nearer leaves first.
/// `test` may lower that or break off. `drift` is of the node at an index.
pub(super) fn visit(
    tree: &KdTree,
    start: Start,
    mut t_max: f64,
    drift: impl Fn(u32) -> f64,
    mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    // Triangles that the ray remembers to have tested, as in `traverse`.
    let mut mailbox = [u32::MAX; MAILBOX];
    let mut leaf = |ids: Range<usize>, t_max: &mut f64| {
        tree.ids()[ids].iter().try_for_each(|&id| {
            let is_new = std::mem::replace(&mut mailbox[id as usize % MAILBOX], id) != id;
            if is_new { test(id, t_max) } else { ControlFlow::Continue(()) }
        })
    };
    let mut line = match start {
        Start::Miss => return ControlFlow::Continue(()),
        Start::Everything => return leaf(0..tree.ids().len(), &mut t_max),
        Start::Line(line) => line,
    };
    let (nodes, extent) = (tree.nodes(), tree.extent());
    if extent.is_empty() {
        return ControlFlow::Continue(());
    }
    if !line.clip(&extent, drift(0)) {
        return leaf(0..tree.ids().len(), &mut t_max);
    }
    if line.enter > line.leave {
        return ControlFlow::Continue(());
    }
    let mut stack = [(0, 0.0, 0.0); Nodes::MAX_DEPTH];
    let mut waiting = 0;
    let (mut index, mut enter, mut leave) = (0, line.enter, line.leave);
    loop {
        let node = nodes.get(index);
        if node.is_leaf() {
            leaf(node.ids(), &mut t_max)?;
            loop {
                if waiting == 0 {
                    return ControlFlow::Continue(());
                }
                waiting -= 1;
                if stack[waiting].1 <= t_max {
                    break;
                }
            }
            (index, enter, leave) = stack[waiting];
            continue;
        }
        let plane = node.plane();
        let [left, right] = nodes.children(index, node);
        let [near, far] = if line.is_backward[plane.axis] { [right, left] } else { [left, right] };
        let [first, last] = line.reaches(plane, [drift(near), drift(far)]);
        if first > leave {
            (index, leave) = (near, if last < leave { last } else { leave });
        } else if last < enter {
            (index, enter) = (far, if first > enter { first } else { enter });
        } else {
            // A value that isn't a number leaves nothing out.
            stack[waiting] = (far, if first > enter { first } else { enter }, leave);
            waiting += 1;
            (index, leave) = (near, if last < leave { last } else { leave });
        }
    }
}
