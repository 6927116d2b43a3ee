//! Settles the cases that a filter leaves undecided by the predicate, for every structure.

use super::{ShadowRay, crossing};
use crate::shot::{Opacity, OpacityOfSides, SeenPixels, Shot};
use crate::{Hit, Ray};
use glam::Vec3;

/// Settles the nearest hit of a pixel's ray between two triangles: `best`, a known hit unless it is [`SeenPixels::NONE`],
/// and `candidate`, which the filter could neither rule out nor accept.
///
/// `None` where `best` certainly stays without a test, or `candidate` isn't hit. Counts in `settled` the cases that the
/// predicate tested.
#[cold]
#[inline(never)]
pub fn nearest(shot: &Shot<'_>, (x, y): (u32, u32), best: u32, candidate: u32, settled: &mut u64) -> Option<Hit> {
    if best == candidate {
        return None;
    }
    // Two triangles with the same corners, such as those between two pieces that have come apart, are hit alike.
    let corners = |id: u32| shot.triangles.corners(id);
    let is_copy = best != SeenPixels::NONE && are_the_same(corners(best), corners(candidate));
    if is_copy && best < candidate {
        return None;
    }
    *settled += 1;
    let ray = shot.ray(x, y);
    let new = hit(shot, &ray, candidate)?;
    if !shot.opacity.is_stopped_at(candidate, new.barycentric) {
        return None;
    }
    let old = if best == SeenPixels::NONE || is_copy { None } else { hit(shot, &ray, best) };
    Some(old.filter(|old| (old.t, old.triangle) < (new.t, new.triangle)).unwrap_or(new))
}

/// The hit of a camera ray on a side of a triangle that stops it, regardless of the triangle's opacity there.
fn hit(shot: &Shot<'_>, ray: &Ray, triangle: u32) -> Option<Hit> {
    let crossing = crossing(ray, shot.triangles.corners(triangle))?;
    let is_there = crossing.front || shot.sides.has_back(triangle);
    let hit = Hit { t: crossing.t, triangle, barycentric: crossing.barycentric };
    (is_there && ray.t_min < hit.t && hit.t < ray.t_max).then_some(hit)
}

/// Whether two triangles have the same corners, in any order.
fn are_the_same(first: [Vec3; 3], [a, b, c]: [Vec3; 3]) -> bool {
    [[a, b, c], [b, c, a], [c, a, b], [c, b, a], [b, a, c], [a, c, b]].contains(&first)
}

/// Settles which points are in shadow.
pub struct Shadows<'a> {
    opacity: &'a OpacityOfSides<'a>,
    /// The last tested point, and the segment between it and the light.
    last: Option<(usize, Option<ShadowRay>)>,
}

impl<'a> Shadows<'a> {
    /// For triangles that stop a light, by `opacity`.
    pub fn new(opacity: &'a OpacityOfSides<'a>) -> Self {
        Self { opacity, last: None }
    }

    /// Whether `triangle`, which isn't the point's own, shadows the point at `index`, whose segment `shadow_ray` finds. For
    /// consecutive calls with one point the segment is found once.
    pub fn is_shadowed_by(
        &mut self,
        index: usize,
        triangle: u32,
        shadow_ray: impl FnOnce() -> Option<ShadowRay>,
    ) -> bool {
        let ray = match self.last {
            Some((known, ray)) if known == index => ray,
            _ => shadow_ray(),
        };
        self.last = Some((index, ray));
        ray.is_some_and(|ray| is_blocked(self.opacity, &ray, triangle))
    }
}

/// Whether a triangle shadows the end point of `ray`, a light's; the triangle isn't the point's own.
pub fn is_blocked(opacity: &OpacityOfSides<'_>, ray: &ShadowRay, triangle: u32) -> bool {
    let Ok(corners) = opacity.triangles.usable_corners(triangle) else { return false };
    let opacity: &dyn Opacity = opacity;
    ray.blocked_by(corners).is_some_and(|barycentric| opacity.is_stopped_at(triangle, barycentric))
}
