use super::extent::Plane;

/// A node. 8 bytes (Wald, *Realtime Ray Tracing and Interactive Global Illumination*, 2004, §7.2).
///
/// | | first word | second word, from its lowest bit |
/// |---|---|---|
/// | inner node | the plane's coordinate | its axis in two bits, a child's index |
/// | leaf | the index of its first id | two bits that are set, the number of ids, a bit for a subtree |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Node {
    /// Bits of the plane's coordinate, or the index of the first id.
    first: u32,
    second: u32,
}

impl Node {
    const LEAF: u32 = 3;
    /// Bit of a leaf whose subtree is built when a ray reaches it.
    const DEFERRED: u32 = 1 << 31;
    /// The largest number of nodes of a tree; a leaf has at most half as many ids.
    pub(super) const MOST: u64 = 1 << 30;

    pub(super) fn inner(plane: Plane, child: u32) -> Self {
        Self { first: plane.at.to_bits(), second: child << 2 | plane.axis as u32 }
    }

    pub(super) fn leaf(start: u32, count: u32) -> Self {
        Self { first: start, second: count << 2 | Self::LEAF }
    }

    /// A leaf that a subtree replaces later.
    pub(super) fn deferred(start: u32, count: u32) -> Self {
        Self { first: start, second: Self::DEFERRED | count << 2 | Self::LEAF }
    }

    /// Whether it has ids instead of children.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.second & 3 == Self::LEAF
    }

    /// Whether the subtree of a leaf is built later.
    #[inline(always)]
    pub(super) fn is_deferred(self) -> bool {
        self.second & Self::DEFERRED != 0
    }

    /// The plane of an inner node.
    #[inline(always)]
    pub fn plane(self) -> Plane {
        Plane { axis: (self.second & 3) as usize, at: f32::from_bits(self.first) }
    }

    /// The index of a child of an inner node.
    #[inline(always)]
    pub fn child(self) -> u32 {
        self.second >> 2
    }

    /// The range of a leaf's ids.
    #[inline(always)]
    pub fn ids(self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count()
    }

    /// The number of a leaf's ids.
    #[inline(always)]
    pub fn count(self) -> usize {
        ((self.second & !Self::DEFERRED) >> 2) as usize
    }
}

/// Nodes that share a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(64))]
struct Line([Node; Nodes::LINE]);

/// All nodes, the root first.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Nodes {
    lines: Vec<Line>,
    /// The number of slots that are taken, padding among them.
    len: usize,
    /// All ones if the left child follows its parent and `child` is the right one; zero if `child` is the left one, which
    /// the right one follows.
    left_follows: u32,
}

impl Nodes {
    /// The number of nodes in a cache line.
    pub(super) const LINE: usize = 8;
    /// The largest number of inner nodes above a leaf.
    pub const MAX_DEPTH: usize = 48;

    pub(super) fn clear(&mut self, left_follows: bool) {
        self.lines.clear();
        self.len = 0;
        self.left_follows = if left_follows { u32::MAX } else { 0 };
    }

    /// The number of slots for nodes, padding among them.
    #[expect(clippy::len_without_is_empty, reason = "a built tree has a root")]
    pub fn len(&self) -> usize {
        self.len
    }

    pub(super) fn bytes(&self) -> usize {
        self.lines.capacity() * size_of::<Line>()
    }

    /// Makes room for nodes up to index `len`.
    pub(super) fn grow_to(&mut self, len: usize) {
        self.len = self.len.max(len);
        self.lines.resize(self.len.div_ceil(Self::LINE), Line::default());
    }

    pub(super) fn set(&mut self, index: usize, node: Node) {
        self.lines[index / Self::LINE].0[index % Self::LINE] = node;
    }

    /// The node at an index.
    #[inline(always)]
    pub fn get(&self, index: u32) -> Node {
        self.lines[index as usize / Self::LINE].0[index as usize % Self::LINE]
    }

    /// The indices of the left and the right child of the inner node at `index`.
    #[inline(always)]
    pub fn children(&self, index: u32, node: Node) -> [u32; 2] {
        let child = node.child();
        let follows = self.left_follows;
        [((index + 1) & follows) | (child & !follows), child + (!follows & 1)]
    }
}
