use std::ops::ControlFlow;

use umbrage_rays::internals::{self, Visit};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Hit, Ray, Triangles};

use super::BackgroundKdTree;
use crate::kdtree::grown::{self, Line, Start};

/// What sums of planes and drifts may be wrong by, for each unit of the largest coordinate: four roundings.
const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

impl BackgroundKdTree {
    /// The nearest hit of `ray` among the triangles of the current frame; at equal t the one with the lowest triangle id. `None`
    /// for a miss.
    ///
    /// Hits that `counts` refuses are passed through: use it for alpha masks and back faces.
    #[must_use]
    pub fn nearest(&self, triangles: Triangles<'_>, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        internals::nearest(self, triangles, ray, counts)
    }

    /// Whether any triangle but `own` shadows the point of `shadow_ray`.
    ///
    /// Triangles for which `counts`, given an id and the weights of the second and third corner, is false let the
    /// light through.
    #[must_use]
    pub fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        counts: impl Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        internals::blocked(self, triangles, shadow_ray, own, counts)
    }
}

impl Visit for BackgroundKdTree {
    fn reach(&self) -> f32 {
        self.extent.reach()
    }

    fn visit(&self, ray: &Ray, test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()> {
        let tree = &self.current.tree;
        if self.drift.first().is_none_or(|&drift| drift == 0.0) {
            return tree.within(Triangles::default()).visit(ray, test);
        }
        let start = match Line::start(&self.extent, ray) {
            Start::Line(line) => {
                let reach = f64::from(tree.extent().reach()) * ROUNDING;
                line.with(ray.origin.to_array(), ray.direction.to_array(), [reach; 3])
            }
            other => other,
        };
        grown::visit(tree, start, ray.t_max, |place| f64::from(self.drift[place as usize]), test)
    }
}
