use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Bvh, Hit, KdTree, Ray, Triangles, UniformGrid};

/// The structure for rays that come one at a time.
#[derive(Clone, Copy, Debug)]
pub(super) enum SingleRays<'a> {
    Grid(&'a UniformGrid),
    KdTree(&'a KdTree),
    Bvh(&'a Bvh),
}

impl SingleRays<'_> {
    /// As [`Bvh::nearest`].
    pub(super) fn nearest(self, triangles: Triangles<'_>, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        match self {
            Self::Grid(grid) => grid.nearest(triangles, ray, counts),
            Self::KdTree(tree) => tree.nearest(triangles, ray, counts),
            Self::Bvh(bvh) => bvh.nearest(triangles, ray, counts),
        }
    }

    /// As [`Bvh::blocked`].
    pub(super) fn blocked(
        self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        counts: impl Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        match self {
            Self::Grid(grid) => grid.blocked(triangles, shadow_ray, own, counts),
            Self::KdTree(tree) => tree.blocked(triangles, shadow_ray, own, counts),
            Self::Bvh(bvh) => bvh.blocked(triangles, shadow_ray, own, counts),
        }
    }
}
