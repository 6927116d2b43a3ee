use std::ops::ControlFlow;

use crate::single::{Visit, answers_single_rays};
use umbrage_rays::{Ray, Triangles};

use super::BackgroundKdTree;
use crate::kdtree::moving::grown::{self, Line, Start};

/// Error bound of sums of planes and drifts, for each unit of the largest coordinate: four roundings.
const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

answers_single_rays!(BackgroundKdTree);

impl Visit for BackgroundKdTree {
    fn visit(
        &self,
        _: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let tree = &self.current.tree;
        if self.is_still() {
            return tree.visit(Triangles::default(), ray, test);
        }
        let start = match Line::start(&self.extent, ray) {
            Start::Line(line) => {
                let reach = f64::from(tree.extent().reach()) * ROUNDING;
                line.with(ray.origin.to_array(), ray.direction.to_array(), [reach; 3])
            }
            other => other,
        };
        grown::visit(tree, start, ray.t_max, |index| f64::from(self.drift[index as usize]), test)
    }
}
