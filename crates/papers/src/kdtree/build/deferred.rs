//! Subtrees that are built only when a ray first reaches them (Hunt, Mark and Fussell, *Fast and lazy build of acceleration
//! structures from scene hierarchies*, 2007, §3).
//!
//! A deferred leaf lists the ids of all its triangles, as any leaf does: code that knows nothing of subtrees may test those.
//!
//! The thread that comes first builds the subtree, alone, and threads that come meanwhile wait for it. It may not share the
//! work with its pool: while it waited for that, it might be handed a ray that waits for the same subtree.

use std::sync::OnceLock;

use super::sah::{Cell, Heuristic};
use super::{Job, Pool};
use crate::kdtree::extent::Reference;
use crate::kdtree::layout::Branch;
use crate::kdtree::{KdTree, KdTreeOptions, Whole};
use umbrage_rays::{Structure, Triangles};

/// Nodes of fewer references are built at once: the rest of a subtree would take more memory than their nodes.
const LEAST: usize = 32;

/// The subtrees of a tree that are built later, and the references that they are built of.
#[derive(Default)]
pub(in crate::kdtree) struct Deferred {
    subtrees: Vec<Subtree>,
    /// The references of all subtrees, one after the other. 28 bytes each.
    references: Vec<Reference>,
    /// The options with which the tree was built; the tree's own may have changed since.
    options: KdTreeOptions,
    /// The number of triangles in the tree that can be hit.
    usable: usize,
}

struct Subtree {
    cell: Cell,
    /// The index of its leaf's first id; it ascends from subtree to subtree.
    first_id: usize,
    first_reference: usize,
    built: OnceLock<Box<KdTree>>,
}

impl Deferred {
    pub(super) fn clear(&mut self, options: KdTreeOptions, usable: usize) {
        self.subtrees.clear();
        self.references.clear();
        (self.options, self.usable) = (options, usable);
    }

    /// Takes the references of all subtrees.
    pub(in crate::kdtree) fn take_references(&mut self, references: &mut Vec<Reference>) {
        std::mem::swap(&mut self.references, references);
    }

    /// Adds the subtree of a leaf with `count` ids, the next in their order.
    pub(in crate::kdtree) fn push(&mut self, cell: Cell, first_id: usize, first_reference: usize) {
        self.subtrees.push(Subtree { cell, first_id, first_reference, built: OnceLock::new() });
    }

    pub(in crate::kdtree) fn bytes(&self) -> usize {
        let built = self.subtrees.iter().filter_map(|subtree| subtree.built.get());
        self.subtrees.capacity() * size_of::<Subtree>()
            + self.references.capacity() * size_of::<Reference>()
            + built.map(|tree| size_of::<KdTree>() + tree.bytes().triangles).sum::<usize>()
    }

    /// Whether both defer the same subtrees, built or not.
    pub(in crate::kdtree) fn is_same_as(&self, other: &Self) -> bool {
        let key = |subtree: &Subtree| (subtree.first_id, subtree.cell.extent, subtree.cell.depth);
        self.subtrees.iter().map(key).eq(other.subtrees.iter().map(key))
            && self.references.iter().map(|r| (r.id, r.extent)).eq(other.references.iter().map(|r| (r.id, r.extent)))
    }

    /// The trees that rays have reached.
    pub(in crate::kdtree) fn reached(&self) -> impl Iterator<Item = &KdTree> {
        self.subtrees.iter().filter_map(|subtree| subtree.built.get().map(|tree| &**tree))
    }

    fn index(&self, first_id: usize) -> usize {
        self.subtrees.partition_point(|subtree| subtree.first_id < first_id)
    }

    /// The subtree of the leaf whose ids start at `first_id`, if a ray has reached it.
    pub(in crate::kdtree) fn get(&self, first_id: usize) -> Option<&KdTree> {
        self.subtrees[self.index(first_id)].built.get().map(|tree| &**tree)
    }

    /// The references that the subtree of the leaf whose ids start at `first_id` is built of.
    pub(in crate::kdtree) fn references(&self, first_id: usize) -> &[Reference] {
        self.references_at(self.index(first_id))
    }

    fn references_at(&self, index: usize) -> &[Reference] {
        let end = self.subtrees.get(index + 1).map_or(self.references.len(), |next| next.first_reference);
        &self.references[self.subtrees[index].first_reference..end]
    }
}

impl Job<'_> {
    /// Whether the subtree of `count` references in a cell is built later.
    pub(super) fn is_deferred(&self, count: usize, cell: &Cell) -> bool {
        (LEAST..self.lazy_below).contains(&count) && cell.depth < self.heuristic.max_depth
    }
}

impl KdTree {
    /// Returns the subtree of the leaf whose ids start at `first_id`, and builds it at the first call.
    #[cold]
    pub(in crate::kdtree) fn reach(&self, triangles: Triangles<'_>, first_id: usize) -> &Self {
        let index = self.deferred.index(first_id);
        let Subtree { cell, built, .. } = &self.deferred.subtrees[index];
        built.get_or_init(|| {
            let references = self.deferred.references_at(index);
            let whole = Whole { reach: self.extent.reach(), is_stretched: self.is_stretched };
            Box::new(build_subtree(triangles, &self.deferred, &self.pool, references, *cell, whole))
        })
    }
}

/// Returns the tree that would have been built of these references at once.
fn build_subtree(
    triangles: Triangles<'_>,
    deferred: &Deferred,
    pool: &Pool,
    references: &[Reference],
    cell: Cell,
    whole: Whole,
) -> KdTree {
    let Deferred { options, usable, .. } = deferred;
    let heuristic = Heuristic::new(options.costs, *usable);
    let job = Job { triangles, clipping: options.clipping, heuristic, lazy_below: 0, pool };
    let mut branch = Branch::default();
    job.grow_references(references, whole, options.builder, cell, &mut branch);
    let mut tree =
        KdTree { options: *options, extent: cell.extent, triangle_count: triangles.len(), branch, ..KdTree::default() };
    tree.lay_out();
    tree.branch = Branch::default();
    tree.ids.shrink_to_fit();
    tree
}
