//! Trees for moving scenes, which outlive the frame that they were built for: one for each object, one that is built beside
//! tracing, or one from a hierarchy that is known already. [`KdRebuild`] chooses.
//!
//! `two_level` has a tree for each object and `background` one that is built while another is traced; in both, triangles may
//! have moved since the tree was built, and `grown` leads rays through such a tree. `hierarchy` keeps groups of neighbouring
//! triangles, and builds from them without looking at all triangles.

pub(super) mod background;
mod grown;
pub(super) mod hierarchy;
pub(super) mod two_level;

/// The treatment of a kd-tree when a frame's triangles have moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdRebuild {
    /// It is built from scratch for each frame, as [`KdTree`](crate::KdTree) is.
    #[default]
    Whole,
    /// The same, from groups of neighbouring triangles in the first frame's tree:
    /// [`HierarchyKdTree`](crate::HierarchyKdTree).
    Hierarchy,
    /// It is built on threads of its own while rays go through the one before:
    /// [`BackgroundKdTree`](crate::BackgroundKdTree).
    Background,
    /// Each object has a tree, to which rays are moved if the object moved as a whole:
    /// [`KdMoved::Transform`](crate::KdMoved::Transform).
    TwoLevel,
    /// Each object has a tree, which is built again if the object moved: [`KdMoved::Rebuild`](crate::KdMoved::Rebuild).
    Groups,
    /// Each part has a tree, over boxes that hold its triangles in all frames so far:
    /// [`KdMoved::Enclose`](crate::KdMoved::Enclose).
    Fuzzy,
}
