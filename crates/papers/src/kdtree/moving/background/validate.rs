use crate::kdtree::Extent;
use umbrage_rays::Triangles;

use super::BackgroundKdTree;

impl BackgroundKdTree {
    /// Checks the tree against the triangles of the current frame.
    ///
    /// # Errors
    /// Names the first triangle or node that breaks a rule: the tree [is valid](umbrage_rays::Structure::validate) for the
    /// triangles that it was built over; those are the frame's, up to their positions; the box holds all of them; and the
    /// drift of a node is no less than that of a triangle that it lists, or of a child.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let Self { current, drift, extent, .. } = self;
        let rest = Triangles { positions: &current.positions, indices: &current.indices };
        current.tree.check(rest)?;
        if rest.indices != triangles.indices || rest.positions.len() != triangles.positions.len() {
            return Err("the tree isn't of these triangles".to_owned());
        }
        let nodes = current.tree.nodes();
        if drift.len() != nodes.len() {
            return Err(format!("it is known of {} nodes of {} how they move", drift.len(), nodes.len()));
        }
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop() {
            let (node, most) = (nodes.get(index), drift[index as usize]);
            if !node.is_leaf() {
                let children = nodes.children(index, node);
                if children.iter().any(|&child| drift[child as usize] > most) {
                    return Err(format!("a child of node {index} has moved more than that"));
                }
                waiting.extend(children);
                continue;
            }
            for &id in &current.tree.ids()[node.ids()] {
                let Ok(corners) = triangles.usable_corners(id) else { continue };
                let moved = corners.into_iter().zip(rest.corners(id));
                if moved
                    .into_iter()
                    .any(|(now, then)| (now.as_dvec3() - then.as_dvec3()).abs().max_element() > f64::from(most))
                {
                    return Err(format!("triangle {id} has moved more than leaf {index}"));
                }
            }
        }
        for id in 0..triangles.len() as u32 {
            if let Ok(corners) = triangles.usable_corners(id) {
                if rest.usable_corners(id).is_err() {
                    return Err(format!("triangle {id} can be hit and couldn't be when the tree was built"));
                }
                if Extent::around(corners).union(*extent) != *extent {
                    return Err(format!("triangle {id} sticks out of the box"));
                }
            }
        }
        Ok(())
    }
}
