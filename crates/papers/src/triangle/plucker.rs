//! Plücker coordinates: tell the side on which a ray passes each edge's line.
//!
//! Erickson, *Pluecker coordinates*, 1997; Shoemake, *Plücker coordinate tutorial*, 1998.

use glam::Vec3;

use super::lanes::{LaneMask, Lanes, dot_all};
use super::{Bundle, BundleTest, Hits, Rays, TriangleTest};

/// Benthin, *Realtime ray tracing on current CPU architectures*, 2006 (Rahikainen 2013, §2.1): the inner products
/// of the ray's line with the edges' lines have one sign. 88 bytes.
///
/// Six multiplications for each edge, and t only for rays inside: two dot products and a division. Coordinates are the
/// world's, so it loses digits far from the origin.
#[derive(Clone, Copy, Debug)]
pub struct Plucker {
    /// The edge opposite each corner as p − q and p × q.
    edges: [[Vec3; 2]; 3],
    normal: Vec3,
    /// normal · corner.
    distance: f32,
}

impl TriangleTest for Plucker {
    const NAME: &'static str = "Plücker";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let edges = [[b - c, b.cross(c)], [c - a, c.cross(a)], [a - b, a.cross(b)]];
        Self { edges, normal, distance: normal.dot(a) }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let [u, v, w] = self.edges;
        let u = dot_all(rays.direction, u[1]) + dot_all(rays.moment, u[0]);
        let v = dot_all(rays.direction, v[1]) + dot_all(rays.moment, v[0]);
        let mask = same_sign(u, v);
        if !mask.any() {
            return None;
        }
        let w = dot_all(rays.direction, w[1]) + dot_all(rays.moment, w[0]);
        let mask = mask & same_sign(u, w) & same_sign(v, w);
        if !mask.any() {
            return None;
        }
        let determinant = dot_all(rays.direction, self.normal);
        let t = -(dot_all(rays.origin, self.normal) - self.distance);
        Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v * v.sign(), w * w.sign()])
    }
}

/// Plücker's test for rays that share an origin (Benthin 2006; Rahikainen 2013, Algorithm 2.1.3): with it as the
/// world's origin, the rays' moments are zero. Both sides are hit. 52 bytes.
///
/// Three dot products for the edges, one more and a division for a hit.
#[derive(Clone, Copy, Debug)]
pub struct PluckerBundle {
    /// The normal of the plane through the origin and the edge opposite each corner.
    edges: [Vec3; 3],
    normal: Vec3,
    /// t times the determinant.
    height: f32,
}

impl BundleTest for PluckerBundle {
    const NAME: &'static str = "Plücker";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3], origin: Vec3) -> Self {
        let normal = (b - a).cross(c - a);
        let (a, b, c) = (a - origin, b - origin, c - origin);
        Self { edges: [b.cross(c), c.cross(a), a.cross(b)], normal, height: normal.dot(a) }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Bundle<L>) -> Option<Hits<L>> {
        let [u, v, w] = self.edges;
        let (u, v) = (dot_all(rays.direction, u), dot_all(rays.direction, v));
        let mask = same_sign(u, v);
        if !mask.any() {
            return None;
        }
        let w = dot_all(rays.direction, w);
        let mask = mask & same_sign(u, w) & same_sign(v, w);
        if !mask.any() {
            return None;
        }
        let determinant = dot_all(rays.direction, self.normal);
        let t = determinant.splat(self.height);
        Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v * v.sign(), w * w.sign()])
    }
}

/// Whether no number is above zero while the other is below.
#[inline(always)]
fn same_sign<L: Lanes>(a: L, b: L) -> L::Mask {
    (a.is_at_least_zero() & b.is_at_least_zero()) | (a.is_at_most_zero() & b.is_at_most_zero())
}
