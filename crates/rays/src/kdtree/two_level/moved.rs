//! Leading a ray through the tree of an object that was built where the object was before.
//!
//! **Why nothing is missed.** Let B be the affine map, with the f64 coefficients that it has, from where the object is now to
//! where it was when its tree was built: *at rest*. How B was rounded doesn't matter, since what it makes of the vertices
//! is compared with where they were: for a vertex now at w that was at r, along each axis |B w − r| ≤ *drift*. A ray that hits
//! a triangle now at P = o + t d, in real numbers, is at B P = B o + t B d for the same t after B; P is a mean of corners, B P
//! the mean of their maps with the same weights, and so no farther than the drift from the point Q of the triangle at rest
//! that has those weights. A leaf that lists the triangle holds Q in its cell, with its faces.
//!
//! Products with B, computed in f64, have at most three products and three sums: each coordinate is wrong by less than
//! 4.01 · 2⁻⁵³ of the sum S of the magnitudes of its terms. 2⁻⁵⁰ S is about twice as much and covers that S is rounded too. So the
//! computed ray is at t no farther from Q along an axis than
//!
//! > *away* = drift + 2⁻⁵⁰ (S(o) + M S(d)) + 2⁻⁵⁰ E
//!
//! where M is the largest magnitude of t for which the ray is in the object's box in world space, which every hit is,
//! and E the largest coordinate of the tree: the last term pays for the rounding of s ± away for a plane s. A ray visits a
//! child if it comes within `away` of the child's side of the plane, and t is otherwise computed and grown as in
//! `traverse`: three relative roundings, which a doubt of 2⁻⁴⁸ M more than covers. A plane along the ray is at t = ±∞ from the side
//! where the ray is, or not a number, which leads to both.

use std::ops::{ControlFlow, Range};

use glam::{DAffine3, DVec3, Vec3};

use super::KdTree;
use crate::kdtree::extent::{Extent, Plane};
use crate::kdtree::node::Nodes;
use crate::{Ray, Triangles};

/// Twice what a coordinate after an affine map may be wrong by, for each unit of its terms' magnitudes.
const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

/// Trees are kept while vertices are no farther from where they should be, in parts of the object's size.
const MOST_DRIFT: f64 = 1.0 / (1 << 12) as f64;

/// Where a rigid object was when its tree was built, and how it came to where it is.
pub(super) struct Rest {
    /// The object's vertices, ascending.
    vertices: Vec<u32>,
    /// Where they were.
    positions: Vec<Vec3>,
    /// Triangles that no ray could hit.
    omitted: Vec<u32>,
    world_from_object: DAffine3,
    /// B, and the magnitudes of its coefficients.
    rest_from_world: DAffine3,
    magnitudes: DAffine3,
    /// How far B leaves vertices from where they were, along each axis.
    drift: DVec3,
}

/// An affine map of the magnitudes of another's coefficients.
fn magnitudes(map: DAffine3) -> DAffine3 {
    let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::abs);
    DAffine3::from_cols(x, y, z, map.translation.abs())
}

