use glam::Vec3A;

use super::Bvh;
use crate::Triangles;

impl Bvh {
    /// Checks the hierarchy against the triangles that it was built over.
    ///
    /// # Errors
    /// Names the first node or triangle that breaks a rule: every usable triangle is in exactly one leaf, every box
    /// holds its children or triangles, and every node but the root has one parent.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let nodes = &self.tree.nodes;
        let mut seen = vec![0_u32; triangles.len()];
        let mut parents = vec![0_u32; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            if node.is_leaf() {
                let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                let listed =
                    self.tree.primitive_indices.get(range).ok_or_else(|| format!("leaf {index} is out of range"))?;
                for &box_index in listed {
                    let id = *self.ids.get(box_index as usize).ok_or_else(|| format!("leaf {index} has no id"))?;
                    seen[id as usize] += 1;
                    let inside = |corner: Vec3A| node.aabb.min.cmple(corner).all() && corner.cmple(node.aabb.max).all();
                    if !triangles.corners(id).map(|corner| Vec3A::from(corner * self.scale)).into_iter().all(inside) {
                        return Err(format!("triangle {id} sticks out of leaf {index}"));
                    }
                }
            } else {
                for child in [node.first_index as usize, node.first_index as usize + 1] {
                    let below = nodes.get(child).ok_or_else(|| format!("child {child} of {index} is out of range"))?;
                    parents[child] += 1;
                    if !(node.aabb.min.cmple(below.aabb.min).all() && below.aabb.max.cmple(node.aabb.max).all()) {
                        return Err(format!("node {child} sticks out of its parent {index}"));
                    }
                }
            }
        }
        if let Some(node) = parents.iter().skip(1).position(|&count| count != 1) {
            return Err(format!("node {} has {} parents", node + 1, parents[node + 1]));
        }
        for (id, &count) in seen.iter().enumerate() {
            let expected = u32::from(triangles.usable_corners(id as u32).is_ok());
            if count != expected {
                return Err(format!("triangle {id} is in {count} leaves instead of {expected}"));
            }
        }
        Ok(())
    }
}
