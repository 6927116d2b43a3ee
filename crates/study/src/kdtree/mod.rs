//! Trees for moving scenes: with one for each object, built beside tracing, or from a hierarchy that is known already.
//!
//! `hierarchy` says which triangles lie together, and `hierarchical` builds from it without looking at all of them. `two_level`
//! has a tree for each object and `background` one that is built while another is traced; in both, triangles may have moved since
//! the tree was built, and `grown` leads rays through that. All will serve scenes that move.

mod background;
mod grown;
mod hierarchical;
mod hierarchy;
mod two_level;

pub use background::{BackgroundKdTree, ImpossibleBackground, KdAge, RebuildPolicy};
pub use hierarchical::build_from;
pub use hierarchy::{ImpossibleHierarchy, SceneHierarchy};
pub use two_level::{ImpossibleObjects, KdMotion, KdObject, TwoLevelCounts, TwoLevelKdTree};
