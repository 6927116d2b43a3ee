use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::lanes::{Vectors, absolute, dot, splat_vector};
use super::locate::{CameraRays, PointBox, Points, RELATIVE_ERROR};

/// A rectangle through which the light sees some of the points, as a projective map.
///
/// With v a position in relation to `origin`, p = (x · v, y · v, z · v) are its homogeneous coordinates; the map is
/// what these numbers say, exactly. In perspective a position is at (X, Y) = (p.x, p.y) / p.z with the nearness
/// W = `near` / p.z; for parallel light at (X, Y, W) = p. Either way a triangle is planar in (X, Y, W), straight lines
/// stay straight, W grows towards the light, and the points of the face have X and Y in [−1, 1].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Face {
    pub(super) origin: DVec3,
    pub(super) x: DVec3,
    pub(super) y: DVec3,
    pub(super) z: DVec3,
    /// What W is multiplied with in perspective.
    pub(super) near: f64,
    pub(super) is_parallel: bool,
    /// The side of a cube that the points are on; without, all points are on this face.
    pub(super) side: Option<Side>,
    /// What a length of one, seen from a distance of one, is in X, Y and in parallel light W.
    pub(super) scale: DVec3,
}

/// A side of a cube around the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    pub(super) axis: usize,
    pub(super) is_positive: bool,
}

impl Side {
    pub(super) const ALL: [Self; 6] = [
        Self { axis: 0, is_positive: true },
        Self { axis: 0, is_positive: false },
        Self { axis: 1, is_positive: true },
        Self { axis: 1, is_positive: false },
        Self { axis: 2, is_positive: true },
        Self { axis: 2, is_positive: false },
    ];
}

