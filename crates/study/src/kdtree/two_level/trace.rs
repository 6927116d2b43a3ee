use std::ops::ControlFlow;

use umbrage_rays::internals::{self, Visit};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Hit, Ray, Triangles};

use super::TwoLevelKdTree;

impl TwoLevelKdTree {
    /// The nearest hit of `ray` among the triangles that the last update was for; at equal t the one with the lowest triangle
    /// id. `None` for a miss.
    ///
    /// Hits that `counts` refuses are passed through: use it for alpha masks and back faces.
    #[must_use]
    pub fn nearest(&self, triangles: Triangles<'_>, ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Option<Hit> {
        internals::nearest(&Objects { trees: self, triangles }, triangles, ray, counts)
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
        internals::blocked(&Objects { trees: self, triangles }, triangles, shadow_ray, own, counts)
    }
}

struct Objects<'a> {
    trees: &'a TwoLevelKdTree,
    triangles: Triangles<'a>,
}

impl Visit for Objects<'_> {
    fn reach(&self) -> f32 {
        self.trees.top.extent().reach()
    }

    fn visit(&self, ray: &Ray, mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>) -> ControlFlow<()> {
        let top = &self.trees.top;
        if top.nodes().len() == 0 {
            return ControlFlow::Continue(());
        }
        top.within(Triangles::default()).visit(ray, |object, t_max| {
            let object = &self.trees.objects[object as usize];
            let ray = Ray { t_max: *t_max, ..*ray };
            let first = object.triangles.start;
            let test = |id: u32, end: &mut f64| {
                test(first + id, t_max)?;
                *end = *t_max;
                ControlFlow::Continue(())
            };
            match &object.rest {
                Some(rest) if !object.is_rebuilt => rest.visit(&object.tree, &object.extent, &ray, test),
                _ => object.tree.within(object.of(self.triangles)).visit(&ray, test),
            }
        })
    }
}