impl Rest {
    /// An object as it is now, where its tree is built.
    pub(super) fn new(triangles: Triangles<'_>, world_from_object: DAffine3) -> Self {
        let in_range = |&vertex: &u32| (vertex as usize) < triangles.positions.len();
        let mut vertices: Vec<_> = triangles.indices.iter().flatten().copied().filter(in_range).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let positions = vertices.iter().map(|&vertex| triangles.positions[vertex as usize]).collect();
        let ids = 0..triangles.len() as u32;
        Self {
            vertices,
            positions,
            omitted: ids.filter(|&id| triangles.usable_corners(id).is_err()).collect(),
            world_from_object,
            rest_from_world: DAffine3::IDENTITY,
            magnitudes: DAffine3::IDENTITY,
            drift: DVec3::ZERO,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        (self.vertices.capacity() + self.omitted.capacity()) * size_of::<u32>()
            + self.positions.capacity() * size_of::<Vec3>()
    }

    /// Where all vertices were, in places that the frame has for them; those of other objects are nowhere.
    pub(super) fn all_positions(&self) -> Vec<Vec3> {
        let mut positions = vec![Vec3::NAN; self.vertices.last().map_or(0, |&last| last as usize + 1)];
        self.vertices.iter().zip(&self.positions).for_each(|(&vertex, &at)| positions[vertex as usize] = at);
        positions
    }

    /// Measures where the object is now, with a tree of this extent; its box, or nothing if the tree can't serve.
    pub(super) fn follow(
        &mut self,
        triangles: Triangles<'_>,
        world_from_object: DAffine3,
        at_rest: &Extent,
    ) -> Option<Extent> {
        if self.vertices.last().is_some_and(|&last| last as usize >= triangles.positions.len()) {
            return None;
        }
        // What no ray could hit isn't in the tree.
        if self.omitted.iter().any(|&id| triangles.usable_corners(id).is_ok()) {
            return None;
        }
        let rest_from_world = self.world_from_object * world_from_object.inverse();
        if !rest_from_world.is_finite() {
            return None;
        }
        let sizes = magnitudes(rest_from_world);
        let mut drift = DVec3::ZERO;
        let mut extent = Extent::EMPTY;
        for (&vertex, rest) in self.vertices.iter().zip(&self.positions) {
            let now = triangles.positions[vertex as usize];
            if !(now.is_finite() && rest.is_finite()) {
                // Triangles with such a vertex aren't listed, and still mustn't be, or else they must leave the tree.
                if now.is_finite() == rest.is_finite() { continue } else { return None }
            }
            extent = extent.union(Extent::around([now]));
            let (now, rest) = (now.as_dvec3(), rest.as_dvec3());
            let rounding = (sizes.transform_point3(now.abs()) + rest.abs()) * ROUNDING;
            drift = drift.max((rest_from_world.transform_point3(now) - rest).abs() + rounding);
        }
        let size = (0..3).map(|axis| f64::from(at_rest.max[axis]) - f64::from(at_rest.min[axis])).fold(0.0, f64::max);
        // Not so where anything isn't a number.
        if !(drift.max_element() <= size * MOST_DRIFT && drift.is_finite()) {
            return None;
        }
        (self.rest_from_world, self.magnitudes, self.drift) = (rest_from_world, sizes, drift);
        Some(extent)
    }

    /// Calls `test` with every triangle of a leaf that `ray` visits before its end, nearer leaves first. `test` may lower that
    /// or break off.
    pub(super) fn visit(
        &self,
        tree: &KdTree,
        extent: &Extent,
        ray: &Ray,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut t_max = ray.t_max;
        let mut leaf = |ids: Range<usize>, t_max: &mut f64| tree.ids[ids].iter().try_for_each(|&id| test(id, t_max));
        let line = match MovedLine::start(self, tree, extent, ray) {
            Start::Miss => return ControlFlow::Continue(()),
            Start::Everything => return leaf(0..tree.ids.len(), &mut t_max),
            Start::Line(line) => line,
        };
        let mut stack = [(0, 0.0, 0.0); Nodes::MAX_DEPTH];
        let mut waiting = 0;
        let (mut place, mut enter, mut leave) = (0, line.enter, line.leave);
        loop {
            let node = tree.nodes.get(place);
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
                (place, enter, leave) = stack[waiting];
                continue;
            }
            let plane = node.plane();
            let [left, right] = tree.nodes.children(place, node);
            let [near, far] = if line.is_backward[plane.axis] { [right, left] } else { [left, right] };
            let [first, last] = line.reaches(plane);
            if first > leave {
                place = near;
            } else if last < enter {
                place = far;
            } else {
                // What isn't a number gives way.
                stack[waiting] = (far, if first > enter { first } else { enter }, leave);
                waiting += 1;
                (place, leave) = (near, if last < leave { last } else { leave });
            }
        }
    }
}

enum Start {
    Miss,
    /// Numbers so large or small that t can't be trusted: all triangles are tested.
    Everything,
    Line(MovedLine),
}

/// A ray prepared for planes of a tree at rest.
struct MovedLine {
    origin: [f64; 3],
    inverse: [f64; 3],
    is_backward: [bool; 3],
    /// Whether it runs along the axis' planes.
    is_along: [bool; 3],
    /// The interval of t in which the ray may be inside the object.
    enter: f64,
    leave: f64,
    doubt: f64,
    /// How far, by axis, the ray may be from where it hits the triangle at rest.
    away: [f64; 3],
}

