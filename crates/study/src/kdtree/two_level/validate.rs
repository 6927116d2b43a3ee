use umbrage_rays::internals::Extent;
use umbrage_rays::{KdTree, Triangles};

use super::{KdMotion, TwoLevelKdTree};

impl TwoLevelKdTree {
    /// Checks the trees against the triangles that the last update was for.
    ///
    /// # Errors
    /// Names the first object that breaks a rule: each object's tree
    /// [is valid](umbrage_rays::Structure::validate), over the triangles as they are, or for a rigid object as they were when it was built; an object's box holds its triangles; and leaves of the tree
    /// over boxes that list an object cover its box.
    pub fn validate(&self, triangles: Triangles<'_>) -> Result<(), String> {
        if triangles.len() != self.triangle_count {
            return Err(format!("updated for {} triangles, not {}", self.triangle_count, triangles.len()));
        }
        for (id, object) in (0..).zip(&self.objects) {
            let triangles = object.of(triangles);
            let broken = |why: String| format!("object {id}: {why}");
            match &object.rest {
                Some(rest) => {
                    let positions = rest.all_positions();
                    let at_rest = Triangles { positions: &positions, indices: triangles.indices };
                    object.tree.check(at_rest).map_err(broken)?;
                }
                None => object.tree.check(triangles).map_err(broken)?,
            }
            if object.rest.is_some() != matches!(object.motion, KdMotion::Rigid { .. }) {
                return Err(broken("it isn't known where it was".to_owned()));
            }
            for triangle in 0..triangles.len() as u32 {
                if let Ok(corners) = triangles.usable_corners(triangle)
                    && Extent::around(corners).union(object.extent) != object.extent
                {
                    return Err(broken(format!("triangle {triangle} sticks out of its box")));
                }
            }
            if !object.extent.is_empty() && !covers_box(&self.top, 0, id, object.extent) {
                return Err(broken("it is missing in a leaf that it overlaps".to_owned()));
            }
        }
        Ok(())
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
