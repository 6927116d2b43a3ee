use crate::simd::vectors::LANES;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::point_set::PointSet;
use super::survey::SurveyedTile;
use crate::shot::CameraRays;
use crate::simd::vectors::{Vectors, dot, splat_vector};

/// A rectangle through which the light sees some of the points, as a projective map.
///
/// With v a position in relation to `origin`, p = (x · v, y · v, z · v) are its homogeneous coordinates; these numbers
/// define the map exactly. In perspective a position is at (X, Y) = (p.x, p.y) / p.z with the nearness W = `near` / p.z; for
/// parallel light at (X, Y, W) = p. Either way a triangle is planar in (X, Y, W), straight lines stay straight, W grows
/// towards the light, and the points of the face have X and Y in [−1, 1].
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    pub(crate) origin: DVec3,
    pub(crate) x: DVec3,
    pub(crate) y: DVec3,
    pub(crate) z: DVec3,
    /// The factor of W in perspective.
    pub(crate) near: f64,
    pub is_parallel: bool,
    /// The extents in X and Y of a unit length seen from a distance of one, and in W in parallel light.
    pub(crate) scale: DVec3,
    /// Lowest and highest X, and Y, of the points that are tested on this face, where several faces share the points. Faces
    /// overlap by more than the points' error, so that each point is on some face in spite of rounding.
    pub(crate) owned: Option<[[f64; 2]; 2]>,
    /// The predicate's error of a point, in perspective in relation to its depth.
    pub(crate) point_error: f64,
}

/// Half the distance from one to the next f32.
pub const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// Half the distance from one to the next f64.
pub(crate) use crate::predicate::ROUNDING;

/// The largest |X| and |Y| of a mapped point: a point of the face is in [−1, 1]; one of a neighbouring face is outside by
/// less than half of the rest, and the error of either is less than the other half.
pub const POINT_LIMIT: f64 = 1.0 + 1.0 / 1024.0;

/// The largest error of X and Y of a point: a fraction of a cell.
pub(crate) const LARGEST_POINT_ERROR: f64 = 1.0 / 4096.0;

/// A triangle whose |X| or |Y| are all above this can't be between the light and the face's points.
pub const FACE_LIMIT: f64 = 1.0 + 1.0 / 256.0;

/// The margin of a triangle's bounds in X and Y: rounding its vertices, and the bounds, can't lose a point in it. See
/// [`VertexErrors`].
pub const VERTEX_MARGIN: f32 = 6.0 * HALF_ULP as f32;

/// Least and largest [`Face::point_error`]; a thousand times the farthest point's error replaces the latter where it is
/// more.
const POINT_ERRORS: [f64; 2] = [1.0 / (1_u64 << 36) as f64, 1.0 / (1 << 24) as f64];

impl Face {
    /// The homogeneous coordinates of a world position.
    pub(crate) fn homogeneous(&self, position: DVec3) -> DVec3 {
        let v = position - self.origin;
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// The sums of the magnitudes of x, y and z; times the largest component of a vector they bound its coordinates.
    pub(crate) fn norms(&self) -> DVec3 {
        let norm = |axis: DVec3| axis.abs().element_sum();
        DVec3::new(norm(self.x), norm(self.y), norm(self.z))
    }

    /// The sign of the area on the face of triangles on whose front the light falls.
    pub(crate) fn sign_of_fronts(&self) -> f32 {
        // Away from the light; W grows the other way. A triangle's normal is against that where the light falls on its
        // front.
        let along = if self.is_parallel { -self.z } else { self.z };
        -self.x.cross(self.y).dot(along).signum() as f32
    }

    /// The predicate's error of a point whose ray meets it at t, on any axis, in perspective in relation to its p.z: 4
    /// roundings of the step along the ray and of the position, and one of their sum.
    pub(crate) fn point_error_at(&self, rays: &CameraRays, t: f64, depth: f64) -> f64 {
        let error = 5.0 * ROUNDING * (2.0 * t.abs() * rays.largest_direction + rays.largest_origin);
        if self.is_parallel { error } else { error / depth }
    }

    /// Chooses the predicate's error for points of the face: four times the largest of any corner of a tile, unless that
    /// corner is practically on the light, a thousand times as near as another. Points with larger errors are outliers.
    pub fn choose_point_error(&mut self, points: &PointSet<'_>, tiles: &[SurveyedTile]) {
        let corners = tiles.iter().filter(|tile| tile.points > 0).flat_map(|tile| tile.corners);
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        for corner in corners {
            let depth = self.z.dot(corner - self.origin);
            if depth > 0.0 || self.is_parallel {
                let error = points.error_at(self, corner, depth);
                (least, largest) = (least.min(error), largest.max(error));
            }
        }
        let most = if least.is_finite() { POINT_ERRORS[1].max(1024.0 * least) } else { POINT_ERRORS[1] };
        self.point_error = (4.0 * largest).clamp(POINT_ERRORS[0], most);
    }

    /// The largest distance of the tiles' points from the light: a depth in perspective, else minus W.
    pub(crate) fn farthest(&self, tiles: &[SurveyedTile]) -> f64 {
        let sign = if self.is_parallel { -1.0 } else { 1.0 };
        let corners = tiles.iter().filter(|tile| tile.points > 0).flat_map(|tile| tile.corners);
        // Far more than rounding: less than 4 u |z|₁ |v|.
        let rounding = self.norms().z * 1e-8;
        let farthest = corners.map(|corner| {
            let v = corner - self.origin;
            sign * self.z.dot(v) + v.abs().max_element() * rounding
        });
        farthest.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether some point of a tile may be on this face.
    pub fn may_own(&self, tile: &SurveyedTile) -> bool {
        let Some([x, y]) = self.owned else { return tile.points > 0 };
        // A frustum is outside where all its corners are outside of the same plane; a little is left for rounding.
        let corners = tile.corners.map(|corner| self.homogeneous(corner));
        let outside = |height: fn(DVec3, [[f64; 2]; 2]) -> f64| {
            corners.iter().all(|&corner| height(corner, [x, y]) > 1e-6 * corner.abs().max_element())
        };
        tile.points > 0
            && !(outside(|p, _| -p.z)
                || outside(|p, [x, _]| p.x - x[1] * p.z)
                || outside(|p, [x, _]| x[0] * p.z - p.x)
                || outside(|p, [_, y]| p.y - y[1] * p.z)
                || outside(|p, [_, y]| y[0] * p.z - p.y))
    }

    /// X, Y, W and 1 / p.z of eight vectors from the origin; the last is one for parallel light.
    #[inline(always)]
    pub(crate) fn project<S: Simd>(&self, simd: S, v: Vectors<S>) -> (Vectors<S>, f64x8<S>) {
        let one = f64x8::splat(simd, 1.0);
        let rows = [
            dot(v, splat_vector(simd, self.x)),
            dot(v, splat_vector(simd, self.y)),
            dot(v, splat_vector(simd, self.z)),
        ];
        if self.is_parallel {
            (rows, one)
        } else {
            let inverse = one / rows[2];
            ([rows[0] * inverse, rows[1] * inverse, inverse * self.near], inverse)
        }
    }
}

/// Errors that follow from rounding vertices, for the filter of small triangles. With ε = [`HALF_ULP`].
///
/// The coordinates of vertices are computed in f64 and rounded to f32. A vertex is only used where |X| and |Y| are below 2:
/// rounding then moves it by at most ε, and the f64 before it by less than ε / 8, since the face is never scaled by more
/// than 2²⁰ ([`project`](super::project) checks the rest). W has the same error in relation to itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct VertexErrors {
    /// The predicate's own bound: the square of these times the triangle's extents in X, Y and W, in relation to the
    /// largest nearness.
    pub of_predicate: [f32; 3],
    /// Error of the predicate's own weights of corners, as edge functions: the square of the first plus the second times the
    /// largest nearness.
    pub(crate) of_weights: [f32; 2],
}

impl VertexErrors {
    /// The largest distance that rounding moves a vertex along X and Y.
    pub const MOVED: f64 = 1.125 * HALF_ULP;

