//! The kd-tree: space cut in two by planes across an axis, recursively, by the surface area heuristic (Wald and Havran, *On
//! building fast kd-trees for ray tracing, and on doing that in O(N log N)*, 2006; Horn et al., *Interactive k-D Tree GPU
//! Raytracing*, 2007).
//!
//! `extent` has boxes and cuts triangles' boxes at planes, `build` finds the planes, `node` and `layout` define nodes in
//! memory. `traverse` leads single rays to leaves, and `packet` packets of rays. `options` has the options, `names` their
//! names, and `statistics` the counts of a tree. `moving` has trees that outlive a frame, `gpu` the way of rays on a GPU.
//!
//! **Why no hit is missed.** Planes are f32 and so are the corners of triangles, and both are compared exactly: a triangle
//! with a part strictly on one side of a plane is listed on that side, one inside the plane on one of both. So the cells of
//! the leaves that list a triangle, with their faces, cover it, in real numbers. The predicate accepts a hit only if the
//! ray's line meets the triangle in real numbers, so a ray finds it if it visits every leaf whose cell, with its faces,
//! holds the point of the hit. `traverse` shows that traversals do so. A subtree that is built later takes the place of a
//! leaf, in the same cell.

mod build;
mod extent;
#[cfg(feature = "gpu")]
pub mod gpu;
mod layout;
mod moving;
mod names;
mod node;
mod options;
mod packet;
mod statistics;
mod stretch;
mod traverse;
mod validate;

use crate::statistics::Tally;
pub(crate) use build::{Cell, Job, SplitCandidate};
use build::{Deferred, Pool, Reused};
pub use extent::{Extent, Plane};
pub(crate) use extent::{Reference, Sides};
pub(crate) use layout::Branch;
pub use moving::KdRebuild;
pub use moving::background::{BackgroundKdTree, ImpossibleBackground, KdAge, RebuildPolicy};
pub use moving::hierarchy::HierarchyKdTree;
pub use moving::two_level::{KdMoved, TwoLevelCounts, TwoLevelKdTree, fit};
pub use node::{Node, Nodes};
pub use options::{Clipping, ImpossibleKdTreeOptions, KdBuilder, KdLayout, KdTraversal, KdTreeOptions, SahCosts};
use packet::PacketRays as _;
pub use packet::{
    Ask, Filter, HALF_ULP, KdMailbox, KdPacketOptions, KdPacketWidth, LANES, MOST_RAYS, Rays, Scale, Wide, load,
};
pub use statistics::KdTreeCounts;
pub(crate) use stretch::Whole;
use umbrage_rays::debug_some;
use umbrage_rays::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use umbrage_rays::{ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles};

/// The triangles of a frame, listed in the cells of a kd-tree.
///
/// Eight bytes a node and four a reference: about 55 bytes for each triangle of the Bunny, and of any scene no more than
/// 250, since [`KdTree::MOST_REFERENCES`] bounds both. Building takes several times as much on two threads: 500 to 1300
/// bytes a triangle, up to 2500 where threads share nodes, and 500 to 810 with the binned builder. Keep it and rebuild
/// it: its memory is reused.
#[derive(Default)]
pub struct KdTree {
    options: KdTreeOptions,
    level: SimdLevel,
    /// Empty before the first build.
    nodes: Nodes,
    /// Triangle ids, leaf after leaf, ascending in each.
    ids: Vec<u32>,
    /// The bounds of all usable triangles.
    extent: Extent,
    /// Whether many triangles are tiny compared to `extent`. Rays are then traced alone instead of in packets, whose f32
    /// coordinates would tell hardly any triangles apart.
    is_stretched: bool,
    triangle_count: usize,
    omitted: Omitted,
    branch: Branch,
    deferred: Deferred,
    pool: Pool,
    visits: Tally,
}

debug_some!(
    KdTree as tree:
    "triangles" => tree.triangle_count,
    "nodes" => tree.nodes.len(),
    "references" => tree.ids.len()
);

impl KdTree {
    /// The largest number of references, and of leaves, for each triangle, besides [`KdTree::LEAST_LIMIT`].
    pub const MOST_REFERENCES: u64 = 12;

    /// The largest number of references, and of leaves, that even the smallest tree may have.
    pub const LEAST_LIMIT: u64 = 64;

    /// An empty tree whose packets use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Sets the options: those of building and layout count from the next build on, those of traversal from now on.
    ///
    /// # Errors
    /// As [`KdTreeOptions::check`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// The options of the tree.
    #[must_use]
    pub fn options(&self) -> KdTreeOptions {
        self.options
    }

    /// All nodes.
    #[doc(hidden)]
    #[must_use]
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Triangle ids, leaf after leaf, ascending in each.
    #[doc(hidden)]
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The instructions that packets use.
    #[doc(hidden)]
    #[must_use]
    pub fn level(&self) -> SimdLevel {
        self.level
    }

    /// The box around all triangles that can be hit.
    #[doc(hidden)]
    #[must_use]
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Whether two trees have the same nodes, in the same order, and list the same triangles in them, regardless of the
    /// subtrees that rays have [reached](KdTreeCounts::reached).
    #[must_use]
    pub fn is_same_as(&self, other: &Self) -> bool {
        self.nodes == other.nodes
            && self.ids == other.ids
            && self.extent == other.extent
            && self.deferred.is_same_as(&other.deferred)
    }
}

impl Structure for KdTree {
    fn build(&mut self, triangles: Triangles<'_>) {
        Self::build(self, triangles);
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.see_packets(shot, seen);
        Ok(Work::default())
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        self.shadow_all(shot, seen, lights, masks);
        Work::default()
    }

    fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    fn bytes(&self) -> Bytes {
        let triangles = self.nodes.bytes()
            + self.ids.capacity() * size_of::<u32>()
            + self.branch.bytes()
            + self.deferred.bytes()
            + self.pool.bytes();
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}
