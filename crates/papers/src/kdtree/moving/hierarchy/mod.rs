//! A tree that is built anew for each frame, from groups of neighbouring triangles in the first frame's tree.
//!
//! `groups` takes the groups from that tree, and `build` makes trees of them.

mod build;
mod groups;

use crate::{ImpossibleKdTreeOptions, KdTree, KdTreeOptions};
use build::build_from;
use groups::SceneHierarchy;
use umbrage_rays::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use umbrage_rays::{ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles};

/// A kd-tree that is built for each frame from a hierarchy, which comes from the tree of the first frame and serves as long
/// as triangles have the same vertices (Hunt, Mark and Fussell, *Fast and lazy build of acceleration structures from scene
/// hierarchies*, 2007; thesis §4.2).
#[derive(Debug, Default)]
pub struct HierarchyKdTree {
    tree: KdTree,
    hierarchy: SceneHierarchy,
    /// The indices that the hierarchy is for.
    indices: Vec<[u32; 3]>,
}

impl HierarchyKdTree {
    /// An empty tree whose packets use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { tree: KdTree::with_level(level), ..Self::default() }
    }

    /// Sets the options for building and traversing trees from now on.
    ///
    /// # Errors
    /// As [`KdTree::set_options`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        self.tree.set_options(options)
    }

    /// The tree of the last frame.
    #[must_use]
    pub fn tree(&self) -> &KdTree {
        &self.tree
    }
}

impl Structure for HierarchyKdTree {
    fn build(&mut self, triangles: Triangles<'_>) {
        if self.hierarchy.len() == triangles.len() && self.indices == triangles.indices {
            build_from(&mut self.tree, triangles, &self.hierarchy);
            return;
        }
        let options = self.tree.options();
        // Subtrees that wait for rays have no groups yet.
        self.tree.set_options(KdTreeOptions { lazy_below: 0, ..options }).expect("options that were checked");
        self.tree.build(triangles);
        self.hierarchy = SceneHierarchy::of_tree(&self.tree, triangles.len());
        self.indices.clear();
        self.indices.extend_from_slice(triangles.indices);
        self.tree.set_options(options).expect("options that were checked");
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        self.tree.see(shot, seen)
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        self.tree.shadow(shot, seen, lights, masks)
    }

    fn omitted(&self) -> &Omitted {
        self.tree.omitted()
    }

    fn bytes(&self) -> Bytes {
        let own = self.hierarchy.bytes() + self.indices.capacity() * size_of::<[u32; 3]>();
        Bytes { triangles: self.tree.bytes().triangles + own, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.tree.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(&self.tree)
    }
}
