use glam::Vec3;

use super::TriangleFan;
use crate::triangle::lanes::{LaneMask, Lanes, cross, dot_all, minus_all};
use crate::triangle::{Hits, Rays};

impl TriangleFan<'_> {
    /// Calls `found` with the id of each triangle that rays hit, on either side, and with the hits, whose weights
    /// belong to the triangle's own corners. Triangles come around the centre, not by distance.
    ///
    /// Galin and Akkouche 2005, §3 (Rahikainen 2013, equation 2.18): one cross product for the fan, one dot product for
    /// each of its edges. The ray's line passes through the wedge between two neighbouring edges only if their dot
    /// products differ in sign; then the triangle is tested as by Möller and Trumbore.
    #[inline(always)]
    pub fn hit<L: Lanes>(&self, rays: &Rays<L>, mut found: impl FnMut(u32, Hits<L>)) {
        let offset = minus_all(rays.origin, self.center);
        let across = cross(offset, rays.direction);
        let [first, rest @ ..] = self.edges else { return };
        let (mut edge, mut side) = (*first, dot_all(across, *first));
        for (index, &next) in rest.iter().enumerate() {
            let next_side = dot_all(across, next);
            let counterclockwise = side.is_at_least_zero() & next_side.is_at_most_zero();
            let clockwise = side.is_at_most_zero() & next_side.is_at_least_zero();
            let mask = counterclockwise | clockwise;
            if mask.any()
                && let Some(hits) = hit_wedge(rays, offset, mask, [edge, next], [side, next_side])
            {
                let [v, w] = hits.barycentric;
                let center = v.splat(1.0) - v - w;
                let barycentric = match self.center_corners[index] {
                    0 => [v, w],
                    1 => [center, v],
                    _ => [w, center],
                };
                found(self.ids[index], Hits { barycentric, ..hits });
            }
            (edge, side) = (next, next_side);
        }
    }
}

/// Hits of the rays of `mask` on the triangle between two edges from the centre, given the `sides` on which they pass
/// the edges.
#[inline(always)]
fn hit_wedge<L: Lanes>(
    rays: &Rays<L>,
    offset: [L; 3],
    mask: L::Mask,
    edges: [Vec3; 2],
    sides: [L; 2],
) -> Option<Hits<L>> {
    let normal = edges[0].cross(edges[1]);
    let determinant = dot_all(rays.direction, normal);
    let sign = determinant.sign();
    let (v, w) = (-(sides[1] * sign), sides[0] * sign);
    // The determinant's own sign tells the wedge from its mirror image.
    let inside = v.is_at_least_zero() & w.is_at_least_zero() & (v + w).is_at_most(determinant * sign);
    let mask = mask & inside;
    if !mask.any() {
        return None;
    }
    let t = -dot_all(offset, normal);
    Hits::divided([rays.t_min, rays.t_max], mask, determinant, t, [v, w])
}
