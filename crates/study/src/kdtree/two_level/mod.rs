//! The two-level kd-tree: a tree for each object, and one over the boxes of all objects, so that only what changed is built
//! again (Wald, Benthin and Slusallek, *Distributed Interactive Ray Tracing of Dynamic Scenes*, 2003; Lext and
//! Akenine-Möller, *Towards Rapid Reconstruction for Animated Ray Tracing*, 2001; thesis §4.3).
//!
//! What rays hit are the frame's triangles in world space, as everywhere. A rigid object's tree stays as it was built, over
//! where the triangles were then; `moved` leads a ray through it and says why nothing is missed.

mod moved;
mod trace;
mod update;
mod validate;

use std::ops::Range;

use glam::DAffine3;

use umbrage_rays::internals::Extent;
use umbrage_rays::{ImpossibleKdTreeOptions, KdTree, KdTreeCounts, KdTreeOptions, Omitted, SahCosts, Structure as _};

use moved::Rest;

/// How an object's triangles come to where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KdMotion {
    /// They stay where they were when the object was first seen: nothing is done in later frames. What rays hit is undefined,
    /// though never unsound, if they moved nevertheless.
    Static,
    /// All are moved by one affine map. The object's tree is kept while that is where they are, to within about 1/4000 of the
    /// object's size, which is measured at each vertex; else it is built again.
    Rigid {
        /// From any space in which the object doesn't change.
        world_from_object: DAffine3,
    },
    /// Anyhow: the object's tree is built for each frame.
    Deforming,
}

/// Triangles that move together.
#[derive(Clone, Debug, PartialEq)]
pub struct KdObject {
    /// Ids of the object's triangles.
    pub triangles: Range<u32>,
    /// How they move.
    pub motion: KdMotion,
}

/// A kd-tree for each of a scene's objects, and one over their boxes.
///
/// Keep it, and [update](Self::update) it for each frame. It takes what its objects' [trees](KdTree) take, and 16 bytes for
/// each vertex of a rigid object.
pub struct TwoLevelKdTree {
    /// Of objects' trees.
    options: KdTreeOptions,
    objects: Vec<Object>,
    /// Over the boxes of objects that rays can hit.
    top: KdTree,
    omitted: Omitted,
    triangle_count: usize,
    rebuilt: u64,
}

/// An object, and what is kept of it from frame to frame.
struct Object {
    triangles: Range<u32>,
    motion: KdMotion,
    tree: KdTree,
    /// In this frame.
    extent: Extent,
    /// Of a rigid object.
    rest: Option<Rest>,
    /// Whether its tree was built for this frame.
    is_rebuilt: bool,
}

/// What a [`TwoLevelKdTree`] is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoLevelCounts {
    /// Objects, those without triangles among them.
    pub objects: u64,
    /// Objects whose trees were built in the last update.
    pub rebuilt: u64,
    /// Of the tree over objects' boxes, which are its references.
    pub top: KdTreeCounts,
    /// Nodes of objects' trees.
    pub nodes: u64,
    /// Triangles in all leaves of objects' trees.
    pub references: u64,
}

/// Objects that aren't those of the triangles.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpossibleObjects {
    /// The triangles of an object, given by its index, don't follow those of the object before it.
    #[error("the triangles of object {0} don't follow those of the object before it")]
    Order(usize),
    /// All objects together have so many triangles, and the frame has as many as the second number says.
    #[error("objects have {0} triangles, and the frame has {1}")]
    Count(usize, usize),
}

impl Default for TwoLevelKdTree {
    fn default() -> Self {
        let mut top = KdTree::default();
        // An object is a tree to go through.
        let costs = SahCosts { test: 20.0, ..KdTreeOptions::DEFAULT.costs };
        top.set_options(KdTreeOptions { costs, ..KdTreeOptions::DEFAULT }).expect("possible options");
        let options = KdTreeOptions::DEFAULT;
        Self { options, objects: Vec::new(), top, omitted: Omitted::default(), triangle_count: 0, rebuilt: 0 }
    }
}

impl std::fmt::Debug for TwoLevelKdTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TwoLevelKdTree")
            .field("objects", &self.objects.len())
            .field("triangles", &self.triangle_count)
            .finish_non_exhaustive()
    }
}

impl TwoLevelKdTree {
    /// Says how trees of objects are built from now on, and how all are traversed. Trees of rigid objects are built at once
    /// even where the options are [lazy](KdTreeOptions::lazy_below).
    ///
    /// # Errors
    /// As [`KdTree::set_options`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        options.check()?;
        self.options = options;
        for tree in self.objects.iter_mut().map(|object| &mut object.tree).chain([&mut self.top]) {
            tree.set_options(KdTreeOptions { traversal: options.traversal, ..tree.options() })?;
        }
        Ok(())
    }

    /// How trees of objects are built.
    #[must_use]
    pub fn options(&self) -> KdTreeOptions {
        self.options
    }

    /// The triangles that were left out because no ray can hit them, of each object as its tree was last built.
    #[must_use]
    pub fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// Bytes held, counting what is only used while building.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let object = |object: &Object| object.tree.bytes().triangles + object.rest.as_ref().map_or(0, Rest::bytes);
        self.objects.iter().map(object).sum::<usize>()
            + self.objects.capacity() * size_of::<Object>()
            + self.top.bytes().triangles
    }

    /// What the trees are like; all zeros before the first update.
    #[must_use]
    pub fn counts(&self) -> TwoLevelCounts {
        let (objects, rebuilt) = (self.objects.len() as u64, self.rebuilt);
        let mut counts = TwoLevelCounts { objects, rebuilt, top: self.top.counts(), ..TwoLevelCounts::default() };
        for of_object in self.objects.iter().map(|object| object.tree.counts()) {
            counts.nodes += of_object.nodes;
            counts.references += of_object.references;
        }
        counts
    }

    /// Whether two have the same trees.
    #[must_use]
    pub fn is_same_as(&self, other: &Self) -> bool {
        let of_objects = self.objects.iter().zip(&other.objects);
        self.objects.len() == other.objects.len()
            && self.top.is_same_as(&other.top)
            && of_objects.into_iter().all(|(a, b)| a.tree.is_same_as(&b.tree) && a.extent == b.extent)
    }
}
