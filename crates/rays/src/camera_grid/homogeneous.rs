//! Triangles that f32 can't set up: edge functions and depth in f64, and rounded to f32 relative to a point.

use glam::{DVec2, DVec3, Vec3};

use super::lanes::LANES;
use super::pixel_space::{HALF_ULP, PixelSpace};
use super::samples::BLOCKS;
use super::tile::TriangleBatch;
use crate::edge_functions::EdgeFunctions;
use crate::shot::TileOrder;

/// A triangle with its `EdgeFunctions` in f64, of homogeneous pixel coordinates: for triangles that reach behind the eye,
/// slivers and alpha masks.
#[derive(Clone, Copy, Debug)]
pub struct HomogeneousTriangle {
    /// Coefficients of each edge function for x, y and one. Positive inside where `oriented`.
    pub(crate) edges: [DVec3; 3],
    /// Error bound of each edge function at any sample.
    pub(crate) bounds: [f64; 3],
    /// Whether the edge functions' common sign at a hit is certain: a sample with one below zero is missed.
    pub(crate) oriented: bool,
    pub depth: Depth,
    /// Lowest and highest x, and y, of pixels whose samples may be hit.
    limits: [[f64; 2]; 2],
    /// Largest distance along an axis between a sample and its pixel.
    pub shift: f64,
}

/// A general triangle's depth as a function of the sample.
#[derive(Clone, Copy, Debug)]
pub enum Depth {
    /// Unknown, since too little is certain.
    Unknown,
    /// One over the depth is linear: perspective views.
    Inverse {
        /// Coefficients for x, y and one.
        plane: DVec3,
        /// Error bound of the result.
        error: f64,
    },
    /// The depth itself is linear: orthographic views.
    Direct {
        /// Coefficients for x, y and one.
        plane: DVec3,
        /// Error bound of the result.
        error: f64,
    },
}

/// Pixels in a square part of pixel space.
#[derive(Clone, Copy, Debug)]
pub struct Square {
    /// The leftmost column.
    pub x: i32,
    /// The uppermost row.
    pub y: i32,
    /// Pixels a side.
    pub side: i32,
}

impl HomogeneousTriangle {
    pub fn new(space: &PixelSpace, corners: [Vec3; 3]) -> Self {
        let points = corners.map(|corner| space.camera_point(corner));
        let is_perspective = space.is_perspective();
        let [a, b, c] = points.map(|(point, _)| {
            let DVec2 { x, y } = space.axis_pixels;
            let weight = if is_perspective { point.z } else { 1.0 };
            DVec3::new(space.scale * point.x + x * weight, -space.scale * point.y + y * weight, weight)
        });
        let functions = EdgeFunctions::new([a, b, c]);
        let mut edges = functions.edges;
        // In an orthographic view the weight of each vertex is exactly one, and stands for r in the bound if r is below one.
        // Rays start at points that are rounded in proportion to the eye's position.
        let reach = points.map(|(_, reach)| if is_perspective { reach } else { reach.max(space.eye_reach()).max(1.0) });
        let edge_error = space.edge_error;
        let bounds = [reach[1] * reach[2], reach[2] * reach[0], reach[0] * reach[1]].map(|reach| edge_error * reach);

        // The determinant is the sum of all Eᵢ zᵢ. Its error is that of an edge function with a third vertex instead of the
        // sample: 2 T r for T, doubled.
        let (constant, constant_error) = if is_perspective {
            (functions.determinant, 4.0 * edge_error * reach[0] * reach[1] * reach[2])
        } else {
            (edges[0].z + edges[1].z + edges[2].z, bounds[0] + bounds[1] + bounds[2])
        };
        let oriented = constant.abs() > 4.0 * constant_error;
        if oriented && constant < 0.0 {
            edges = edges.map(|edge| -edge);
        }
        let functions = EdgeFunctions { determinant: constant, ..functions };
        let constant = constant.abs();
        let relative_error = constant_error / constant;
        let depth = if !oriented {
            Depth::Unknown
        } else if is_perspective {
            let plane = functions.through([1.0; 3]);
            let error = (bounds[0] + bounds[1] + bounds[2]) / constant;
            Depth::linear(space, plane, error, relative_error, |plane, error| Depth::Inverse { plane, error })
        } else {
            let plane = functions.through(points.map(|(point, _)| point.z));
            // Twice: once for the edge functions, once for the depths, whose error is at most 2⁻⁴⁵ r.
            let error = 2.0 * (bounds[0] * reach[0] + bounds[1] * reach[1] + bounds[2] * reach[2]) * 2.0 / constant;
            Depth::linear(space, plane, error, relative_error, |plane, error| Depth::Direct { plane, error })
        };
        let shift = f64::from(space.shifts.reach());
        let limits = if is_perspective { limits(space, [a, b, c], reach) } else { NO_LIMITS };
        let limits = limits.map(|[low, high]| [low - shift, high + shift]);
        Self { edges, bounds, oriented, depth, limits, shift }
    }

