//! Trees for moving scenes, which outlive the frame that they were built for: with one for each object, built beside tracing,
//! or from a hierarchy that is known already. [`KdRebuild`] says what there is to choose.
//!
//! `two_level` has a tree for each object and `background` one that is built while another is traced; in both, triangles may
//! have moved since the tree was built, and `grown` leads rays through that. `hierarchy` says which triangles lie together,
//! and builds from it without looking at all of them.

pub(super) mod background;
mod grown;
pub(super) mod hierarchy;
pub(super) mod two_level;

/// What is done about a kd-tree when a frame's triangles are elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdRebuild {
    /// It is built from scratch for each frame, as [`KdTree`](crate::KdTree) is.
    #[default]
    Whole,
    /// The same, with the first frame's tree to say which triangles lie together: [`HierarchyKdTree`](crate::HierarchyKdTree).
    Hierarchy,
    /// It is built on threads of its own while rays go through the one before: [`BackgroundKdTree`](crate::BackgroundKdTree).
    Background,
    /// Each object has a tree, to which rays are moved where the object moved as a whole:
    /// [`KdMoved::Transform`](crate::KdMoved::Transform).
    TwoLevel,
    /// Each object has a tree, which is built again where the object moved: [`KdMoved::Rebuild`](crate::KdMoved::Rebuild).
    Groups,
    /// Each part has a tree, over boxes that hold its triangles in all frames so far:
    /// [`KdMoved::Enclose`](crate::KdMoved::Enclose).
    Fuzzy,
}
