//! Answers for single rays, for any structure that leads them to triangles.

mod filter;

use std::ops::ControlFlow;

use crate::predicate::{ShadowRay, hit};
use crate::{Hit, Ray, SeenPixels, Triangles};
pub use filter::Filter;

/// A structure that answers single rays, of any origin and direction.
///
/// `triangles` are always those that it was built over.
pub trait SingleRays: Sync {
    /// The nearest hit of `ray` for which `stops` is true; at equal t the one with the lowest triangle id. `None` for a
    /// miss.
    ///
    /// Hits for which `stops` is false are passed through: use it for alpha masks and back faces.
    fn nearest(&self, triangles: Triangles<'_>, ray: &Ray, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        self.nearest_from(triangles, ray, SeenPixels::NONE, stops)
    }

    /// As [`nearest`](Self::nearest), without the triangle `own`, on which the ray starts: its hit would be at a t of about
    /// zero, which takes the predicate longest.
    fn nearest_from(&self, triangles: Triangles<'_>, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit>;

    /// Whether any triangle but `own` shadows the point of `shadow_ray`.
    ///
    /// Triangles for which `stops`, given an id and the weights of the second and third vertex, is false let the light
    /// through.
    fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool;
}

/// A structure that leads single rays to triangles, and so [answers](SingleRays) them.
pub trait Visit: Sync {
    /// The largest magnitude of a coordinate of the triangles that `visit` may name.
    fn reach(&self) -> f32;

    /// Calls `test` with every triangle that `ray` may meet before `t_max`, roughly from near to far. `test` may lower
    /// `t_max` or break off. Some triangles may come more than once.
    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()>;
}

impl<V: Visit> SingleRays for V {
    fn nearest_from(&self, triangles: Triangles<'_>, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        // NaN rules nothing out during traversal, so such a ray would be tested against all triangles.
        if !ray.is_sound() {
            return None;
        }
        let filter = Filter::new(ray.origin, ray.direction);
        let mut nearest: Option<Hit> = None;
        let _ = self.visit(triangles, ray, |id, t_max| {
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

    fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        if !shadow_ray.ray.is_sound() {
            return false;
        }
        let filter = Filter::new(shadow_ray.ray.origin, shadow_ray.ray.direction);
        let visited = self.visit(triangles, &shadow_ray.ray, |id, _| {
            let corners = triangles.corners(id);
            let blocks = !filter.misses(corners)
                && id != own
                && shadow_ray.blocked_by(corners).is_some_and(|barycentric| stops(id, barycentric));
            if blocks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        visited.is_break()
    }
}
