use std::ops::ControlFlow;

use umbrage_rays::{Ray, Triangles, Visit};

use super::TwoLevelKdTree;

impl Visit for TwoLevelKdTree {
    fn reach(&self) -> f32 {
        self.top.extent().reach()
    }

    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let top = &self.top;
        if top.nodes().len() == 0 {
            return ControlFlow::Continue(());
        }
        top.visit(Triangles::default(), ray, |object, t_max| {
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
                _ => object.tree.visit(object.of(triangles), &ray, test),
            }
        })
    }
}