impl Face {
    /// The homogeneous coordinates of a world position.
    pub(super) fn homogeneous(&self, position: DVec3) -> DVec3 {
        let v = position - self.origin;
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// The sums of the magnitudes of x, y and z: times the largest component of a vector they bound its coordinates.
    pub(super) fn norms(&self) -> DVec3 {
        let norm = |axis: DVec3| axis.abs().element_sum();
        DVec3::new(norm(self.x), norm(self.y), norm(self.z))
    }

    /// How much X, Y and, in relation to itself in perspective, W change when a point on the face at p.z = 1 moves by
    /// one along each axis.
    pub(super) fn sensitivity(&self) -> f64 {
        let norms = self.norms();
        if self.is_parallel { norms.max_element() } else { norms.x.max(norms.y) + norms.z }
    }

    /// Whether some point in a box may be on this side of the cube.
    pub(super) fn may_own(&self, bounds: &PointBox) -> bool {
        let Some(Side { axis, is_positive }) = self.side else { return true };
        let (min, max) = (bounds.min - self.origin, bounds.max - self.origin);
        let most = if is_positive { max[axis] } else { -min[axis] };
        // How far the box is from the light along another axis, less what the box may be wrong by.
        let least = |axis: usize| min[axis].max(-max[axis]) * (1.0 - 1e-6);
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element() * 1e-9;
        most + reach >= least((axis + 1) % 3).max(least((axis + 2) % 3)) - reach
    }

    /// X, Y, W and 1 / p.z of eight vectors from the origin; the last is one for parallel light.
    #[inline(always)]
    pub(super) fn project<S: Simd>(&self, simd: S, v: Vectors<S>) -> (Vectors<S>, f64x8<S>) {
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

    /// Which of eight vectors from the origin are on this side of the cube, if the face is one; each vector is on
    /// exactly one.
    #[inline(always)]
    pub(super) fn owns<S: Simd>(&self, simd: S, v: Vectors<S>) -> fearless_simd::mask64x8<S> {
        let Some(Side { axis, is_positive }) = self.side else { return fearless_simd::mask64x8::splat(simd, true) };
        let [x, y, z] = absolute(v);
        let is_axis = match axis {
            0 => x.simd_ge(y) & x.simd_ge(z),
            1 => y.simd_gt(x) & y.simd_ge(z),
            _ => z.simd_gt(x) & z.simd_gt(y),
        };
        let zero = f64x8::splat(simd, 0.0);
        is_axis & if is_positive { v[axis].simd_ge(zero) } else { v[axis].simd_lt(zero) }
    }
}

/// A face, for the points whose places on it are known to some exactness, with what follows for the fast test.
///
/// The coordinates of vertices are computed in f64 and rounded to f32. A vertex is only used by the fast test of small
/// triangles where |X| and |Y| are at most 2: rounding then moves it by at most ε = 2⁻²⁴, and the f64 before it by less
/// than ε / 8, since the face is never scaled by more than 2²⁰ ([`project`](super::project) checks the rest). A point
/// has |X| and |Y| at most 1, so ε / 2, and is wrong by up to `slack` · 2⁻²⁸ before that (`limits`).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layer {
    pub(super) face: Face,
    /// Place in `limits`.
    pub(super) class: usize,
    /// The most slack of the points in each class: they are wrong by at most this times [`POINT_ERROR`], and the
    /// predicate thinks them wrong by at most this times [`PREDICATE_ERROR`].
    pub(super) limits: [f64; CLASSES],
    /// By how much a triangle's bounds are grown in X and Y so that no point in it is missed.
    pub(super) margin: f32,
    /// Errors of edge functions: per unit of the bounds' half circumference, of their area, and constant.
    pub(super) edge_errors: [f32; 3],
    /// Error of nearness in relation to the triangle's largest one.
    pub(super) nearness_error: f32,
    /// The predicate's own bound: the square of these times the triangle's extents in X, Y and W, in relation to the
    /// largest nearness.
    pub(super) predicate_errors: [f32; 3],
    pub(super) point_errors: PointErrors,
}

/// Half the distance from one to the next f32.
pub(super) const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// How many classes of points there are, by how exactly their places are known.
pub(super) const CLASSES: usize = 3;

/// Points with more slack, which may be wrong by 2⁻¹⁰, are not mapped.
const LARGEST_SLACK: f64 = (1 << 18) as f64;

/// What error a mapped point may have for slack one.
const POINT_ERROR: f64 = 1.0 / (1 << 28) as f64;

/// What the predicate's error of a point, in relation to its distance from the light, times the face's sensitivity,
/// may be for slack one.
pub(super) const PREDICATE_ERROR: f64 = 1.0 / (1_u64 << 38) as f64;

impl Layer {
    /// The layer of a class of the points in `boxes`.
    ///
    /// Nearly all points belong to the first class, so that the others, which take a round of their own, are rare.
    pub(super) fn new(face: Face, class: usize, points: &Points) -> Self {
        let point_errors = PointErrors::new(&face, &points.rays);
        // The mean of the reciprocals keeps points right beside the light from counting for much.
        let typical = points.boxes.iter().filter(|bounds| bounds.points > 0).map(|bounds| {
            let middle = bounds.min * 0.5 + bounds.max * 0.5;
            let depth = if face.is_parallel { 1.0 } else { face.z.dot(middle - face.origin) };
            let slack = point_errors.slack_of(points.rays.depth(middle).abs(), depth.recip());
            let counts = depth > 0.0 && slack > 0.0 && slack.is_finite();
            (slack.recip(), counts)
        });
        let counted = typical.filter(|&(_, counts)| counts);
        let (sum, count) = counted.fold((0.0, 0.0), |(sum, count), (inverse, _)| (sum + inverse, count + 1.0));
        let first = if count > 0.0 { (4.0 * count / sum).clamp(1.0, 4096.0) } else { 1.0 };
        let limits = [first, 64.0 * first, LARGEST_SLACK];
        let slack = limits[class];
        let point = HALF_ULP * (0.5 + slack / 16.0);
        let vertex = HALF_ULP * 1.125;
        // An edge function (p − s) × (q − s) changes by at most |Δ|·(w + h) when one of p, q and s moves by Δ on both
        // axes, w and h being the extents of the bounds; the product of two such is the constant term. Rounding is
        // counted in `small`: 22 ε of the bounds' area.
        let moved = 2.0 * vertex + point;
        let edge_errors = [moved * 1.1, HALF_ULP * 24.0, moved * moved * 2.0].map(|error| error as f32);
        // The nearness of three corners and the point, each wrong by ε (and the point by more), weighted by at most 2.
        let nearness_error = (HALF_ULP * 8.0 + 2.0 * slack * POINT_ERROR) as f32;
        Self {
            face,
            class,
            limits,
            margin: (HALF_ULP * 6.0 + slack * POINT_ERROR) as f32,
            edge_errors,
            nearness_error,
            predicate_errors: Self::predicate_errors(&face, slack).map(|error| error as f32),
            point_errors,
        }
    }

