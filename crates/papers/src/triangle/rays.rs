//! Input and output of the tests.

use super::lanes::{LaneMask, Lanes, cross};

/// A ray in f32, or sixteen: `origin + t · direction` for t in the open interval (`t_min`, `t_max`).
#[derive(Clone, Copy, Debug)]
pub struct Rays<L> {
    /// The point at t = 0, in world units.
    pub origin: [L; 3],
    /// Any length, the unit of t.
    pub direction: [L; 3],
    /// `direction` × `origin`: with `direction`, a line's Plücker coordinates.
    pub moment: [L; 3],
    /// Hits at or before this t don't count.
    pub t_min: L,
    /// Hits at or after this t don't count.
    pub t_max: L,
}

impl<L: Lanes> Rays<L> {
    /// Rays with an origin, a direction and an interval each.
    #[inline(always)]
    pub fn new(origin: [L; 3], direction: [L; 3], [t_min, t_max]: [L; 2]) -> Self {
        Self { origin, direction, moment: cross(direction, origin), t_min, t_max }
    }
}

/// A ray in f32, or sixteen, whose origin the test knows: t in the open interval (`t_min`, `t_max`).
#[derive(Clone, Copy, Debug)]
pub struct Bundle<L> {
    /// Any length, the unit of t.
    pub direction: [L; 3],
    /// Hits at or before this t don't count.
    pub t_min: L,
    /// Hits at or after this t don't count.
    pub t_max: L,
}

/// Hits of rays on a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Hits<L: Lanes> {
    /// The rays that hit: at least one. The other numbers are undefined for rays that don't.
    pub mask: L::Mask,
    /// Distances along the rays, in lengths of their directions.
    pub t: L,
    /// Weights of the triangle's second and third corner.
    pub barycentric: [L; 2],
}

impl<L: Lanes> Hits<L> {
    /// Hits of the rays of `mask` whose t is in the open interval; `None` if there are none.
    #[inline(always)]
    pub(super) fn within([t_min, t_max]: [L; 2], mask: L::Mask, t: L, barycentric: [L; 2]) -> Option<Self> {
        let mask = mask & t_min.is_below(t) & t.is_below(t_max);
        mask.any().then_some(Self { mask, t, barycentric })
    }

    /// The same with t and weights that are still to be divided by a `determinant`. Its sign doesn't matter to t, and
    /// must already be removed from the weights. If it is zero there is no hit.
    ///
    /// Only a t inside the interval is divided.
    #[inline(always)]
    pub(super) fn divided(
        [t_min, t_max]: [L; 2],
        mask: L::Mask,
        determinant: L,
        t: L,
        barycentric: [L; 2],
    ) -> Option<Self> {
        let sign = determinant.sign();
        let (determinant, t) = (determinant * sign, t * sign);
        // For a determinant of zero an infinite limit becomes NaN, and finite ones leave an empty interval.
        let mask = mask & (t_min * determinant).is_below(t) & t.is_below(t_max * determinant);
        if !mask.any() {
            return None;
        }
        let inverse = determinant.splat(1.0) / determinant;
        Some(Self { mask, t: t * inverse, barycentric: [barycentric[0] * inverse, barycentric[1] * inverse] })
    }
}
