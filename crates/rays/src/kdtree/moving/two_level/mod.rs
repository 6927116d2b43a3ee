//! The two-level kd-tree: a tree for each object, and one over the boxes of all objects, so that only what changed is built
//! again (Wald, Benthin and Slusallek, *Distributed Interactive Ray Tracing of Dynamic Scenes*, 2003; Lext and
//! Akenine-Möller, *Towards Rapid Reconstruction for Animated Ray Tracing*, 2001; thesis §4.2).
//!
//! Two other structures are forms of it. The **gkDtree** (Kang et al., *gkDtree: A group-based parallel update kd-tree for
//! interactive ray tracing*, 2013) keeps the trees of groups that stay and builds those that move. **Fuzzy kd-trees** (Günther et
//! al., *Ray Tracing Animated Scenes using Motion Decomposition*, 2006) have one for each part of an object that moves nearly
//! as a whole, over boxes that hold each triangle wherever it is, beside that motion. [`KdMoved`] chooses.
//!
//! What rays hit are the frame's triangles in world space, as everywhere. A tree may stay as it was built, where the triangles
//! were then; `moved` leads a ray through it and says why nothing is missed. Nobody says how an object moves: `rest` finds the
//! affine map that takes it back best, and measures how far that leaves each of its vertices.

mod fit;
mod moved;
mod packets;
mod rest;
mod trace;
mod update;
mod validate;

use crate::kdtree::Extent;
use crate::kdtree::packet::PacketRays as _;
use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::{
    ImageTooLarge, ImpossibleKdTreeOptions, KdTree, KdTreeCounts, KdTreeOptions, LightSource, Omitted, SahCosts,
    SimdLevel, SingleRays, Structure, Triangles,
};

pub use fit::fit;
use moved::Moved;
use rest::Rest;

/// What is done about an object that isn't where it was when its tree was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdMoved {
    /// Its tree is built again: the gkDtree, whose static groups are those that didn't move.
    Rebuild,
    /// Its tree is kept, and rays are moved to where the object was, if one affine map takes all of its vertices back there to
    /// within 1/4096 of its size; else its tree is built again.
    #[default]
    Transform,
    /// As `Transform`, for each [part](crate::Parts) of objects, whose tree is over boxes that hold each triangle where the map
    /// takes it: the fuzzy kd-tree. Boxes hold all poses that the tree was [prepared](TwoLevelKdTree::prepare) for; those that
    /// a frame leaves by more than 1/512 of the part's size are enlarged, and the part's tree is built over them.
    Enclose,
}

/// A kd-tree for each of a scene's objects, and one over their boxes.
///
/// Keep it, and [update](Self::update) it for each frame. It takes what its objects' [trees](KdTree) take, 16 bytes for each
/// triangle and vertex, and 24 for each vertex of a part in boxes.
pub struct TwoLevelKdTree {
    /// Of objects' trees.
    options: KdTreeOptions,
    level: SimdLevel,
    moved: KdMoved,
    objects: Vec<Object>,
    /// Over the boxes of objects that rays can hit.
    top: KdTree,
    /// Objects through whose trees rays go in packets.
    together: Vec<usize>,
    omitted: Omitted,
    triangle_count: usize,
}

/// Triangles that move together, and what is kept of them from frame to frame.
struct Object {
    /// The object or the part of the frame's [`Parts`](crate::Parts).
    key: u32,
    /// Ids of the triangles in the frame, ascending, and their vertices. The tree lists indices of these.
    ids: Vec<u32>,
    indices: Vec<[u32; 3]>,
    tree: KdTree,
    rest: Rest,
    state: State,
    /// In this frame.
    extent: Extent,
}

/// How an object came to where it is.
enum State {
    /// Nothing is known of it.
    New,
    /// The tree was built for this frame.
    Built,
    /// It is where the tree was built.
    Still,
    /// Rays have to be moved to it; and whether its tree was built over larger boxes for this frame.
    Moved(Box<Moved>, bool),
}

