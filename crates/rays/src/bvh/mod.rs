//! A bounding volume hierarchy for all rays, incoherent ones above all.
//!
//! Nodes have up to eight children, whose boxes a ray is tested against at once (Wald, Benthin and Boulos, *Getting rid of
//! packets*, 2008); leaves hold the corners of up to eight triangles, tested at once as well. Both tests are in f32 and err
//! only towards a hit, so the [predicate](crate::predicate) tests the triangle that a ray hits and few others.

mod build;
mod instances;
mod leaf;
mod line;
mod many;
mod motion;
mod patched;
mod split;
mod trace;
mod validate;

use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles, ray_by_ray};
use build::Builder;
pub use instances::{InstanceTree, InstancedTriangles, Placement};
pub use leaf::{Leaf, LeafHits};
pub use line::{LESS, Line, MORE, Slabs};
pub(crate) use many::First;
pub use motion::{Key, MotionTree, MovingTriangles};
use patched::Patched;
pub use trace::{Inside, Nearest};

/// The largest number of children of a node.
pub const WIDTH: usize = 8;

/// A bounding volume hierarchy over one frame's triangles.
///
/// Keep it and rebuild it: its memory is reused.
#[derive(Default)]
pub struct Bvh {
    level: SimdLevel,
    /// Empty where there are no triangles.
    nodes: Vec<Node>,
    root: Child,
    leaves: Vec<Leaf>,
    /// Factor for coordinates in all boxes and leaves: a power of two.
    scale: f32,
    /// A separate hierarchy for triangles too large for the scale of the others, where there are both.
    far: Option<Box<Bvh>>,
    builder: Builder,
    patched: Patched,
    omitted: Omitted,
}

debug_some!(Bvh as bvh: "nodes" => bvh.nodes.len(), "leaves" => bvh.leaves.len());

/// An inner node: 224 bytes.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub struct Node {
    /// The lowest and the highest x of each child's box, then y, then z. Where there is no child, the box is inverted and
    /// infinite, so no ray meets it.
    pub bounds: [[f32; WIDTH]; 6],
    /// Nodes and leaves; [`Child::NONE`] in unused slots.
    pub children: [Child; WIDTH],
}

impl Node {
    const EMPTY: Self = {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { bounds: [low, high, low, high, low, high], children: [Child::NONE; WIDTH] }
    };
}

/// A node's index; or, with the highest bit set, a leaf's index and below it its number of triangles minus one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Child(u32);

impl Child {
    /// No child.
    pub const NONE: Self = Self(u32::MAX);
    const LEAF: u32 = 1 << 31;
    const COUNT_BITS: u32 = 3;

    fn node(index: usize) -> Self {
        Self(index as u32)
    }

    fn leaf(index: usize, triangles: usize) -> Self {
        debug_assert!((1..=Leaf::LANES).contains(&triangles), "a leaf of {triangles} triangles");
        Self(Self::LEAF | (index as u32) << Self::COUNT_BITS | (triangles as u32 - 1))
    }

    /// The node; or the leaf, and a bit for each of its triangles.
    #[inline(always)]
    pub fn kind(self) -> Kind {
        if self.0 & Self::LEAF == 0 {
            return Kind::Node(self.0 as usize);
        }
        let index = (self.0 & !Self::LEAF) >> Self::COUNT_BITS;
        let last = self.0 & ((1 << Self::COUNT_BITS) - 1);
        Kind::Leaf { index: index as usize, lanes: (2 << last) - 1 }
    }
}

/// The kind of a [`Child`].
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A node's index.
    Node(usize),
    /// A leaf.
    Leaf {
        /// Its index.
        index: usize,
        /// A bit for each of its triangles.
        lanes: u32,
    },
}

impl Bvh {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
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
        let triangles = self.nodes.capacity() * size_of::<Node>()
            + self.leaves.capacity() * size_of::<Leaf>()
            + self.builder.bytes()
            + self.patched.bytes()
            + self.far.as_ref().map_or(0, |far| far.bytes().triangles);
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}
