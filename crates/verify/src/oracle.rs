use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{Hit, Ray, Triangles};

/// The truth: the reference predicate tests every triangle, in order.
#[derive(Clone, Debug)]
pub struct Oracle<'a> {
    triangles: Triangles<'a>,
    /// Ids of triangles whose corners all exist and are finite.
    usable: Vec<u32>,
}

impl<'a> Oracle<'a> {
    /// An oracle for `triangles`.
    #[must_use]
    pub fn new(triangles: Triangles<'a>) -> Self {
        let is_usable = |&id: &u32| {
            let mut corners =
                triangles.indices[id as usize].iter().map(|&vertex| triangles.positions.get(vertex as usize));
            corners.all(|corner| corner.is_some_and(|corner| corner.is_finite()))
        };
        Self { triangles, usable: (0..triangles.len() as u32).filter(is_usable).collect() }
    }

    /// The nearest hit for which `stops` is true; of several at the same t the one with the lowest id.
    #[must_use]
    pub fn nearest(&self, ray: &Ray, stops: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for &triangle in &self.usable {
            let Some(hit) = hit(ray, self.triangles, triangle) else { continue };
            if nearest.is_none_or(|best| hit.t < best.t) && stops(&hit) {
                nearest = Some(hit);
            }
        }
        nearest
    }

    /// Whether a triangle other than `own` shadows the point of `shadow_ray` where `stops` is true.
    #[must_use]
    pub fn blocked(&self, shadow_ray: &ShadowRay, own: u32, stops: impl Fn(u32, [f32; 2]) -> bool) -> bool {
        self.usable.iter().filter(|&&id| id != own).any(|&id| {
            shadow_ray.blocked_by(self.triangles.corners(id)).is_some_and(|barycentric| stops(id, barycentric))
        })
    }
}
