use std::ops::Range;

use umbrage_rays::{Bvh, KdTree};

use super::ImpossibleObjects;

/// Which triangles of a scene lie together, in groups of groups: a scene graph, or what is left of a structure that was built
/// for an earlier frame. It doesn't say where they are, so nothing gets wrong when they move.
///
/// [`build_from`](super::build_from) builds a tree of it. About 6 bytes a triangle.
#[derive(Clone, Debug, Default)]
pub struct SceneHierarchy {
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

/// A hierarchy that isn't of a frame's triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the hierarchy has {hierarchy} triangles, and the frame has {frame}")]
pub struct ImpossibleHierarchy {
    /// Triangles of the hierarchy.
    pub hierarchy: usize,
    /// Triangles of the frame.
    pub frame: usize,
}

impl SceneHierarchy {
    /// Larger groups that aren't parted are halved in the order of ids.
    const LARGEST: usize = 16;

    /// Of objects, by ids of their triangles. Triangles of an object whose ids are close should lie close together, as those
    /// of meshes mostly do.
    ///
    /// # Errors
    /// If an object's triangles don't follow those of the object before.
    pub fn of_objects(objects: impl IntoIterator<Item = Range<u32>>) -> Result<Self, ImpossibleObjects> {
        let mut hierarchy = Self::default();
        let root = hierarchy.open();
        let mut end = 0;
        for (index, object) in objects.into_iter().enumerate() {
            if object.start != end || object.end < object.start {
                return Err(ImpossibleObjects::Order(index));
            }
            end = object.end;
            hierarchy.halve(object);
        }
        hierarchy.close(root);
        Ok(hierarchy)
    }

    /// Of a bounding volume hierarchy that was built over some frame's `triangle_count` triangles.
    ///
    /// # Panics
    /// If it was built over more.
    #[must_use]
    pub fn of_bvh(bvh: &Bvh, triangle_count: usize) -> Self {
        #[derive(Clone)]
        enum Step {
            Enter(usize),
            Leave(usize),
        }
        let nodes = bvh.nodes();
        let mut hierarchy = Rest::new(triangle_count);
        let mut steps = vec![Step::Enter(0); usize::from(!nodes.is_empty())];
        while let Some(step) = steps.pop() {
            match step {
                Step::Leave(group) => hierarchy.all.close(group),
                Step::Enter(index) if nodes[index].is_leaf() => hierarchy.leaf(bvh.triangles_of(&nodes[index])),
                Step::Enter(index) => {
                    let child = nodes[index].first_index as usize;
                    steps.extend([Step::Leave(hierarchy.all.open()), Step::Enter(child + 1), Step::Enter(child)]);
                }
            }
        }
        hierarchy.finish()
    }

    /// Of a kd-tree that was built over some frame's `triangle_count` triangles; a triangle of several leaves belongs to the
    /// first.
    ///
    /// # Panics
    /// If it was built over more.
    #[must_use]
    pub fn of_tree(tree: &KdTree, triangle_count: usize) -> Self {
        let mut hierarchy = Rest::new(triangle_count);
        if tree.nodes().len() > 0 {
            hierarchy.below(tree, 0);
        }
        hierarchy.finish()
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are no triangles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Groups that hold triangles or other groups; the root is the first.
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

    fn halve(&mut self, ids: Range<u32>) {
        let group = self.open();
        if ids.len() <= Self::LARGEST {
            self.order.extend(ids);
        } else {
            let middle = ids.start + (ids.end - ids.start) / 2;
            self.halve(ids.start..middle);
            self.halve(middle..ids.end);
        }
        self.close(group);
    }
}

/// A hierarchy that is being made, and which triangles it has.
struct Rest {
    all: SceneHierarchy,
    root: usize,
    is_listed: Vec<bool>,
}

impl Rest {
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

    /// What no ray could hit then may be hit in another frame.
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
