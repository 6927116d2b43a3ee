use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::lattice::Lattice;
use super::slices::Beam;
use crate::packet::{HALF_ULP, LANES};
use umbrage_rays::{Bounds, Triangles};

/// The four planes of a [`Beam`] in f32, which are tested against a triangle's corners alone (Wald et al. 2006, §2.3).
///
/// Most triangles in a packet's cells are beside it (`umbrage-bench culling` counts them: 19 of 20 with 8×8 rays in
/// `demo:cloth`). This rules them out without preparing them for the packet's rays.
pub(super) struct Frustum {
    axes: [usize; 3],
    low: [FrustumSide; 2],
    high: [FrustumSide; 2],
}

/// A plane of world coordinates: u = slope · z + offset, with u one of the axes across the beam and z the major one.
#[derive(Clone, Copy)]
struct FrustumSide {
    slope: f32,
    offset: f32,
    /// Error bound of u − (slope · z + offset) and of the beam.
    margin: f32,
}

impl Frustum {
    /// The frustum of a beam among triangles inside `bounds`.
    pub(super) fn new(lattice: &Lattice, beam: &Beam, bounds: &Bounds) -> Self {
        let reach = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element());
        let [from_u, from_v, from_z] = beam.axes.map(|axis| lattice.corner[axis]);
        let plane = |bound: usize, from: f64, side: f64| {
            let slope = side * beam.rate[bound] * beam.sign;
            let shift = lattice.side * (side * beam.base[bound] - slope * beam.start);
            let offset = from + shift - slope * from_z;
            // The slope, the offset, their product and both sums are rounded to f32: at most four roundings for each
            // term, and one for those in f64.
            let terms = (1.0 + slope.abs()) * reach + from.abs() + shift.abs() + slope.abs() * from_z.abs();
            // Rays are outside of the beam's relevant part by at most its slack, and slopes are four at most.
            let margin = 5.0 * HALF_ULP * terms + 8.0 * beam.slack * lattice.side;
            // Numbers that overflow or underflow f32 rule nothing out.
            let margin = if terms < 1e37 { (margin as f32).next_up() + f32::MIN_POSITIVE } else { f32::INFINITY };
            FrustumSide { slope: slope as f32, offset: offset as f32, margin }
        };
        Self {
            axes: beam.axes,
            low: [plane(0, from_u, 1.0), plane(2, from_v, 1.0)],
            high: [plane(1, from_u, -1.0), plane(3, from_v, -1.0)],
        }
    }

    /// The triangles, of up to 16, that certainly no ray hits, a bit for each: those with all corners beyond one plane.
    ///
    /// Where a ray hits a triangle it is between the planes. So at least one of the triangle's corners is below the high
    /// plane, and one above the low one.
    #[inline(always)]
    pub(super) fn missed<S: Simd>(&self, simd: S, triangles: Triangles<'_>, ids: &[u32]) -> u64 {
        let mut corners = [[[0.0_f32; LANES]; 3]; 3];
        for (lane, &id) in ids.iter().take(LANES).enumerate() {
            for (corner, &vertex) in corners.iter_mut().zip(&triangles.indices[id as usize]) {
                let position = triangles.positions[vertex as usize];
                for (coordinates, axis) in corner.iter_mut().zip(self.axes) {
                    coordinates[lane] = position[axis];
                }
            }
        }
        // Without `array::map`, which isn't reliably inlined, and then is compiled without the instruction set.
        let [a, b, c] = corners;
        let [a, b, c] = [vectors(simd, a), vectors(simd, b), vectors(simd, c)];
        let mut missed = 0;
        for axis in 0..2 {
            let (low, high) = (self.low[axis], self.high[axis]);
            let [u, z] = [[a[axis], b[axis], c[axis]], [a[2], b[2], c[2]]];
            let highest = low.over(simd, u[0], z[0]).max(low.over(simd, u[1], z[1])).max(low.over(simd, u[2], z[2]));
            let lowest = high.over(simd, u[0], z[0]).min(high.over(simd, u[1], z[1])).min(high.over(simd, u[2], z[2]));
            let below = highest.simd_lt(f32x16::splat(simd, -low.margin));
            let above = lowest.simd_gt(f32x16::splat(simd, high.margin));
            missed |= (below | above).to_bitmask();
        }
        missed
    }
}

#[inline(always)]
fn vectors<S: Simd>(simd: S, [u, v, z]: [[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    [f32x16::simd_from(simd, u), f32x16::simd_from(simd, v), f32x16::simd_from(simd, z)]
}

impl FrustumSide {
    /// The heights of points above the plane.
    #[inline(always)]
    fn over<S: Simd>(self, simd: S, u: f32x16<S>, z: f32x16<S>) -> f32x16<S> {
        u - (z * f32x16::splat(simd, self.slope) + f32x16::splat(simd, self.offset))
    }
}
