//! Answers for single rays, by any structure that leads them to triangles.

mod filter;

use std::ops::ControlFlow;

use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{Hit, Ray, Triangles};

pub(crate) use filter::Filter;

/// A structure that leads single rays to triangles, and so [answers](umbrage_rays::SingleRays) them.
pub trait Visit: Sync {
    /// Calls `test` with every triangle that `ray` may meet before `t_max`, roughly from near to far. `test` may lower
    /// `t_max` or break off. Some triangles may come more than once.
    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()>;
}

/// Answers single rays by a type's [`Visit`]. The trait of another crate can't be implemented for all such types at once.
macro_rules! answers_single_rays {
    ($structure:ty) => {
        impl umbrage_rays::SingleRays for $structure {
            fn nearest_from(
                &self,
                triangles: umbrage_rays::Triangles<'_>,
                ray: &umbrage_rays::Ray,
                own: u32,
                stops: &dyn Fn(&umbrage_rays::Hit) -> bool,
            ) -> Option<umbrage_rays::Hit> {
                $crate::single::nearest_from(self, triangles, ray, own, stops)
            }

            fn blocked(
                &self,
                triangles: umbrage_rays::Triangles<'_>,
                shadow_ray: &umbrage_rays::predicate::ShadowRay,
                own: u32,
                stops: &dyn Fn(u32, [f32; 2]) -> bool,
            ) -> bool {
                $crate::single::blocked(self, triangles, shadow_ray, own, stops)
            }
        }
    };
}
pub(crate) use answers_single_rays;

/// As [`SingleRays::nearest_from`](umbrage_rays::SingleRays::nearest_from).
#[inline]
pub(crate) fn nearest_from(
    structure: &impl Visit,
    triangles: Triangles<'_>,
    ray: &Ray,
    own: u32,
    stops: &dyn Fn(&Hit) -> bool,
) -> Option<Hit> {
    // NaN rules nothing out during traversal, so such a ray would be tested against all triangles.
    if !ray.is_sound() {
        return None;
    }
    let filter = Filter::new(ray.origin, ray.direction);
    let mut nearest: Option<Hit> = None;
    let _ = structure.visit(triangles, ray, |id, t_max| {
        if id == own || filter.misses(triangles.corners(id)) {
            return ControlFlow::Continue(());
        }
        if let Some(hit) = hit(ray, triangles, id)
            && nearest.is_none_or(|best| (hit.t, id) < (best.t, best.triangle))
            && stops(&hit)
        {
            *t_max = hit.t;
            nearest = Some(hit);
        }
        ControlFlow::Continue(())
    });
    nearest
}

/// As [`SingleRays::blocked`](umbrage_rays::SingleRays::blocked).
#[inline]
pub(crate) fn blocked(
    structure: &impl Visit,
    triangles: Triangles<'_>,
    shadow_ray: &ShadowRay,
    own: u32,
    stops: &dyn Fn(u32, [f32; 2]) -> bool,
) -> bool {
    if !shadow_ray.ray.is_sound() {
        return false;
    }
    let filter = Filter::new(shadow_ray.ray.origin, shadow_ray.ray.direction);
    let visited = structure.visit(triangles, &shadow_ray.ray, |id, _| {
        let corners = triangles.corners(id);
        let blocks = !filter.misses(corners)
            && id != own
            && shadow_ray.blocked_by(corners).is_some_and(|barycentric| stops(id, barycentric));
        if blocks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    visited.is_break()
}
