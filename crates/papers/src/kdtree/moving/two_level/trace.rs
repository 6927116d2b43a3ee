use std::ops::ControlFlow;

use super::{State, TwoLevelKdTree};
use crate::single::{Visit, answers_single_rays};
use umbrage_rays::{Ray, Triangles};

answers_single_rays!(TwoLevelKdTree);

impl Visit for TwoLevelKdTree {
    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.visit_some(triangles, ray, |_| true, test)
    }
}

impl TwoLevelKdTree {
    /// As [`visit`](Visit::visit), for those objects for which `counts`, given their index, is true.
    pub(super) fn visit_some(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        counts: impl Fn(usize) -> bool,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let top = &self.top;
        if top.nodes().len() == 0 {
            return ControlFlow::Continue(());
        }
        top.visit(Triangles::default(), ray, |object, t_max| {
            if !counts(object as usize) {
                return ControlFlow::Continue(());
            }
            let object = &self.objects[object as usize];
            let ray = Ray { t_max: *t_max, ..*ray };
            let test = |index: u32, end: &mut f64| {
                test(object.ids[index as usize], t_max)?;
                *end = *t_max;
                ControlFlow::Continue(())
            };
            match &object.state {
                State::Moved(moved, _) => moved.visit(&object.tree, &object.extent, &ray, test),
                _ => object.tree.visit(object.of(triangles), &ray, test),
            }
        })
    }
}
