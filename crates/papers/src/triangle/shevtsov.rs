//! Shevtsov, Soupikov and Kapustin, *Ray–triangle intersection algorithm for modern CPU architectures*, 2007.

use glam::Vec3;

use super::lanes::{Axis, LaneMask, Lanes};
use super::{Hits, Rays, TriangleTest};

/// Shevtsov et al. 2007 (Rahikainen 2013, equation 2.13): Plücker's test in a projection along an axis, scaled by the
/// normal's component there, so that only hits need a division. 40 bytes.
///
/// Four multiplications for the plane, eight for the weights, and a division.
#[derive(Clone, Copy, Debug)]
pub struct Shevtsov {
    /// The plane: the normal's components along the two kept axes, scaled to a third component of one, and its distance.
    plane: [f32; 3],
    /// The first corner along the two axes.
    corner: [f32; 2],
    /// The edges from it along the two axes, divided by the normal's third component.
    edges: [[f32; 2]; 2],
    /// The axis of projection.
    axis: Axis,
}

impl TriangleTest for Shevtsov {
    const NAME: &'static str = "Shevtsov et al.";

    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let (first, second) = (b - a, c - a);
        let normal = first.cross(second);
        let axis = Axis::largest(normal);
        let [p, q, r] = axis.order();
        let plane = [normal[p] / normal[r], normal[q] / normal[r]];
        let distance = a[r] + plane[0] * a[p] + plane[1] * a[q];
        let edges = [first, second].map(|edge| [edge[p] / normal[r], edge[q] / normal[r]]);
        Self { plane: [plane[0], plane[1], distance], corner: [a[p], a[q]], edges, axis }
    }

    #[inline(always)]
    fn hit<L: Lanes>(&self, rays: &Rays<L>) -> Option<Hits<L>> {
        let [p, q, r] = self.axis.order();
        let (origin, direction) = (&rays.origin, &rays.direction);
        let determinant = direction[p] * self.plane[0] + direction[q] * self.plane[1] + direction[r];
        let t = -(origin[p] * self.plane[0] + origin[q] * self.plane[1] + origin[r] - self.plane[2]);
        let sign = determinant.sign();
        // From the first corner to the hit, times the determinant without its sign.
        let at_p = (t * direction[p] + determinant * (origin[p] - self.corner[0])) * sign;
        let at_q = (t * direction[q] + determinant * (origin[q] - self.corner[1])) * sign;
        let [first, second] = self.edges;
        let v = at_p * second[1] - at_q * second[0];
        let mask = v.is_at_least_zero();
        if !mask.any() {
            return None;
        }
        let w = at_q * first[0] - at_p * first[1];
        let mask = mask & w.is_at_least_zero() & (v + w).is_at_most(determinant * sign);
        if !mask.any() {
            return None;
        }
        Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v, w])
    }
}
