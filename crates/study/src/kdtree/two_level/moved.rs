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
//! and E the largest coordinate of the tree: the last term pays for the rounding of s ± away for a plane s. How that leads to
//! all leaves it must is told in `grown`.

use std::ops::ControlFlow;

use glam::{DAffine3, DVec3, Vec3};

use umbrage_rays::internals::Extent;
use umbrage_rays::{KdTree, Ray, Triangles};

use crate::kdtree::grown::{self, Line, Start};

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
    /// More than what coordinates may be wrong by where their last bits underflow.
    const SMALLEST: f64 = 1e-300;

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

    /// Where all vertices were, by the frame's vertex index; those of other objects are nowhere.
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
    /// or break off. `extent` is the object's box now.
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
