//! Havel and Herout, *Yet faster ray–triangle intersection (using SSE4)*, 2010.

use glam::Vec3;

use super::lanes::{LaneMask, Lanes, dot_all};
use super::{Hits, Rays, TriangleTest};

/// Havel and Herout 2010 (Rahikainen 2013, equations 2.14 to 2.16): the plane and, in place of a projection, two
/// planes across it that give the weights. 48 bytes.
///
/// Two dot products for the plane, six multiplications for the point, one more dot product for each weight, and a
/// division for hits.
#[derive(Clone, Copy, Debug)]
pub struct HavelHerout {
    normal: Vec3,
    /// normal · corner.
    distance: f32,
    /// Factors of a point's coordinates, and a constant, that give the second and third corner's weight.
    weights: [(Vec3, f32); 2],
}

impl TriangleTest for HavelHerout {
    const NAME: &'static str = "Havel–Herout";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let (first, second) = (b - a, c - a);
        let normal = first.cross(second);
        let inverse = 1.0 / normal.length_squared();
        let weights = [second.cross(normal), normal.cross(first)].map(|plane| {
            let plane = plane * inverse;
            (plane, -plane.dot(a))
        });
        Self { normal, distance: normal.dot(a), weights }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let (origin, direction) = (rays.origin, rays.direction);
        let determinant = dot_all(direction, self.normal);
        let t = -(dot_all(origin, self.normal) - self.distance);
        let sign = determinant.sign();
        let (scale, signed_t) = (determinant * sign, t * sign);
        // The hit, times the determinant without its sign.
        let point = [
            origin[0] * scale + direction[0] * signed_t,
            origin[1] * scale + direction[1] * signed_t,
            origin[2] * scale + direction[2] * signed_t,
        ];
        let [(first, first_constant), (second, second_constant)] = self.weights;
        let v = dot_all(point, first) + scale * first_constant;
        let mask = v.is_at_least_zero() & v.is_at_most(scale);
        if !mask.any() {
            return None;
        }
        let w = dot_all(point, second) + scale * second_constant;
        let mask = mask & w.is_at_least_zero() & (v + w).is_at_most(scale);
        if !mask.any() {
            return None;
        }
        Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v, w])
    }
}
