use glam::{DVec3, Vec3};

use super::{Edges, ROUNDING, canonical_order, exact_difference, exact_dot, exact_normal, is_missed};
use crate::{LightSource, Ray};

/// A point that a ray has hit, with a bound on how far rounding may have moved it on any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitPoint {
    /// World position.
    pub position: DVec3,
    /// Largest error of each coordinate.
    pub error: f64,
}

impl HitPoint {
    /// The point at distance `t` along `ray`, `t` being correct to about its last bit.
    #[must_use]
    pub fn new(ray: &Ray, t: f64) -> Self {
        let step = ray.direction * t;
        let position = ray.origin + step;
        // Two roundings in t, one in the product, one in the sum; the fifth covers the bound's own.
        let error = 5.0 * ROUNDING * (step.abs().max_element() + position.abs().max_element());
        Self { position, error }
    }

    /// Whether the point may be in the plane of the triangle `corners`, as far as its error allows to tell. Rays that start
    /// at the point pass through such triangles: they begin there.
    #[must_use]
    pub fn is_on(&self, corners: [Vec3; 3]) -> bool {
        height_above(canonical_order(&corners).map(|index| corners[index]), *self).is_none()
    }
}

/// The segment from a light to a point, which decides whether the point is lit.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// From the light to the point with t in (0, 1), or from the point to a light infinitely far away with t in
    /// (0, ∞).
    pub ray: Ray,
    point: HitPoint,
    from_point: bool,
}

impl ShadowRay {
    /// The segment between `light` and `point`.
    #[must_use]
    pub fn new(light: &LightSource, point: HitPoint) -> Self {
        match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                let origin = position.as_dvec3();
                let ray = Ray { origin, direction: point.position - origin, t_min: 0.0, t_max: 1.0 };
                Self { ray, point, from_point: false }
            }
            LightSource::Directional { direction } => {
                let ray = Ray::new(point.position, -direction.as_dvec3());
                Self { ray, point, from_point: true }
            }
        }
    }

    /// Whether the triangle `corners` shadows the point, and if so the weights of its second and third corner where
    /// the segment crosses it.
    ///
    /// It does when the segment crosses it strictly between the light and the point, by more than the error bound of
    /// the point itself: a surface that coincides with the point's own doesn't shadow it. Call it for other triangles
    /// than the one that the point is on.
    #[must_use]
    pub fn blocked_by(&self, corners: [Vec3; 3]) -> Option<[f32; 2]> {
        if is_missed(self.ray.origin, self.ray.direction, corners) {
            return None;
        }
        // Asked first of what is left, since the triangles around the point's own mostly end here.
        let height = height_above(canonical_order(&corners).map(|index| corners[index]), self.point)?;
        let edges = Edges::new(self.ray.origin, self.ray.direction, corners)?;
        let is_behind = height * edges.side > 0.0;
        // From the point, the crossing has to be ahead of it.
        let blocked = if self.from_point { !is_behind } else { is_behind && edges.is_ahead() };
        blocked.then(|| edges.barycentric())
    }
}

/// How far a point is from the plane of a triangle, in lengths of its unnormalised normal and towards it; `None` where
/// that is within the error of the point and of this evaluation.
fn height_above(corners: [Vec3; 3], point: HitPoint) -> Option<f64> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let magnitude = DVec3::new(
        (ab.y * ac.z).abs() + (ab.z * ac.y).abs(),
        (ab.z * ac.x).abs() + (ab.x * ac.z).abs(),
        (ab.x * ac.y).abs() + (ab.y * ac.x).abs(),
    );
    let offset = point.position - a;
    // A component of the normal has four roundings, of the offset one, the product one and the sums two: eight,
    // and two more for the bound's own.
    let bound = magnitude.dot(offset.abs() * (10.0 * ROUNDING) + DVec3::splat(point.error));
    let height = normal.dot(offset);
    (height.abs() > bound).then_some(height)
}

impl Edges {
    /// Whether the line meets the plane at t > 0, exactly.
    fn is_ahead(&self) -> bool {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let (ab, ac, towards) = (b - a, c - a, a - self.origin);
        let height = ab.cross(ac).dot(towards);
        let reach = ab.abs().max_element() * ac.abs().max_element() * towards.abs().max_element();
        // As for the edge functions: 42 roundings of the largest product, taken as 64.
        let bound = 64.0 * ROUNDING * reach;
        let decided = height.abs() > bound && bound >= super::SMALLEST_TRUSTED_BOUND;
        let height =
            if decided { height } else { exact_dot(&exact_normal(a, b, c), &exact_difference(a, self.origin)) };
        height * self.side > 0.0
    }
}
