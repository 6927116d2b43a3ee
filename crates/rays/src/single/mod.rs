//! What is asked of rays that come one at a time, whatever leads them to triangles.

mod filter;

use std::ops::ControlFlow;

use crate::predicate::{ShadowRay, hit};
use crate::{Hit, Ray, Triangles};
use filter::Filter;

/// A structure that leads single rays to triangles.
pub trait Visit {
    /// The largest magnitude of the coordinates of triangles that `visit` may name.
    fn reach(&self) -> f32;

    /// Calls `test` with every triangle that `ray` may meet before `t_max`, roughly from near to far. `test` may lower
    /// `t_max` or break off. Some triangles may come more than once.
    fn visit(&self, ray: &Ray, test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()>;
}

/// The nearest hit that `counts`; at equal t the one with the lowest triangle id. `None` for a miss.
pub fn nearest(
    structure: &impl Visit,
    triangles: Triangles<'_>,
    ray: &Ray,
    counts: impl Fn(&Hit) -> bool,
) -> Option<Hit> {
    let filter = Filter::new(ray.origin, ray.direction, structure.reach());
    let mut nearest: Option<Hit> = None;
    let _ = structure.visit(ray, |id, t_max| {
        if filter.misses(triangles.corners(id)) {
            return ControlFlow::Continue(());
        }
        if let Some(hit) = hit(ray, triangles, id)
            && nearest.is_none_or(|best| (hit.t, id) < (best.t, best.triangle))
            && counts(&hit)
        {
            *t_max = hit.t;
            nearest = Some(hit);
        }
        ControlFlow::Continue(())
    });
    nearest
}

/// Whether any triangle but `own` that `counts` shadows the point of `shadow_ray`.
pub fn blocked(
    structure: &impl Visit,
    triangles: Triangles<'_>,
    shadow_ray: &ShadowRay,
    own: u32,
    counts: impl Fn(u32, [f32; 2]) -> bool,
) -> bool {
    let filter = Filter::new(shadow_ray.ray.origin, shadow_ray.ray.direction, structure.reach());
    let visited = structure.visit(&shadow_ray.ray, |id, _| {
        let corners = triangles.corners(id);
        let blocks = !filter.misses(corners)
            && id != own
            && shadow_ray.blocked_by(corners).is_some_and(|barycentric| counts(id, barycentric));
        if blocks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    visited.is_break()
}