    /// Lowest and highest x, and y, of pixels whose samples may be hit, in pixel space.
    pub(crate) fn limits(&self) -> [[f64; 2]; 2] {
        self.limits
    }

    /// Whether certainly no ray of `square` hits the triangle.
    pub fn misses(&self, square: Square) -> bool {
        let half = 0.5 * f64::from(square.side - 1);
        let center = DVec3::new(f64::from(square.x) + half, f64::from(square.y) + half, 1.0);
        let beyond = |axis: usize| {
            let [low, high] = self.limits[axis];
            center[axis] + half < low || center[axis] - half > high
        };
        if beyond(0) || beyond(1) {
            return true;
        }
        let (mut positive, mut negative) = (self.oriented, false);
        for (edge, &bound) in self.edges.iter().zip(&self.bounds) {
            let middle = edge.dot(center);
            let reach = (half + self.shift) * (edge.x.abs() + edge.y.abs()) + 2.0 * bound;
            positive |= middle > reach;
            negative |= middle < -reach;
        }
        positive && negative
    }
}

/// Calls `check` with the column and row of each pixel that a triangle doesn't certainly miss, until it fails.
///
/// # Errors
/// The first error of `check`.
pub fn check_pixels(
    space: &PixelSpace,
    triangle: &HomogeneousTriangle,
    square: Square,
    check: &dyn Fn(u32, u32) -> Result<(), String>,
) -> Result<(), String> {
    let (x, y) = ((square.x + space.middle.x) as u32, (square.y + space.middle.y) as u32);
    let (width, height) = space.size();
    if x >= width || y >= height || triangle.misses(square) {
        Ok(())
    } else if square.side > 1 {
        square.quarters().into_iter().try_for_each(|quarter| check_pixels(space, triangle, quarter, check))
    } else {
        check(x, y)
    }
}

const NO_LIMITS: [[f64; 2]; 2] = [[f64::NEG_INFINITY, f64::INFINITY]; 2];

/// The bounds of three homogeneous vertices, given the largest coordinate r of each. If a vertex isn't well in front of the
/// eye there are no bounds, except empty ones if all three are beyond one side of the image.
///
/// With the errors at [`PixelSpace`]'s edge functions, x/z is wrong by (T + |x/z|) 2⁻⁴⁴ r/z, and samples by
/// T (1 + x/z + y/z) 2⁻⁴⁸.
fn limits(space: &PixelSpace, vertices: [DVec3; 3], reaches: [f64; 3]) -> [[f64; 2]; 2] {
    const FRONT: f64 = 1.0 / (1 << 30) as f64;
    let mut limits = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for (vertex, reach) in vertices.into_iter().zip(reaches) {
        let in_front = vertex.z > FRONT * reach;
        if !in_front {
            return if are_outside(space, vertices, reaches) {
                [[f64::INFINITY, f64::NEG_INFINITY]; 2]
            } else {
                NO_LIMITS
            };
        }
        for (axis, [low, high]) in limits.iter_mut().enumerate() {
            let at = vertex[axis] / vertex.z;
            let error = space.edge_error / space.extent * (1.0 + at.abs() / space.extent) * (reach / vertex.z);
            // Infinite or NaN errors give infinite limits.
            let error = if error.is_finite() { error } else { f64::INFINITY };
            (*low, *high) = (low.min(at - error), high.max(at + error));
        }
    }
    limits
}

/// Whether three homogeneous vertices are certainly all behind the eye, or all beyond one side of the image.
///
/// A sample at x is hit at a point (x z, z) with z > 0, which lies between the vertices. So it isn't hit if all vertices
/// have a first coordinate above that of the last sample at their z. The error is that of [`limits`] times z, at |x| ≤ T.
fn are_outside(space: &PixelSpace, vertices: [DVec3; 3], reach: [f64; 3]) -> bool {
    let (width, height) = space.size();
    let relative_error = 2.0 * space.edge_error / space.extent;
    let all = |beyond: &dyn Fn(DVec3) -> f64| {
        vertices.iter().zip(reach).all(|(&vertex, reach)| beyond(vertex) > relative_error * reach)
    };
    let beyond_sides = |axis: usize, middle: i32, side: u32| {
        let shift = f64::from(space.shifts.reach());
        let (first, last) = (-f64::from(middle) - shift, f64::from(side) - 1.0 - f64::from(middle) + shift);
        all(&|vertex| first * vertex.z - vertex[axis]) || all(&|vertex| vertex[axis] - last * vertex.z)
    };
    all(&|vertex| -vertex.z) || beyond_sides(0, space.middle.x, width) || beyond_sides(1, space.middle.y, height)
}

