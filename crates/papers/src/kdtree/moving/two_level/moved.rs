//! Leads a ray through the tree of an object that has moved since its tree was built.
//!
//! **Why no hit is missed.** Let B be the affine map, with its f64 coefficients, from the object's place now to that when
//! its tree was built: *at rest*. Each vertex has a box there, which the tree is built for: its point at rest, or for trees
//! over boxes a larger one; a triangle's box is around those of its corners. The way of finding and rounding B doesn't
//! matter, since mapped vertices are compared with their boxes: for a vertex now at w, B w is along each axis outside of its
//! box by no more than *drift*. A ray that hits a triangle now at P = o + t d, in real numbers, is at B P = B o + t B d for
//! the same t after B. P is a mean of corners, and B P the mean of the mapped corners with the same weights: no farther than
//! the drift from a point Q that is the mean, with those weights, of points of the corners' boxes. So Q is a point of the
//! triangle at rest, or of its box. One of the leaves that list it holds Q in its cell, with its faces, since these leaves
//! cover it.
//!
//! Products with B, computed in f64, have at most three products and three sums: each coordinate has an error of less than
//! 4.01 · 2⁻⁵³ of the sum S of the magnitudes of its terms. 2⁻⁵⁰ S is about twice as much and covers the rounding of S too.
//! So the computed ray is at t no farther from Q along an axis than
//!
//! > *away* = drift + 2⁻⁵⁰ (S(o) + M S(d)) + 2⁻⁵⁰ E
//!
//! where M is the largest magnitude of t for which the ray is in the object's box in world space, as it is at every hit, and
//! E the largest coordinate of the tree: the last term covers the rounding of s ± away for a plane s. `grown` shows that a
//! ray so reaches all leaves that it must.

use std::ops::ControlFlow;

use glam::{DAffine3, DVec3};

use crate::KdTree;
use crate::kdtree::Extent;
use crate::kdtree::moving::grown::{self, Line, Start};
use umbrage_rays::Ray;

/// Twice the error bound of a coordinate after an affine map, for each unit of its terms' magnitudes.
pub(super) const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

/// The map of rays to the tree of an object that has moved.
pub(super) struct Moved {
    /// B, and the magnitudes of its coefficients.
    pub(super) rest_from_world: DAffine3,
    pub(super) magnitudes: DAffine3,
    /// The largest distance of mapped vertices from their boxes, along each axis.
    pub(super) drift: DVec3,
}

/// An affine map of the magnitudes of another's coefficients.
pub(super) fn magnitudes(map: DAffine3) -> DAffine3 {
    let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::abs);
    DAffine3::from_cols(x, y, z, map.translation.abs())
}

impl Moved {
    /// Error bound of coordinates whose last bits underflow.
    const SMALLEST: f64 = 1e-300;

    /// Calls `test` with every triangle of a leaf that `ray` visits before its end, nearer leaves first. `test` may
    /// lower that or break off. `extent` is the object's box now.
    pub(super) fn visit(
        &self,
        tree: &KdTree,
        extent: &Extent,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let start = match Line::start(extent, ray) {
            Start::Line(line) => {
                let terms = self.magnitudes.transform_point3(ray.origin.abs())
                    + self.magnitudes.transform_vector3(ray.direction.abs()) * line.most();
                let away = self.drift + (terms + f64::from(tree.extent().reach())) * ROUNDING + Self::SMALLEST;
                let origin = self.rest_from_world.transform_point3(ray.origin);
                let direction = self.rest_from_world.transform_vector3(ray.direction);
                line.with(origin.to_array(), direction.to_array(), away.to_array())
            }
            other => other,
        };
        grown::visit(tree, start, ray.t_max, |_| 0.0, test)
    }
}
