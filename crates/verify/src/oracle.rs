use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{Hit, Ray, Triangles};

/// The truth: every triangle is asked, in order, by the reference predicate.
#[derive(Clone, Copy, Debug)]
pub struct Oracle<'a> {
    triangles: Triangles<'a>,
}

impl<'a> Oracle<'a> {
    /// The truth about `triangles`.
    #[must_use]
    pub fn new(triangles: Triangles<'a>) -> Self {
        Self { triangles }
    }

    /// The nearest hit that `counts`; of several at the same t the one with the lowest id.
    #[must_use]
    pub fn nearest(&self, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for triangle in 0..self.triangles.len() as u32 {
            let Some(hit) = hit(ray, self.triangles, triangle) else { continue };
            if nearest.is_none_or(|best| hit.t < best.t) && counts(&hit) {
                nearest = Some(hit);
            }
        }
        nearest
    }

    /// Whether a triangle other than `own` that `counts` shadows the point of `shadow_ray`.
    #[must_use]
    pub fn blocked(&self, shadow_ray: &ShadowRay, own: u32, counts: impl Fn(u32, [f32; 2]) -> bool) -> bool {
        (0..self.triangles.len() as u32).filter(|&id| id != own).any(|id| {
            shadow_ray.blocked_by(self.triangles.corners(id)).is_some_and(|barycentric| counts(id, barycentric))
        })
    }
}