    /// What the predicate asks of a point before it calls it shadowed.
    ///
    /// It wants n · (P − a), for the unnormalised normal n, above 6 |ab| |ac| (10 u |P − a| + e), with u = 2⁻⁵³, largest
    /// components |·| and the point's error e. The fast test's area × (W of the triangle − W of the point) is
    /// n · (P − a) × s.x · s.y · near / (z₀ z₁ z₂ z), in parallel light × s.x · s.y · s.z. With corners whose depths
    /// differ by at most a factor of two, |X|, |Y| ≤ 2 and so |P| ≤ 6 z, the bound is at most
    /// 24 s.x s.y W (170 u + e / z) T², T = 2 (w / s.x + h / s.y) + 12 ΔW / W.
    fn predicate_errors(face: &Face, slack: f64) -> [f64; 3] {
        let scale = face.scale;
        let error = PREDICATE_ERROR * slack / face.sensitivity();
        if face.is_parallel {
            let reach = scale.z * (3.0 / scale.x + 3.0 / scale.y) + 2.0;
            let factor = (18.0 * scale.x * scale.y * (reach * 1.8e-15 + error * scale.z)).sqrt();
            scale.recip().to_array().map(|size| size * factor)
        } else {
            let factor = (24.0 * scale.x * scale.y * (6e-14 + error)).sqrt();
            [factor * 2.0 / scale.x, factor * 2.0 / scale.y, factor * 12.0]
        }
    }
}

/// How wrong a mapped point may be.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointErrors {
    /// Factors of the camera ray's t, and constants: first of the point's error, then of the predicate's.
    per_distance: [f64; 2],
    constant: [f64; 2],
}

impl PointErrors {
    /// A point is where its camera ray is at t. In relation to what the predicate takes it is moved by the error of t,
    /// and by some roundings of the vectors that are summed up: taken as 128 for the fast path and, since the predicate
    /// counts five, as 16 for its own bound.
    fn new(face: &Face, rays: &CameraRays) -> Self {
        const ROUNDING: f64 = f64::EPSILON / 2.0;
        let sensitivity = face.sensitivity();
        let largest = rays.largest_origin + face.origin.abs().max_element();
        let point = sensitivity / POINT_ERROR;
        let predicate = sensitivity / PREDICATE_ERROR;
        Self {
            per_distance: [
                point * rays.largest_direction * (RELATIVE_ERROR + 128.0 * ROUNDING),
                predicate * rays.largest_direction * 16.0 * ROUNDING,
            ],
            constant: [point * largest * 128.0 * ROUNDING, predicate * largest * 16.0 * ROUNDING],
        }
    }

    fn slack_of(&self, t: f64, inverse: f64) -> f64 {
        let [point, predicate] = [0, 1].map(|which| t * self.per_distance[which] + self.constant[which]);
        point.max(predicate) * inverse
    }

    /// The slack of eight points, given t and 1 / p.z.
    #[inline(always)]
    pub(super) fn slack<S: Simd>(&self, t: f64x8<S>, inverse: f64x8<S>) -> f64x8<S> {
        let t = t.abs();
        let point = t * self.per_distance[0] + self.constant[0];
        let predicate = t * self.per_distance[1] + self.constant[1];
        point.max(predicate) * inverse
    }
}
