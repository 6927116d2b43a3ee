//! A bounding volume hierarchy for all rays: the baseline that other structures are compared with.
//!
//! Built by obvhs (PLOC: Meister and Bittner, *Parallel Locally-Ordered Clustering*, 2018); traversal is ours, since it
//! must never cull what the [predicate](crate::predicate) would hit.

mod build;
mod trace;
mod validate;

use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::PlocBuilder;

use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightSource, Omitted, SingleRays, Structure, Triangles, ray_by_ray};

/// A bounding volume hierarchy over one frame's triangles.
///
/// About 210 bytes a triangle, counting what is only used while building. Keep it and rebuild it: its memory is reused.
#[derive(Default)]
pub struct Bvh {
    tree: Bvh2,
    builder: PlocBuilder,
    boxes: Vec<obvhs::aabb::Aabb>,
    /// What coordinates are multiplied with in all boxes: a power of two.
    scale: f32,
    /// Triangle id of each box.
    ids: Vec<u32>,
    omitted: Omitted,
}

debug_some!(Bvh as bvh: "triangles" => bvh.ids.len(), "nodes" => bvh.tree.nodes.len());

impl Bvh {
    /// All nodes, the root first.
    #[doc(hidden)]
    #[must_use]
    pub fn nodes(&self) -> &[Bvh2Node] {
        &self.tree.nodes
    }

    /// The ids of a leaf's triangles.
    #[doc(hidden)]
    pub fn triangles_of(&self, leaf: &Bvh2Node) -> impl Iterator<Item = u32> {
        let first = leaf.first_index as usize;
        let indices = &self.tree.primitive_indices[first..first + leaf.prim_count as usize];
        indices.iter().map(|&index| self.ids[index as usize])
    }
}

impl Structure for Bvh {
    fn build(&mut self, triangles: Triangles<'_>) {
        Self::build(self, triangles);
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        ray_by_ray::see(self, shot, seen);
        Ok(Work::default())
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        ray_by_ray::shadow(self, shot, seen, lights, masks);
        Work::default()
    }

    fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    fn bytes(&self) -> Bytes {
        let triangles = size_of_val(self.tree.nodes.as_slice())
            + size_of_val(self.tree.primitive_indices.as_slice())
            + size_of_val(self.builder.current_nodes.as_slice())
            + size_of_val(self.builder.next_nodes.as_slice())
            + size_of_val(self.builder.mortons.as_slice())
            + size_of_val(self.boxes.as_slice())
            + size_of_val(self.ids.as_slice());
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}
