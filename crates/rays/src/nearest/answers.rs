use glam::{DVec3, Vec3};

use crate::Triangles;

/// Points, and the triangles to which their distances are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Closest<'a> {
    /// World-space triangles. Those without area count as segments or points here; those with a corner that isn't finite are
    /// left out.
    pub triangles: Triangles<'a>,
    /// World positions, fewer than 2³², in any order. Those that aren't finite have no nearest point.
    pub points: &'a [Vec3],
    /// Triangles at this distance or farther don't count, in world units; infinite for no limit.
    pub max: f64,
}

impl<'a> Closest<'a> {
    /// Nearest points at any distance.
    #[must_use]
    pub fn new(triangles: Triangles<'a>, points: &'a [Vec3]) -> Self {
        Self { triangles, points, max: f64::INFINITY }
    }
}

/// The nearest point of all triangles for each point of a query, in the query's order.
///
/// Where no triangle is near enough, the triangle is [`ClosestPoints::NONE`], the distance infinite, and weights and position
/// are NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosestPoints {
    /// Id of the nearest triangle, the lowest one of those that are equally near in real numbers.
    pub triangle: Vec<u32>,
    /// Weights of the triangle's second and third corner, each in [0, 1].
    pub barycentric: Vec<[f32; 2]>,
    /// The nearest point of the triangle, in world units, to within a few roundings in f64 of the distances of its corners.
    pub position: Vec<DVec3>,
    /// Distance from it in world units, as exact as the position.
    pub distance: Vec<f64>,
    /// The number of points that aren't finite: they have no nearest triangle.
    pub nowhere: usize,
}

impl ClosestPoints {
    /// Id that stands for no triangle.
    pub const NONE: u32 = u32::MAX;

    pub(super) fn resize(&mut self, points: usize) {
        self.triangle.resize(points, Self::NONE);
        self.barycentric.resize(points, [f32::NAN; 2]);
        self.position.resize(points, DVec3::NAN);
        self.distance.resize(points, f64::INFINITY);
    }

    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangle.len()
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangle.is_empty()
    }
}

/// For each point the triangles that are nearer to it than a distance, or for each box those that touch it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Within {
    /// The ids of triangles, point after point, those of each in ascending order.
    pub triangle: Vec<u32>,
    /// The index in `triangle` of each point's first one, and finally the end of the last one's: one more than points.
    pub starts: Vec<usize>,
}

impl Within {
    /// The triangles near a point.
    ///
    /// # Panics
    /// If `point` is out of range.
    #[must_use]
    pub fn of(&self, point: usize) -> &[u32] {
        &self.triangle[self.starts[point]..self.starts[point + 1]]
    }
}
