//! The structures and experiments of the papers that Umbrage follows.
//!
//! [`structures`] lists all structures with their options, for command lines, windows, tests and benches. With the feature
//! `gpu` rays go through the kd-tree on a GPU as well. The rest needs the feature `experiments`: builders, traversals and triangle
//! tests that no product uses. `umbrage-bench` measures these, and their tests hold them to the same predicate as the
//! product.
#![forbid(unsafe_code)]

#[doc(hidden)]
pub mod kdtree;
mod listed;
mod packet;
#[cfg(test)]
#[allow(dead_code, reason = "some of it is for other tests")]
#[path = "../../rays/src/random.rs"]
mod random;
mod single;
mod statistics;
mod structures;
pub mod uniform;

#[cfg(feature = "gpu")]
pub use kdtree::gpu::{KdNodes, KdSight, KdTracerOptions};
pub use kdtree::{
    BackgroundKdTree, Clipping, HierarchyKdTree, ImpossibleBackground, ImpossibleKdTreeOptions, KdAge, KdBuilder,
    KdLayout, KdMailbox, KdMoved, KdPacketOptions, KdPacketWidth, KdRebuild, KdTraversal, KdTree, KdTreeCounts,
    KdTreeOptions, RebuildPolicy, SahCosts, TwoLevelCounts, TwoLevelKdTree,
};
pub use listed::{
    Cells, ImpossibleCells, ImpossibleLightCells, LightMapping, ListedGrids, ListedLightOptions, ListedOptions,
};
pub use single::Visit;
pub use structures::{KdTrees, Listed, Uniform, structures};
pub use uniform::{ImpossibleUniformOptions, Insertion, PacketSide, UniformGrid, UniformOptions};

#[cfg(feature = "experiments")]
pub mod clusters;
#[cfg(feature = "experiments")]
pub mod gpu_kdtree;
#[cfg(feature = "experiments")]
pub mod kd_tasks;
#[cfg(all(test, feature = "gpu"))]
#[allow(dead_code, reason = "some of it is for other tests")]
#[path = "../../gpu/src/layout.rs"]
mod layout;
#[cfg(feature = "experiments")]
pub mod light_buffer;
#[cfg(feature = "experiments")]
pub mod on_demand;
#[cfg(feature = "experiments")]
pub mod queue;
#[cfg(feature = "experiments")]
pub mod reorder;
#[cfg(feature = "experiments")]
pub mod shaft;
#[cfg(feature = "experiments")]
pub mod triangle;
