//! Möller and Trumbore, *Fast, minimum storage ray/triangle intersection*, 1997, and its form for bundles.

use glam::Vec3;

use super::lanes::{LaneMask, Lanes, cross_all, dot, dot_all, minus_all};
use super::{Bundle, BundleTest, Hits, Rays, TriangleTest};

/// Möller and Trumbore 1997, without culling: Cramer's rule for t and two weights, nothing prepared. 36 bytes.
///
/// Two cross and four dot products and a division for a hit; a miss can end after one of each, and the division.
#[derive(Clone, Copy, Debug)]
pub struct MollerTrumbore {
    corners: [Vec3; 3],
}

impl TriangleTest for MollerTrumbore {
    const NAME: &'static str = "Möller–Trumbore";

    #[inline(always)]
    fn new(corners: [Vec3; 3]) -> Self {
        Self { corners }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let [a, b, c] = self.corners;
        let (first, second) = (b - a, c - a);
        let normal = cross_all(rays.direction, second);
        let determinant = dot_all(normal, first);
        // Zero makes the weights infinite or NaN, which are misses.
        let inverse = determinant.splat(1.0) / determinant;
        let offset = minus_all(rays.origin, a);
        let v = dot(offset, normal) * inverse;
        let mask = v.is_at_least_zero() & v.is_at_most(v.splat(1.0));
        if !mask.any() {
            return None;
        }
        let across = cross_all(offset, first);
        let w = dot(rays.direction, across) * inverse;
        let mask = mask & w.is_at_least_zero() & (v + w).is_at_most(v.splat(1.0));
        if !mask.any() {
            return None;
        }
        let t = dot_all(across, second) * inverse;
        Hits::within([rays.t_min, rays.t_max], mask, t, [v, w])
    }
}

/// Komatsu et al. 2008 for rays that share an origin (Rahikainen 2013, Algorithm 2.1.2), with both sides hit. 40 bytes.
///
/// Three dot products for a miss, and a division for a hit.
#[derive(Clone, Copy, Debug)]
pub struct MollerTrumboreBundle {
    normal: Vec3,
    /// Vectors whose dot products with the direction are the second and third corner's weights, times the determinant.
    weights: [Vec3; 2],
    /// t times the determinant.
    height: f32,
}

impl BundleTest for MollerTrumboreBundle {
    const NAME: &'static str = "Möller–Trumbore (Komatsu)";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3], origin: Vec3) -> Self {
        let (first, second, offset) = (b - a, c - a, origin - a);
        let normal = first.cross(second);
        Self { normal, weights: [offset.cross(second), first.cross(offset)], height: -normal.dot(offset) }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Bundle<L>) -> Option<Hits<L>> {
        let determinant = dot_all(rays.direction, self.normal);
        let sign = determinant.sign();
        let v = dot_all(rays.direction, self.weights[0]) * sign;
        let mask = v.is_at_least_zero();
        if !mask.any() {
            return None;
        }
        let w = dot_all(rays.direction, self.weights[1]) * sign;
        let mask = mask & w.is_at_least_zero() & (v + w).is_at_most(determinant * sign);
        if !mask.any() {
            return None;
        }
        let t = determinant.splat(self.height);
        Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v, w])
    }
}
