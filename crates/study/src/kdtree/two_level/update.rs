use std::ops::Range;

use rayon::prelude::*;

use umbrage_rays::internals::{Extent, Reference};
use umbrage_rays::{KdTree, KdTreeOptions, Omitted, OmittedKind, Structure as _, Triangles};

use super::moved::Rest;
use super::{ImpossibleObjects, KdMotion, KdObject, Object, TwoLevelKdTree};

impl TwoLevelKdTree {
    /// Makes trees those of a frame, on all threads of the current pool. Objects are known by their indices: one that has
    /// other ids or moves in another way than in the last frame is taken for a new one. The result is the same for every
    /// number of threads.
    ///
    /// A rigid object's indices must not change from frame to frame.
    ///
    /// # Errors
    /// If the objects' triangles don't follow one another or aren't all of the frame's; then nothing is changed.
    ///
    /// # Panics
    /// As [`KdTree::build`].
    pub fn update(&mut self, triangles: Triangles<'_>, objects: &[KdObject]) -> Result<(), ImpossibleObjects> {
        let mut end = 0;
        for (index, KdObject { triangles: Range { start, end: next }, .. }) in objects.iter().enumerate() {
            if *start != end || next < start {
                return Err(ImpossibleObjects::Order(index));
            }
            end = *next;
        }
        if end as usize != triangles.len() {
            return Err(ImpossibleObjects::Count(end as usize, triangles.len()));
        }
        self.triangle_count = triangles.len();
        self.objects.truncate(objects.len());
        let known = self.objects.len();
        self.objects.extend(objects[known..].iter().map(|object| Object::new(object.clone())));
        let options = self.options;
        let all = self.objects.par_iter_mut().zip(objects).enumerate();
        all.for_each(|(index, (object, now))| object.update(triangles, now, options, index >= known));
        self.rebuilt = self.objects.iter().filter(|object| object.is_rebuilt).count() as u64;
        self.omitted = Omitted::default();
        for object in &self.objects {
            append(&mut self.omitted, object.tree.omitted(), object.triangles.start);
        }
        let boxes = self.objects.iter().zip(0..).filter(|(object, _)| !object.extent.is_empty());
        let boxes: Vec<_> = boxes.map(|(object, id)| Reference { extent: object.extent, id }).collect();
        self.top.build_over_boxes(&boxes);
        Ok(())
    }
}

impl Object {
    fn new(KdObject { triangles, motion }: KdObject) -> Self {
        Self { triangles, motion, tree: KdTree::default(), extent: Extent::EMPTY, rest: None, is_rebuilt: false }
    }

    /// The object's triangles; their ids start at zero.
    pub(super) fn of<'a>(&self, Triangles { positions, indices }: Triangles<'a>) -> Triangles<'a> {
        Triangles { positions, indices: &indices[self.triangles.start as usize..self.triangles.end as usize] }
    }

    fn update(&mut self, triangles: Triangles<'_>, now: &KdObject, options: KdTreeOptions, is_new: bool) {
        let is_known = !is_new && self.triangles == now.triangles;
        let before = std::mem::replace(&mut self.motion, now.motion);
        self.triangles.clone_from(&now.triangles);
        let triangles = self.of(triangles);
        self.is_rebuilt = false;
        match (before, now.motion) {
            (KdMotion::Static, KdMotion::Static) if is_known => return,
            (KdMotion::Rigid { .. }, KdMotion::Rigid { world_from_object }) if is_known => {
                let followed =
                    self.rest.as_mut().and_then(|rest| rest.follow(triangles, world_from_object, &self.tree.extent()));
                if let Some(extent) = followed {
                    self.extent = extent;
                    return;
                }
            }
            _ => {}
        }
        self.is_rebuilt = true;
        // Rays may reach a rigid object's subtrees when the triangles are elsewhere.
        let lazy_below = if matches!(now.motion, KdMotion::Rigid { .. }) { 0 } else { options.lazy_below };
        self.tree.set_options(KdTreeOptions { lazy_below, ..options }).expect("options that were checked");
        self.tree.build(triangles);
        self.extent = self.tree.extent();
        self.rest = match now.motion {
            KdMotion::Rigid { world_from_object } => Some(Rest::new(triangles, world_from_object)),
            _ => None,
        };
    }
}

/// Adds the omitted triangles of an object whose first triangle is `first`.
fn append(all: &mut Omitted, object: &Omitted, first: u32) {
    let kinds = [
        (&mut all.not_finite, &object.not_finite),
        (&mut all.zero_area, &object.zero_area),
        (&mut all.index_out_of_range, &object.index_out_of_range),
    ];
    for (kind, of_object) in kinds {
        kind.count += of_object.count;
        let room = OmittedKind::IDS - kind.first_ids.len();
        kind.first_ids.extend(of_object.first_ids.iter().map(|id| id + first).take(room));
    }
}
