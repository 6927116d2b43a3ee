use std::ops::ControlFlow;

use super::TwoLevelKdTree;
use crate::{Ray, Triangles, Visit};

impl Visit for TwoLevelKdTree {
    fn reach(&self) -> f32 {
        self.top.extent.reach()
    }

    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let top = &self.top;
        if top.nodes.len() == 0 {
            return ControlFlow::Continue(());
        }
        top.within(Triangles::default()).visit(ray, |object, t_max| {
            let object = &self.objects[object as usize];
            let ray = Ray { t_max: *t_max, ..*ray };
            let first = object.triangles.start;
            let test = |id: u32, end: &mut f64| {
                test(first + id, t_max)?;
                *end = *t_max;
                ControlFlow::Continue(())
            };
            match &object.rest {
                Some(rest) if !object.is_rebuilt => rest.visit(&object.tree, &object.extent, &ray, test),
                _ => {
                    let mut within = object.tree.within(object.of(triangles));
                    within.traversal = self.options.traversal;
                    within.visit(&ray, test)
                }
            }
        })
    }
}
