//! The two-level kd-tree: a tree for each object, and one over the boxes of all objects, so that only the trees of changed
//! objects are built again (Wald, Benthin and Slusallek, *Distributed Interactive Ray Tracing of Dynamic Scenes*, 2003; Lext
//! and Akenine-Möller, *Towards Rapid Reconstruction for Animated Ray Tracing*, 2001; thesis §4.2).
//!
//! Two other structures are forms of it. The **gkDtree** (Kang et al., *gkDtree: A group-based parallel update kd-tree for
//! interactive ray tracing*, 2013) keeps the trees of groups that stay and builds those that move. **Fuzzy kd-trees**
//! (Günther et al., *Ray Tracing Animated Scenes using Motion Decomposition*, 2006) have one for each part of an object that
//! moves nearly as a whole, over boxes that hold each triangle in all poses, relative to that motion. [`KdMoved`] chooses.
//!
//! Rays hit the frame's triangles in world space, as everywhere. A tree may stay as it was built, over triangles at rest;
//! `moved` leads a ray through it and shows why no hit is missed. The motion of an object isn't given: `rest` finds the
//! affine map that takes it back best, and measures how far that leaves each of its vertices from rest.

mod fit;
mod moved;
mod packets;
mod rest;
mod trace;
mod update;
mod validate;

use crate::kdtree::Extent;
use crate::kdtree::packet::PacketRays as _;
use crate::{ImpossibleKdTreeOptions, KdTree, KdTreeCounts, KdTreeOptions, SahCosts};
use umbrage_rays::debug_some;
use umbrage_rays::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use umbrage_rays::{ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles};

pub use fit::fit;
use moved::Moved;
use rest::Rest;

/// The treatment of an object that has moved since its tree was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdMoved {
    /// Its tree is built again: the gkDtree, whose static groups are those that didn't move.
    Rebuild,
    /// Its tree is kept, and rays are moved to the object's former place, if one affine map takes all of its vertices back
    /// there to within 1/4096 of its size; else its tree is built again.
    #[default]
    Transform,
    /// As `Transform`, for each [part](umbrage_rays::Parts) of objects, whose tree is over boxes that hold each triangle
    /// where the map takes it: the fuzzy kd-tree. Boxes hold all poses that the tree was
    /// [prepared](TwoLevelKdTree::prepare) for; those that a frame leaves by more than 1/512 of the part's size are
    /// enlarged, and the part's tree is built over them.
    Enclose,
}

/// A kd-tree for each of a scene's objects, and one over their boxes.
///
/// Keep it, and [update](Self::update) it for each frame. It takes the memory of its objects' [trees](KdTree), 16 bytes for
/// each triangle and vertex, and 24 for each vertex of a part in boxes.
pub struct TwoLevelKdTree {
    /// The options of objects' trees.
    options: KdTreeOptions,
    level: SimdLevel,
    moved: KdMoved,
    objects: Vec<Object>,
    /// The tree over the boxes of objects that rays can hit.
    top: KdTree,
    /// Objects through whose trees rays go in packets.
    together: Vec<usize>,
    omitted: Omitted,
    triangle_count: usize,
}

/// Triangles that move together, and data of them that is kept from frame to frame.
struct Object {
    /// The object or the part of the frame's [`Parts`](umbrage_rays::Parts).
    key: u32,
    /// Ids of the triangles in the frame, ascending, and their vertices. The tree lists indices of these.
    ids: Vec<u32>,
    indices: Vec<[u32; 3]>,
    tree: KdTree,
    rest: Rest,
    state: State,
    /// The bounds in this frame.
    extent: Extent,
}

/// The relation of an object to its tree.
enum State {
    /// Nothing is known of it.
    New,
    /// The tree was built for this frame.
    Built,
    /// It hasn't moved since the tree was built.
    Still,
    /// It has moved, and rays have to be moved to it; true if its tree was built over larger boxes for this frame.
    Moved(Box<Moved>, bool),
}

/// Counts of a [`TwoLevelKdTree`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoLevelCounts {
    /// The number of objects, or of parts.
    pub objects: u64,
    /// Those of them whose trees were built in the last update.
    pub rebuilt: u64,
    /// Those to which rays are moved.
    pub moved: u64,
    /// Counts of the tree over objects' boxes, which are its references.
    pub top: KdTreeCounts,
    /// Nodes of objects' trees.
    pub nodes: u64,
    /// Triangles in all leaves of objects' trees.
    pub references: u64,
}

debug_some!(TwoLevelKdTree as tree: "objects" => tree.objects.len(), "triangles" => tree.triangle_count);

impl TwoLevelKdTree {
    /// An empty tree whose packets use the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel, moved: KdMoved) -> Self {
        let mut top = KdTree::default();
        // A test of an object traverses its tree.
        let costs = SahCosts { test: 20.0, ..KdTreeOptions::DEFAULT.costs };
        top.set_options(KdTreeOptions { costs, ..KdTreeOptions::DEFAULT }).expect("possible options");
        let (options, omitted) = (KdTreeOptions::DEFAULT, Omitted::default());
        Self { options, level, moved, objects: Vec::new(), top, together: Vec::new(), omitted, triangle_count: 0 }
    }

    /// An empty tree.
    #[must_use]
    pub fn new(moved: KdMoved) -> Self {
        Self::with_level(SimdLevel::default(), moved)
    }

    /// Sets the options for building objects' trees, and for traversing all trees, from now on. None is
    /// [lazy](KdTreeOptions::lazy_below), and trees that rays are moved to are traversed with a stack, by single rays.
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

    /// Counts of the trees; all zeros before the first update.
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
    /// Whether the object hasn't moved since its tree was built.
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
        self.update(triangles, umbrage_rays::Parts::default());
    }

    fn build_parts(&mut self, triangles: Triangles<'_>, parts: umbrage_rays::Parts<'_>) {
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
