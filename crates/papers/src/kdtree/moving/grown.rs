//! Leads a ray through a tree whose triangles have moved since it was built, when they were *at rest*.
//!
//! A ray hits a triangle now at P = o + t d, in real numbers. Let Q be the point of the triangle at rest with the same
//! weights of the corners. If the triangle is listed below a node, P is at most `away` plus the node's own `drift` from Q
//! along each axis; for a ray that was moved, so is that ray's point at t instead of P. A leaf that lists the triangle holds
//! Q in its cell, with its faces. So a ray finds the hit if it visits each child whose cell, grown by `away` plus the
//! child's drift, holds the ray's point at t. At a plane s, that is while the ray is before s + `away` + drift, or once it
//! is after s − `away` − drift. A node's drift is no less than those below, so intervals of t are nested.
//!
//! A doubt of 2⁻⁴⁸ |t| covers the three roundings of such a t, as in `traverse`; the caller covers those of s ± `away` ±
//! drift. A plane along the ray is at t = ±∞, with the sign that leads to the ray's side, or at NaN, which leads to both
//! sides.

use std::ops::{ControlFlow, Range};

use crate::KdTree;
use crate::kdtree::{Extent, Nodes, Plane};
use umbrage_rays::Ray;

/// The start of a ray's traversal.
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
    /// Whether it is parallel to the planes across the axis.
    is_along: [bool; 3],
    /// The interval of t in which the ray may hit.
    enter: f64,
    leave: f64,
    /// Error bound of any t on the ray.
    most_doubt: f64,
    /// The largest distance between the ray and the triangle at rest, without drift, by axis.
    away: [f64; 3],
}

impl Line {
    const DOUBT: f64 = 1.0 / (1_u64 << 48) as f64;
    /// Error bound of a t whose last bits underflow.
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

    /// Returns the start of another ray with the same interval of t.
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

    /// Returns the first t at which the ray may be beyond a plane, and the last at which it may be before it, with the
    /// drifts of the nodes before and beyond.
    #[inline(always)]
    fn reaches(&self, Plane { axis, at }: Plane, [before, beyond]: [f64; 2]) -> [f64; 2] {
        let (at, away) = (f64::from(at), self.away[axis]);
        let sign = if self.is_backward[axis] { -1.0 } else { 1.0 };
        let t = |by: f64| (at + sign * by - self.origin[axis]) * self.inverse[axis];
        let doubt = |t: f64| (t.abs() * Self::DOUBT + Self::SMALLEST).min(self.most_doubt);
        let (first, last) = (t(-(away + beyond)), t(away + before));
        [first - doubt(first), last + doubt(last)]
    }

    /// Restricts the ray to the part that may be inside a box; false if t can't be trusted.
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

/// Calls `test` with every triangle of a leaf that a ray visits before its end, which is `t_max` at first, nearer leaves
/// first. `test` may lower that or break off. `drift` returns the drift of the node at an index.
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
            // NaN rules nothing out.
            stack[waiting] = (far, if first > enter { first } else { enter }, leave);
            waiting += 1;
            (index, leave) = (near, if last < leave { last } else { leave });
        }
    }
}
