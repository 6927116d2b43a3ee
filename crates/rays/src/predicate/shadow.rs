use glam::{DVec3, Vec3};

use super::{
    Edges, Expansion, ROUNDING, SMALLEST_TRUSTED_BOUND, canonical_order, exact_difference, exact_dot, exact_normal,
    is_missed,
};
use crate::{LightSource, Ray};

/// A point that a ray has hit, with a bound on the rounding error along each axis.
///
/// The true point on the triangle is in the box from `position − error` to `position + error`, both as f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitPoint {
    /// World position, within the range of f32.
    pub position: DVec3,
    /// Largest error of each coordinate; zero for an exactly known point.
    pub error: f64,
}

impl HitPoint {
    /// The point at distance `t` along `ray`, `t` being correct to its last bit.
    #[must_use]
    pub fn new(ray: &Ray, t: f64) -> Self {
        let step = ray.direction * t;
        let position = ray.origin + step;
        // One rounding of t, of the product and of the sum; the fourth is that of the box's corners.
        let error = 4.0 * ROUNDING * (step.abs().max_element() + position.abs().max_element());
        Self { position, error }
    }

    /// Whether the plane of the triangle `corners` meets the point's box. Rays that start at the point pass through such
    /// triangles: they begin there.
    #[must_use]
    pub fn is_on(&self, corners: [Vec3; 3]) -> bool {
        self.side_of(canonical_order(&corners).map(|index| corners[index])).is_none()
    }

    /// The side of a triangle's plane that the whole box is on: 1 where the normal points, else −1. `None` where the plane
    /// meets the box or the triangle has no plane.
    fn side_of(&self, corners: [Vec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let magnitude = DVec3::new(
            (ab.y * ac.z).abs() + (ab.z * ac.y).abs(),
            (ab.z * ac.x).abs() + (ab.x * ac.z).abs(),
            (ab.x * ac.y).abs() + (ab.y * ac.x).abs(),
        );
        let [low, high] = self.box_corners().map(|corner| corner - a);
        let (of_low, of_high) = (normal * low, normal * high);
        let (lowest, highest) = (of_low.min(of_high).element_sum(), of_low.max(of_high).element_sum());
        // A component of the normal has four roundings, the offset one, the product one and the sums two: eight. A component
        // with the wrong sign is within its own four of zero, and picks the other end of the box: eight more.
        let bound = magnitude.dot(low.abs().max(high.abs())) * (20.0 * ROUNDING);
        let is_trusted = bound >= SMALLEST_TRUSTED_BOUND;
        if is_trusted && lowest > bound {
            Some(1.0)
        } else if is_trusted && highest < -bound {
            Some(-1.0)
        } else if is_trusted && lowest < -bound && highest > bound {
            None
        } else {
            self.exact_side_of([a, b, c])
        }
    }

    /// As [`side_of`](Self::side_of), in exact arithmetic.
    #[cold]
    fn exact_side_of(&self, [a, b, c]: [DVec3; 3]) -> Option<f64> {
        // Points may have bits far below those of corners: products keep them all where they are large.
        const SCALE: f64 = POWER * POWER * POWER;
        const POWER: f64 = (1_u128 << 100) as f64;
        let normal = exact_normal(a, b, c);
        let [low, high] = self.box_corners().map(|corner| corner * SCALE);
        let a = a * SCALE;
        let is_along = DVec3::from_array(normal.each_ref().map(Expansion::estimate)).cmpgt(DVec3::ZERO);
        let height = |corner: DVec3| exact_dot(&normal, &exact_difference(corner, a)).estimate();
        if height(DVec3::select(is_along, low, high)) > 0.0 {
            Some(1.0)
        } else if height(DVec3::select(is_along, high, low)) < 0.0 {
            Some(-1.0)
        } else {
            None
        }
    }

    /// The lowest and highest corner of the point's box.
    fn box_corners(&self) -> [DVec3; 2] {
        [self.position - self.error, self.position + self.error]
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

    /// The point.
    #[must_use]
    pub fn point(&self) -> DVec3 {
        self.point.position
    }

    /// Whether the triangle `corners` shadows the point, and if so the weights of its second and third corner where
    /// the segment crosses it.
    ///
    /// It does when the segment's line meets it, the light is strictly on one side of its plane, and the point's whole box
    /// strictly on the other: so a surface that coincides with the point's own doesn't shadow it. Call it for triangles
    /// other than the point's own.
    #[must_use]
    #[inline]
    pub fn blocked_by(&self, corners: [Vec3; 3]) -> Option<[f32; 2]> {
        if is_missed(self.ray.origin, self.ray.direction, corners) {
            return None;
        }
        // Tested first, since the triangles around the point's own mostly end here.
        let side = self.point.side_of(canonical_order(&corners).map(|index| corners[index]))?;
        let edges = Edges::new(self.ray.origin, self.ray.direction, corners)?;
        let is_behind = side == edges.side;
        // For a ray from the point, the crossing has to be ahead of the point.
        let blocked = if self.from_point { !is_behind } else { is_behind && edges.is_ahead() };
        blocked.then(|| edges.barycentric())
    }
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
        let decided = height.abs() > bound && bound >= SMALLEST_TRUSTED_BOUND;
        let height = if decided {
            height
        } else {
            exact_dot(&exact_normal(a, b, c), &exact_difference(a, self.origin)).estimate()
        };
        height * self.side > 0.0
    }
}
