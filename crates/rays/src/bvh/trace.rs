use std::ops::ControlFlow;

use glam::Vec3A;
use obvhs::bvh2::node::Bvh2Node;

use super::Bvh;
use crate::{Ray, Triangles, Visit};

impl Visit for Bvh {
    fn reach(&self) -> f32 {
        let root = self.tree.nodes.first();
        root.map_or(0.0, |root| root.aabb.min.abs().max(root.aabb.max.abs()).max_element() / self.scale)
    }

    /// Calls `test` with every triangle whose box `ray` may meet before `t_max`, nearer boxes first. `test` may lower
    /// `t_max` or break off.
    fn visit(
        &self,
        _: Triangles<'_>,
        ray: &Ray,
        mut test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(root) = self.tree.nodes.first() else { return ControlFlow::Continue(()) };
        let slabs = Slabs::new(ray, f64::from(self.scale));
        let mut t_max = ray.t_max;
        if slabs.enter(root, t_max).is_none() {
            return ControlFlow::Continue(());
        }
        self.visit_below(0, &slabs, &mut t_max, &mut test)
    }
}

impl Bvh {
    fn visit_below(
        &self,
        subtree: u32,
        slabs: &Slabs,
        t_max: &mut f64,
        test: &mut impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        const STACK: usize = 64;
        let mut stack = [(0_u32, 0.0_f32); STACK];
        let mut waiting = 0;
        let mut next = Some(subtree);
        while let Some(index) = next.take() {
            let node = &self.tree.nodes[index as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                for &index in &self.tree.primitive_indices[first..first + node.prim_count as usize] {
                    test(self.ids[index as usize], t_max)?;
                }
            } else {
                let children = [node.first_index, node.first_index + 1];
                let enters = children.map(|child| slabs.enter(&self.tree.nodes[child as usize], *t_max));
                let near = match enters {
                    [Some(left), Some(right)] => {
                        let (near, far, far_enters) = if left <= right { (0, 1, right) } else { (1, 0, left) };
                        if waiting == STACK {
                            // Deeper than any tree that isn't degenerate: a stack of its own for the far side.
                            self.visit_below(children[far], slabs, t_max, test)?;
                        } else {
                            stack[waiting] = (children[far], far_enters);
                            waiting += 1;
                        }
                        Some(near)
                    }
                    [Some(_), None] => Some(0),
                    [None, Some(_)] => Some(1),
                    [None, None] => None,
                };
                next = near.map(|near| children[near]);
            }
            while next.is_none() && waiting > 0 {
                waiting -= 1;
                let (index, enters) = stack[waiting];
                next = (!slabs.is_beyond(enters, *t_max)).then_some(index);
            }
        }
        ControlFlow::Continue(())
    }
}

/// A ray prepared for box tests in f32 that err only towards a hit.
///
/// With ε = 2⁻²⁴, rounding moves the origin by ε·|o| and each slab's t by 3 ε·|t|: from the difference, the reciprocal
/// and the product. Boxes are grown by more than twice the one, and intervals by more than twice the other.
struct Slabs {
    /// What is taken from a box's lowest corner: the origin, and what the box grows by.
    above_origin: Vec3A,
    /// What is taken from a box's highest corner: the origin, less what the box grows by.
    below_origin: Vec3A,
    inverse: Vec3A,
    /// The ray's own t, times this, is the t of the box tests.
    scale: f64,
    t_min: f32,
}

impl Slabs {
    const RELATIVE_MARGIN: f32 = 4.0 * f32::EPSILON;

    /// For boxes whose coordinates are `unit` times those of the ray.
    fn new(ray: &Ray, unit: f64) -> Self {
        let length = ray.direction.abs().max_element();
        let direction = ray.direction / length;
        let scale = length * unit;
        // A ray along a slab has no crossing with it: a finite stand-in for 1/0 gives it one that is so far away, for
        // every box that holds the ray once grown by `SMALLEST`, that it doesn't matter.
        const STEEPEST: f64 = 1e38;
        const SMALLEST: f32 = 1e-20;
        let inverse = direction.to_array().map(|component| {
            let inverse = component.signum() * component.abs().recip().min(STEEPEST);
            inverse as f32
        });
        let origin = Vec3A::from((ray.origin * unit).as_vec3());
        let growth = origin.abs() * (2.0 * f32::EPSILON) + SMALLEST;
        let t_min = (ray.t_min * scale) as f32;
        Self {
            above_origin: origin + growth,
            below_origin: origin - growth,
            inverse: Vec3A::from_array(inverse),
            scale,
            t_min: t_min - t_min.abs() * Self::RELATIVE_MARGIN,
        }
    }

    /// Where the ray may enter a node's box at the earliest; `None` when it certainly misses it before `t_max`.
    fn enter(&self, node: &Bvh2Node, t_max: f64) -> Option<f32> {
        let first = (node.aabb.min - self.above_origin) * self.inverse;
        let second = (node.aabb.max - self.below_origin) * self.inverse;
        let (near, far) = (first.min(second), first.max(second));
        let enter = (near - near.abs() * Self::RELATIVE_MARGIN).max_element().max(self.t_min);
        let leave = (far + far.abs() * Self::RELATIVE_MARGIN).min_element();
        // What overflows is no number, and above nothing.
        let is_missed = enter > leave || self.is_beyond(enter, t_max);
        (!is_missed).then_some(enter)
    }

    fn is_beyond(&self, enter: f32, t_max: f64) -> bool {
        f64::from(enter) > t_max * self.scale
    }
}
