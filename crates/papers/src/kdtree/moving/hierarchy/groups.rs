use crate::KdTree;

/// Neighbouring triangles of a scene in groups of groups, from a tree that was built for an earlier frame. Without
/// positions, the groups stay valid when triangles move.
///
/// About 6 bytes a triangle.
#[derive(Clone, Debug, Default)]
pub(super) struct SceneHierarchy {
    /// Triangle ids, leaf after leaf; each once.
    order: Vec<u32>,
    /// Depth first.
    groups: Vec<Group>,
}

/// A part of the order, and of the groups. 12 bytes.
#[derive(Clone, Copy, Debug)]
struct Group {
    first: u32,
    end: u32,
    /// The index after the last group inside.
    next: u32,
}

impl SceneHierarchy {
    /// The largest number of triangles in a group without groups: leaves of more are parted in the order of ids.
    const LARGEST: usize = 16;

    /// Returns the hierarchy of a kd-tree that was built over some frame's `triangle_count` triangles; a triangle of several
    /// leaves belongs to the first.
    ///
    /// # Panics
    /// If it was built over more.
    pub(super) fn of_tree(tree: &KdTree, triangle_count: usize) -> Self {
        let mut hierarchy = UnfinishedHierarchy::new(triangle_count);
        if tree.nodes().len() > 0 {
            hierarchy.below(tree, 0);
        }
        hierarchy.finish()
    }

    /// The number of triangles.
    pub(super) fn len(&self) -> usize {
        self.order.len()
    }

    pub(super) fn bytes(&self) -> usize {
        self.order.capacity() * size_of::<u32>() + self.groups.capacity() * size_of::<Group>()
    }

    /// The number of groups, which hold triangles or other groups; the root is the first.
    pub(super) fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The groups inside of a group.
    pub(super) fn groups_in(&self, group: usize) -> impl Iterator<Item = usize> {
        let end = self.groups[group].next as usize;
        let mut next = group + 1;
        std::iter::from_fn(move || {
            let index = next;
            next = if index < end { self.groups[index].next as usize } else { index };
            (index < end).then_some(index)
        })
    }

    /// The ids of a group that has no groups inside.
    pub(super) fn ids_in(&self, group: usize) -> Option<&[u32]> {
        let Group { first, end, next } = self.groups[group];
        (next as usize == group + 1).then(|| &self.order[first as usize..end as usize])
    }

    fn open(&mut self) -> usize {
        let first = self.order.len() as u32;
        self.groups.push(Group { first, end: first, next: 0 });
        self.groups.len() - 1
    }

    fn close(&mut self, group: usize) {
        self.groups[group].end = self.order.len() as u32;
        self.groups[group].next = self.groups.len() as u32;
    }
}

/// A hierarchy that is being made, with a flag for each triangle that it lists.
struct UnfinishedHierarchy {
    all: SceneHierarchy,
    root: usize,
    is_listed: Vec<bool>,
}

impl UnfinishedHierarchy {
    fn new(count: usize) -> Self {
        let mut all = SceneHierarchy::default();
        let root = all.open();
        Self { all, root, is_listed: vec![false; count] }
    }

    fn leaf(&mut self, ids: impl Iterator<Item = u32>) {
        let group = self.all.open();
        for id in ids {
            if !std::mem::replace(&mut self.is_listed[id as usize], true) {
                self.all.order.push(id);
            }
        }
        self.all.close(group);
    }

    fn below(&mut self, tree: &KdTree, index: u32) {
        let node = tree.nodes().get(index);
        if node.is_leaf() {
            let ids = &tree.ids()[node.ids()];
            for ids in ids.chunks(SceneHierarchy::LARGEST) {
                self.leaf(ids.iter().copied());
            }
            return;
        }
        let group = self.all.open();
        for child in tree.nodes().children(index, node) {
            self.below(tree, child);
        }
        self.all.close(group);
    }

    /// Adds triangles that no ray could hit then, but that may be hit in another frame.
    fn finish(mut self) -> SceneHierarchy {
        let missing: Vec<_> =
            (0..).zip(&self.is_listed).filter(|(_, is_listed)| !**is_listed).map(|(id, _)| id).collect();
        for ids in missing.chunks(SceneHierarchy::LARGEST) {
            self.leaf(ids.iter().copied());
        }
        self.all.close(self.root);
        self.all
    }
}