/// What a [`TwoLevelKdTree`] is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoLevelCounts {
    /// Objects, or parts.
    pub objects: u64,
    /// Those of them whose trees were built in the last update.
    pub rebuilt: u64,
    /// Those to which rays are moved.
    pub moved: u64,
    /// Of the tree over objects' boxes, which are its references.
    pub top: KdTreeCounts,
    /// Nodes of objects' trees.
    pub nodes: u64,
    /// Triangles in all leaves of objects' trees.
    pub references: u64,
}

debug_some!(TwoLevelKdTree as tree: "objects" => tree.objects.len(), "triangles" => tree.triangle_count);

impl TwoLevelKdTree {
    /// Nothing yet, with packets that use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel, moved: KdMoved) -> Self {
        let mut top = KdTree::default();
        // An object is a tree to go through.
        let costs = SahCosts { test: 20.0, ..KdTreeOptions::DEFAULT.costs };
        top.set_options(KdTreeOptions { costs, ..KdTreeOptions::DEFAULT }).expect("possible options");
        let (options, omitted) = (KdTreeOptions::DEFAULT, Omitted::default());
        Self { options, level, moved, objects: Vec::new(), top, together: Vec::new(), omitted, triangle_count: 0 }
    }

    /// Nothing yet.
    #[must_use]
    pub fn new(moved: KdMoved) -> Self {
        Self::with_level(SimdLevel::default(), moved)
    }

    /// Says how trees of objects are built from now on, and how all are traversed. None is [lazy](KdTreeOptions::lazy_below),
    /// and those that rays are moved to are
    /// traversed with a stack, by single rays.
    ///
    /// # Errors
    /// As [`KdTree::set_options`].
    pub fn set_options(&mut self, options: KdTreeOptions) -> Result<(), ImpossibleKdTreeOptions> {
        options.check()?;
        self.options = KdTreeOptions { lazy_below: 0, ..options };
        for tree in self.objects.iter_mut().map(|object| &mut object.tree).chain([&mut self.top]) {
            tree.set_options(KdTreeOptions { traversal: options.traversal, ..tree.options() })?;
        }
        Ok(())
    }

    /// What the trees are like; all zeros before the first update.
    #[must_use]
    pub fn counts(&self) -> TwoLevelCounts {
        let mut counts =
            TwoLevelCounts { objects: self.objects.len() as u64, top: self.top.counts(), ..Default::default() };
        for object in &self.objects {
            let KdTreeCounts { nodes, references, .. } = object.tree.counts();
            counts.nodes += nodes;
            counts.references += references;
            counts.rebuilt += u64::from(matches!(object.state, State::Built | State::Moved(_, true)));
            counts.moved += u64::from(matches!(object.state, State::Moved(..)));
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

impl Object {
    /// Whether the tree lies where the triangles are.
    fn is_in_place(&self) -> bool {
        !matches!(self.state, State::Moved(..))
    }

    /// The object's triangles; their ids start at zero.
    fn of<'a>(&'a self, triangles: Triangles<'a>) -> Triangles<'a> {
        Triangles { indices: &self.indices, ..triangles }
    }
}

impl Structure for TwoLevelKdTree {
    fn build(&mut self, triangles: Triangles<'_>) {
        self.update(triangles, crate::Parts::default());
    }

    fn build_parts(&mut self, triangles: Triangles<'_>, parts: crate::Parts<'_>) {
        self.update(triangles, parts);
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
        let of_object = |object: &Object| {
            object.tree.bytes().triangles
                + object.rest.bytes()
                + object.ids.capacity() * size_of::<u32>()
                + object.indices.capacity() * size_of::<[u32; 3]>()
        };
        let triangles = self.objects.iter().map(of_object).sum::<usize>()
            + self.objects.capacity() * size_of::<Object>()
            + self.top.bytes().triangles;
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}
