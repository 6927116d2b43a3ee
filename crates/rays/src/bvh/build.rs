use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::{PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use super::Bvh;
use crate::Triangles;

impl Bvh {
    /// Most triangles in a leaf.
    pub(super) const LEAF_TRIANGLES: u32 = 4;

    /// Replaces the hierarchy by one over `triangles`, on all threads of the current pool.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        self.collect_boxes(triangles);
        let mut order = std::mem::take(&mut self.tree.primitive_indices);
        order.clear();
        order.extend(0..self.boxes.len() as u32);
        self.builder.build_with_bvh(&mut self.tree, PlocSearchDistance::Low, &self.boxes, order, SortPrecision::U64, 2);
        const TRAVERSAL_COST: f32 = 1.0;
        collapse(&mut self.tree, Self::LEAF_TRIANGLES, TRAVERSAL_COST);
    }

    /// The boxes of all triangles that can be hit, in order of id.
    fn collect_boxes(&mut self, triangles: Triangles<'_>) {
        self.omitted = triangles.omitted();
        self.ids.clear();
        self.boxes.clear();
        let all = 0..triangles.len() as u32;
        if self.omitted.total() == 0 {
            self.ids.extend(all);
        } else {
            self.ids.extend(all.filter(|&id| triangles.usable_corners(id).is_ok()));
        }
        self.scale = scale_of(triangles.positions);
        let scale = self.scale;
        self.ids
            .par_iter()
            .map(|&id| box_around(triangles.corners(id).map(|corner| Vec3A::from(corner * scale))))
            .collect_into_vec(&mut self.boxes);
    }
}

/// What a scene's coordinates are multiplied with so that boxes have areas and rays have reciprocals: one but for scenes whose
/// coordinates are huge. What that loses of small ones is less than boxes are grown by.
fn scale_of(positions: &[Vec3]) -> f32 {
    const HUGE: f32 = (1_u64 << 40) as f32;
    const SCALE: f32 = 1.0 / (1_u128 << 100) as f32;
    let is_huge = positions.par_iter().with_min_len(1 << 14).any(|position| {
        let reach = position.abs().max_element();
        reach > HUGE && reach.is_finite()
    });
    if is_huge { SCALE } else { 1.0 }
}

fn box_around([a, b, c]: [Vec3A; 3]) -> Aabb {
    Aabb::new(a.min(b).min(c), a.max(b).max(c))
}