impl MovedLine {
    const DOUBT: f64 = 1.0 / (1_u64 << 48) as f64;
    /// More than what t may be wrong by where its last bits underflow.
    const SMALLEST: f64 = 1e-300;

    fn start(rest: &Rest, tree: &KdTree, extent: &Extent, ray: &Ray) -> Start {
        if tree.extent.is_empty() || extent.is_empty() {
            return Start::Miss;
        }
        // In world space, where boxes are exact.
        let mut world = Self::new(ray.origin, ray.direction, ray.t_min, ray.t_max, [0.0; 3]);
        let clipped = world.clip(extent);
        world.doubt = world.enter.abs().max(world.leave.abs()) * Self::DOUBT + Self::SMALLEST;
        let (enter, leave) = (world.enter - world.doubt, world.leave + world.doubt);
        if !(clipped && enter.is_finite() && leave.is_finite()) {
            return Start::Everything;
        }
        if enter > leave {
            return Start::Miss;
        }
        let most = enter.abs().max(leave.abs());
        let terms = rest.magnitudes.transform_point3(ray.origin.abs())
            + rest.magnitudes.transform_vector3(ray.direction.abs()) * most;
        let reach = tree.extent.min.iter().chain(&tree.extent.max).fold(0.0_f32, |reach, face| reach.max(face.abs()));
        let away = (rest.drift + terms * ROUNDING + f64::from(reach) * ROUNDING) + Self::SMALLEST;
        let origin = rest.rest_from_world.transform_point3(ray.origin);
        let direction = rest.rest_from_world.transform_vector3(ray.direction);
        if !(away.is_finite() && origin.is_finite() && direction.is_finite()) {
            return Start::Everything;
        }
        let mut line = Self { doubt: world.doubt, ..Self::new(origin, direction, enter, leave, away.to_array()) };
        if !line.clip(&tree.extent) {
            return Start::Everything;
        }
        if line.enter > line.leave { Start::Miss } else { Start::Line(line) }
    }

    fn new(origin: DVec3, direction: DVec3, enter: f64, leave: f64, away: [f64; 3]) -> Self {
        let direction = direction.to_array();
        let (inverse, is_backward) = (direction.map(f64::recip), direction.map(f64::is_sign_negative));
        let is_along = direction.map(|along| along == 0.0);
        Self { origin: origin.to_array(), inverse, is_backward, is_along, enter, leave, doubt: 0.0, away }
    }

    /// The first t at which the ray may be on the farther side of a plane, and the last at which it may be on the nearer one.
    #[inline(always)]
    fn reaches(&self, Plane { axis, at }: Plane) -> [f64; 2] {
        let (at, away) = (f64::from(at), self.away[axis]);
        let (near, far) = if self.is_backward[axis] { (at + away, at - away) } else { (at - away, at + away) };
        let t = |at: f64| (at - self.origin[axis]) * self.inverse[axis];
        [t(near) - self.doubt, t(far) + self.doubt]
    }

    /// Leaves the part of the ray that may be inside a box; false where numbers can't be trusted.
    fn clip(&mut self, extent: &Extent) -> bool {
        for axis in 0..3 {
            let [low, high] = [extent.min[axis], extent.max[axis]];
            if self.is_along[axis] {
                let [low, high] = [f64::from(low) - self.away[axis], f64::from(high) + self.away[axis]];
                if !(low..=high).contains(&self.origin[axis]) {
                    (self.enter, self.leave) = (0.0, -1.0);
                    return true;
                }
                continue;
            }
            let (entry, exit) = if self.is_backward[axis] { (high, low) } else { (low, high) };
            let [enter, _] = self.reaches(Plane { axis, at: entry });
            let [_, leave] = self.reaches(Plane { axis, at: exit });
            if !(self.inverse[axis].is_finite() && enter.is_finite() && leave.is_finite()) {
                return false;
            }
            (self.enter, self.leave) = (self.enter.max(enter), self.leave.min(leave));
        }
        true
    }
}
