use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::rest::Rest;
use super::{KdMoved, Object, State, TwoLevelKdTree};
use crate::kdtree::{Extent, Reference};
use crate::{KdTree, KdTreeOptions};
use umbrage_rays::{Parts, Triangles};

/// The excess by which boxes are enlarged, relative to the missing part: the next frame may take vertices further.
const BEYOND: f64 = 0.25;

impl TwoLevelKdTree {
    /// Updates the trees for a frame, on all threads of the current pool. The result is the same for any number of threads.
    ///
    /// Trees are kept from the frame before if the same triangles are in the same parts.
    ///
    /// # Panics
    /// As [`KdTree::build`].
    pub fn update(&mut self, triangles: Triangles<'_>, parts: Parts<'_>) {
        self.take(triangles, parts);
        let Self { options, moved, .. } = *self;
        self.objects.par_iter_mut().each(|object| object.update(triangles, options, moved));
        let boxes = self.objects.iter().zip(0..).filter(|(object, _)| !object.extent.is_empty());
        let boxes: Vec<_> = boxes.map(|(object, id)| Reference { extent: object.extent, id }).collect();
        self.top.build_over_boxes(&boxes);
        self.choose_together();
    }

    /// Enlarges the boxes of parts so that they hold each of the `poses`, and builds their trees: for [`KdMoved::Enclose`].
    /// A pose has all positions of a frame, as `rest.positions` has. Boxes that a later frame leaves are enlarged again.
    ///
    /// # Panics
    /// As [`KdTree::build`].
    pub fn prepare(&mut self, rest: Triangles<'_>, parts: Parts<'_>, poses: &[Vec<glam::Vec3>]) {
        self.objects.clear();
        self.take(rest, parts);
        let options = self.options;
        self.objects.par_iter_mut().each(|object| object.prepare(rest, poses, options));
    }

    /// Parts triangles into objects, unless that is done.
    fn take(&mut self, triangles: Triangles<'_>, parts: Parts<'_>) {
        let parts = if parts.of_triangle.len() == triangles.len() { parts } else { Parts::default() };
        let key = |id: u32| match self.moved {
            KdMoved::Enclose => parts.part_of(id),
            KdMoved::Rebuild | KdMoved::Transform => parts.object_of(id),
        };
        self.omitted = triangles.omitted();
        let is_same = self.triangle_count == triangles.len()
            && self.objects.par_iter().all(|object| object.is_of(triangles, key));
        if !is_same {
            let mut ids: Vec<u32> = (0..triangles.len() as u32).collect();
            ids.sort_by_key(|&id| key(id));
            let objects = ids.chunk_by(|&a, &b| key(a) == key(b));
            self.objects = objects.map(|ids| Object::new(key(ids[0]), ids, triangles)).collect();
            self.triangle_count = triangles.len();
        }
    }
}

impl Object {
    fn new(key: u32, ids: &[u32], triangles: Triangles<'_>) -> Self {
        let indices: Vec<_> = ids.iter().map(|&id| triangles.indices[id as usize]).collect();
        let (rest, tree) = (Rest::new(&indices), KdTree::default());
        Self { key, ids: ids.to_vec(), indices, tree, rest, state: State::New, extent: Extent::EMPTY }
    }

    /// Whether its triangles still have the same vertices, and are still its own.
    fn is_of(&self, triangles: Triangles<'_>, key: impl Fn(u32) -> u32 + Sync) -> bool {
        const CHUNK: usize = 1 << 14;
        let all = self.ids.par_chunks(CHUNK).zip(self.indices.par_chunks(CHUNK));
        all.all(|(ids, indices)| {
            let mut all = ids.iter().zip(indices);
            all.all(|(&id, own)| key(id) == self.key && triangles.indices[id as usize] == *own)
        })
    }

    fn update(&mut self, triangles: Triangles<'_>, options: KdTreeOptions, moved: KdMoved) {
        (self.state, self.extent) = self.next(triangles, options, moved);
    }

    /// Updates the tree for a frame, and returns the object's state and bounds.
    fn next(&mut self, triangles: Triangles<'_>, options: KdTreeOptions, moved: KdMoved) -> (State, Extent) {
        let Self { indices, rest, tree, .. } = self;
        let triangles = Triangles { indices, ..triangles };
        if !matches!(self.state, State::New) {
            if rest.is_at(triangles.positions) {
                return (State::Still, rest.extent());
            }
            if moved != KdMoved::Rebuild
                && let Some((moved, extent)) = rest.follow(triangles)
            {
                return (State::Moved(Box::new(moved), false), extent);
            }
            if moved == KdMoved::Enclose
                && rest.enclose(triangles, BEYOND)
                && rest.is_worth_it(triangles)
                && let Some((moved, extent)) = rest.follow(triangles)
            {
                self.build_over_boxes(options);
                return (State::Moved(Box::new(moved), true), extent);
            }
        }
        rest.settle(triangles);
        tree.set_options(options).expect("options that were checked");
        tree.build(triangles);
        (State::Built, rest.extent())
    }

    fn prepare(&mut self, rest: Triangles<'_>, poses: &[Vec<glam::Vec3>], options: KdTreeOptions) {
        let Self { indices, rest: own, tree, .. } = self;
        let at = |positions| Triangles { positions, indices };
        own.settle(at(rest.positions));
        if !poses.iter().all(|pose| own.enclose(at(pose), 0.0)) {
            return;
        }
        own.drop_small_boxes();
        if !own.has_boxes() {
            tree.set_options(options).expect("options that were checked");
            tree.build(at(rest.positions));
        } else if own.is_worth_it(at(rest.positions)) {
            self.build_over_boxes(options);
        } else {
            return;
        }
        self.state = State::Still;
    }

    fn build_over_boxes(&mut self, options: KdTreeOptions) {
        self.tree.set_options(options).expect("options that were checked");
        let boxes: Vec<_> = self.rest.references(&self.indices).collect();
        self.tree.build_over_boxes(&boxes);
    }
}