impl Depth {
    /// Bounds of one over the depth, given its plane's value at a sample; `None` where the depth is certainly negative.
    #[inline(always)]
    pub(crate) fn inverse_bounds(&self, value: f64) -> Option<(f32, f32)> {
        let (low, high) = match *self {
            Self::Inverse { error, .. } if value.is_finite() => (value - error, value + error),
            Self::Direct { error, .. } if value > error => (1.0 / (value + error), 1.0 / (value - error)),
            Self::Direct { error, .. } if value < -error => return None,
            Self::Unknown | Self::Inverse { .. } | Self::Direct { .. } => (0.0, f64::INFINITY),
        };
        // The next f32 covers the f64 roundings above and the one to f32.
        Some(((low as f32).next_down(), (high as f32).next_up()))
    }

    /// Calls `make` with a plane and its error bound, given the error bound of the numerator and the relative error of the
    /// denominator.
    fn linear(
        space: &PixelSpace,
        plane: DVec3,
        error: f64,
        relative_error: f64,
        make: impl FnOnce(DVec3, f64) -> Self,
    ) -> Self {
        let (width, height) = space.size();
        let largest = plane.x.abs() * f64::from(width) + plane.y.abs() * f64::from(height) + plane.z.abs();
        // Eight roundings between the edge functions and the result; doubled for the bound's own and for a relative error of
        // the denominator of at most a quarter.
        make(plane, 2.0 * (error + largest * (relative_error + 8.0 * f64::EPSILON)))
    }
}

impl Square {
    /// The smallest square with the image's first pixel in its corner that holds the image. Its side is a power of two, and
    /// at least a tile's.
    pub fn around_image(space: &PixelSpace) -> Self {
        let (width, height) = space.size();
        let side = width.max(height).max(TileOrder::TILE).next_power_of_two() as i32;
        Self { x: -space.middle.x, y: -space.middle.y, side }
    }

    /// The four quarters of a square with an even side.
    pub fn quarters(self) -> [Self; 4] {
        let side = self.side / 2;
        [(0, 0), (side, 0), (0, side), (side, side)].map(|(x, y)| Self { x: self.x + x, y: self.y + y, side })
    }
}

/// One triangle's edge functions and inverse depth in f32, as linear functions of x and y relative to an origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearTriangle {
    /// Factor of x of each edge function; positive edge functions are inside.
    pub(crate) a: [f32; 3],
    /// Factor of y.
    pub(crate) b: [f32; 3],
    /// Constant.
    pub(crate) c: [f32; 3],
    /// Error bound of an edge function.
    pub(crate) bound: f32,
    /// One over the depth at the origin.
    pub(crate) inverse_depth: f32,
    /// Its change per pixel to the right and downwards.
    pub(crate) gradient: [f32; 2],
    pub(crate) depth_error: f32,
    /// Upper bound of the inverse depth.
    pub(crate) nearest: f32,
}

impl HomogeneousTriangle {
    /// The triangle relative to (`x`, `y`) in pixel space, for samples at most `reach` from there along each axis; `None`
    /// where its orientation isn't certain or f32 can't hold it.
    ///
    /// Each edge function is divided by its error, so that its error becomes one. Coefficients are rounded once, and
    /// evaluation adds a rounding of each product and two of sums: four on a path, taken as six.
    pub(crate) fn linear(&self, [x, y]: [f64; 2], reach: f64) -> Option<LinearTriangle> {
        let Depth::Inverse { plane, error } = self.depth else { return None };
        if !self.oriented {
            return None;
        }
        const ROUNDINGS: f64 = 6.0 * HALF_ULP as f64;
        let middle = DVec3::new(x, y, 1.0);
        let (mut a, mut b, mut c) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for (edge, (&coefficients, &bound)) in self.edges.iter().zip(&self.bounds).enumerate() {
            let constant = coefficients.dot(middle);
            let largest = reach * (coefficients.x.abs() + coefficients.y.abs()) + constant.abs();
            let scale = (bound + ROUNDINGS * largest).recip();
            // Beyond this, sums in f32 could overflow; it also excludes NaN.
            if !(largest * scale < 1e30 && scale.is_normal()) {
                return None;
            }
            a[edge] = (coefficients.x * scale) as f32;
            b[edge] = (coefficients.y * scale) as f32;
            c[edge] = (constant * scale) as f32;
        }
        let inverse_depth = plane.dot(middle);
        let largest = inverse_depth.abs() + reach * (plane.x.abs() + plane.y.abs());
        let error = error + ROUNDINGS * largest;
        if !(largest < 1e24 && error > 1e-24) {
            return None;
        }
        Some(LinearTriangle {
            a,
            b,
            c,
            bound: 1.0,
            inverse_depth: inverse_depth as f32,
            gradient: [plane.x as f32, plane.y as f32],
            depth_error: (error as f32).next_up(),
            nearest: ((largest + error) as f32).next_up(),
        })
    }
}

