use glam::{DVec3, Vec3};

use super::{Object, State, TwoLevelKdTree};
use crate::KdTree;
use crate::kdtree::Extent;
use umbrage_rays::Triangles;

impl TwoLevelKdTree {
    /// Checks the trees against the triangles that the last update was for.
    ///
    /// # Errors
    /// Names the first object that breaks a rule: each object's tree
    /// [is valid](umbrage_rays::Structure::validate), over the triangles now or at rest, or covers the boxes that it is
    /// over; mapped vertices are no farther outside of their boxes than the drift; an object's box holds its triangles;
    /// and leaves of the tree over boxes that list an object cover its box.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        if triangles.len() != self.triangle_count {
            return Err(format!("updated for {} triangles, not {}", self.triangle_count, triangles.len()));
        }
        for (id, object) in (0..).zip(&self.objects) {
            object.check(triangles).map_err(|why| format!("object {id}: {why}"))?;
            if !object.extent.is_empty() && !covers_box(&self.top, 0, id, object.extent) {
                return Err(format!("object {id}: it is missing in a leaf that it overlaps"));
            }
        }
        Ok(())
    }
}

impl Object {
    fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let triangles = self.of(triangles);
        let (positions, indices) = self.rest.triangles(&self.indices);
        let at_rest = Triangles { positions, indices: &indices };
        for id in 0..triangles.len() as u32 {
            if let Ok(corners) = triangles.usable_corners(id) {
                if at_rest.usable_corners(id).is_err() {
                    return Err(format!("triangle {id} can be hit and couldn't be when the tree was built"));
                }
                if Extent::around(corners).union(self.extent) != self.extent {
                    return Err(format!("triangle {id} sticks out of its box"));
                }
                if !triangles.indices[id as usize].into_iter().zip(corners).all(|(vertex, at)| self.holds(vertex, at)) {
                    return Err(format!("triangle {id} isn't where rays are led to"));
                }
            }
        }
        if !self.rest.has_boxes() {
            return self.tree.check(at_rest);
        }
        let missing = self.rest.references(&self.indices).find(|box_of| {
            let is_in_tree = box_of.extent.union(self.tree.extent()) == self.tree.extent();
            !(is_in_tree && covers_box(&self.tree, 0, box_of.id, box_of.extent))
        });
        missing.map_or(Ok(()), |missing| {
            Err(format!("triangle {} is missing in a leaf that its box overlaps", missing.id))
        })
    }

    /// Whether a mapped vertex is in its box, up to drift.
    fn holds(&self, vertex: u32, at: Vec3) -> bool {
        let Some([low, high]) = self.rest.box_of(vertex) else { return false };
        let State::Moved(moved, _) = &self.state else { return low.cmple(at).all() && at.cmple(high).all() };
        let taken = moved.rest_from_world.transform_point3(at.as_dvec3());
        let outside = (low.as_dvec3() - taken).max(taken - high.as_dvec3()).max(DVec3::ZERO);
        outside.cmple(moved.drift).all()
    }
}

/// Whether the leaves below a node that list a box cover a part of it.
fn covers_box(tree: &KdTree, index: u32, id: u32, part: Extent) -> bool {
    let node = tree.nodes().get(index);
    if node.is_leaf() {
        return tree.ids()[node.ids()].binary_search(&id).is_ok();
    }
    let plane = node.plane();
    let [left, right] = tree.nodes().children(index, node);
    let (low, high) = (part.min[plane.axis], part.max[plane.axis]);
    if low == plane.at && high == plane.at {
        return covers_box(tree, left, id, part) || covers_box(tree, right, id, part);
    }
    let [below, above] = part.cut(plane);
    (low >= plane.at || covers_box(tree, left, id, if high <= plane.at { part } else { below }))
        && (high <= plane.at || covers_box(tree, right, id, if low >= plane.at { part } else { above }))
}