    /// Bounds the errors that the predicate allows for before it calls a point shadowed.
    ///
    /// It wants n · (P − a), for the unnormalised normal n, above e times the sum of n's components, e being half the
    /// point's box. That is less than 6 |ab| |ac| (10 u |P − a| + e), with u = 2⁻⁵³ and largest components |·|; this is the
    /// bound counted here. The filter's area × (W of the triangle − W of the point) is n · (P − a) × s.x · s.y · near
    /// / (z₀ z₁ z₂ z), in parallel light × s.x · s.y · s.z. With corners whose depths differ by at most a factor of two,
    /// |X|, |Y| ≤ 2 and so |P| ≤ 18 z, the bound is at most 24 s.x s.y W (510 u + e / z) T², T = 2 (w / s.x + h / s.y) + 36
    /// ΔW / W.
    ///
    /// Its weights d · ((p − o) × (q − o)) have 64 roundings of |d| r², with r the largest component of any corner from o.
    /// An edge function of the filter is that × s.x · s.y / (z₀ z₁ z), in parallel light × s.x · s.y / |d|; depths of
    /// corners differ by at most a factor of two.
    pub fn new(face: &Face) -> Self {
        let scale = face.scale;
        let across = 2.5 / scale.x + 2.5 / scale.y;
        let roundings = (64.0 * ROUNDING * scale.x * scale.y).sqrt();
        let of_weights = if face.is_parallel {
            [roundings * (across * 2.0 + 2.0 / scale.z), roundings / scale.z]
        } else {
            // The largest distance of a vertex from the light in relation to its depth.
            let reach = 1.0 + across + (face.x.dot(face.z) / scale.x).abs() + (face.y.dot(face.z) / scale.y).abs();
            [roundings * 2.0 * reach * reach.sqrt(), 0.0]
        };
        let of_weights = of_weights.map(|error| error as f32 * 1.001);
        let of_predicate = if face.is_parallel {
            let reach = scale.z * (3.0 / scale.x + 3.0 / scale.y) + 2.0;
            let factor = (18.0 * scale.x * scale.y * (reach * 1.8e-15 + face.point_error * scale.z)).sqrt();
            scale.recip().to_array().map(|size| size * factor)
        } else {
            let factor = (24.0 * scale.x * scale.y * (1.8e-13 + face.point_error)).sqrt();
            [factor * 2.0 / scale.x, factor * 2.0 / scale.y, factor * 36.0]
        };
        Self { of_predicate: of_predicate.map(|error| error as f32), of_weights }
    }
}

/// The points of 4×4 pixels on a face, in pixel order: the filter tests them at once. 192 bytes.
///
/// Lanes without a point of the face have no meaning.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Block {
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    /// Nearness to the light.
    pub nearness: [f32; LANES],
}

impl Block {
    pub const EMPTY: Self = Self { x: [0.0; LANES], y: [0.0; LANES], nearness: [0.0; LANES] };
}