impl TriangleBatch {
    /// The triangle in a lane.
    pub(crate) fn linear(&self, lane: usize) -> LinearTriangle {
        let lane = lane % LANES;
        LinearTriangle {
            a: self.a.map(|factors| factors[lane]),
            b: self.b.map(|factors| factors[lane]),
            c: self.c.map(|constants| constants[lane]),
            bound: self.bound[lane],
            inverse_depth: self.inverse_depth[lane],
            gradient: self.gradient.map(|slopes| slopes[lane]),
            depth_error: self.depth_error[lane],
            nearest: self.nearest[lane],
        }
    }

    /// Sets a lane to a triangle of the general path, which may be in any block.
    pub(crate) fn set(&mut self, lane: usize, linear: &LinearTriangle, id: u32) {
        let lane = lane % LANES;
        for edge in 0..3 {
            (self.a[edge][lane], self.b[edge][lane], self.c[edge][lane]) =
                (linear.a[edge], linear.b[edge], linear.c[edge]);
        }
        self.bound[lane] = linear.bound;
        self.inverse_depth[lane] = linear.inverse_depth;
        (self.gradient[0][lane], self.gradient[1][lane]) = (linear.gradient[0], linear.gradient[1]);
        self.depth_error[lane] = linear.depth_error;
        self.nearest[lane] = linear.nearest;
        self.ids[lane] = id;
        for (bounds, block) in self.blocks.iter_mut().zip([0, BLOCKS - 1, 0, BLOCKS - 1]) {
            bounds[lane] = block as i32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predicate::crossing;
    use crate::random::Random;
    use crate::shot::{Shifts, Shot};
    use crate::{Camera, Projection, Triangles, View};

    #[test]
    fn nothing_is_hit_in_squares_that_are_missed() {
        let camera = Camera::look_at(Vec3::new(0.3, -0.2, 2.0), Vec3::ZERO, Vec3::Y, 0.9);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.0 }, ..camera };
        let shifts = [(-0.5, 0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, -0.5)].map(DVec2::from);
        let mut random = Random::new(1);
        for camera in [camera, parallel] {
            let view = View { camera, width: 64, height: 64 };
            let shifts = Shifts::new(shifts).expect("possible shifts");
            let shot = Shot { shifts, ..Shot::new(Triangles::default(), view) };
            let space = PixelSpace::new(&shot);
            let (mut missed, mut hit) = (0, 0);
            for step in 0..4000 {
                // Sizes from less than a pixel to the whole image; some reach through the eye plane.
                let size = [0.01, 0.03, 0.1, 5.0][step % 4];
                let mut point = || Vec3::from_array([(); 3].map(|()| random.signed() as f32));
                let middle = point();
                let corners = [middle, middle + point() * size, middle + point() * size];
                let triangle = HomogeneousTriangle::new(&space, corners);
                let side = [1, 2, 4][step % 3];
                for (x, y) in (0..64).step_by(16).flat_map(|y| (0..64).step_by(4).map(move |x| (x, y))) {
                    let square = Square { x: x as i32 - space.middle.x, y: y as i32 - space.middle.y, side };
                    let mut pixels = (0..side as u32 * side as u32).map(|k| (x + k % side as u32, y + k / side as u32));
                    let is_hit = |(x, y)| crossing(&shot.ray(x, y), corners).is_some_and(|crossing| crossing.t > 0.0);
                    let is_missed = triangle.misses(square);
                    let is_hit = pixels.any(is_hit);
                    assert!(!(is_missed && is_hit), "{corners:?} in {square:?}");
                    (missed, hit) = (missed + u32::from(is_missed), hit + u32::from(is_hit));
                }
            }
            assert!(missed > 10_000 && hit > 1000, "{missed} missed, {hit} hit");
        }
    }
}
