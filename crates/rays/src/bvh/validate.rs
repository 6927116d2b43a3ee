use glam::Vec3;

use super::{Bvh, Child, Kind, Node};
use crate::Triangles;
use crate::simd::lanes::bits_of;
use crate::triangles::Unusable;

impl Node {
    /// The boxes of its children.
    fn children(&self) -> impl Iterator<Item = (Child, Vec3, Vec3)> {
        let corner =
            |slot: usize, high: usize| Vec3::from_array([0, 1, 2].map(|axis| self.bounds[2 * axis + high][slot]));
        let children = self.children.iter().enumerate().filter(|(_, child)| **child != Child::NONE);
        children.map(move |(slot, &child)| (child, corner(slot, 0), corner(slot, 1)))
    }

    /// The leaves among its children, and a bit for each of their triangles.
    pub(super) fn leaves(&self) -> impl Iterator<Item = (usize, u32)> {
        self.children().filter_map(|(child, ..)| match child.kind() {
            Kind::Leaf { index, lanes } => Some((index, lanes)),
            Kind::Node(_) => None,
        })
    }
}

impl Bvh {
    /// Checks the hierarchy against the triangles that it was built over.
    ///
    /// # Errors
    /// Names the first node or triangle that breaks a rule: every usable triangle is in exactly one leaf as it is, every box
    /// holds its children or triangles, and every node and leaf but the root has one parent.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let mut seen = vec![0_u32; triangles.len()];
        self.check_nodes(triangles, &mut seen)?;
        if let Some(far) = &self.far {
            far.check_nodes(triangles, &mut seen)?;
        }
        for (id, &count) in seen.iter().enumerate() {
            let usable = triangles.usable_corners(id as u32);
            let expected = u32::from(usable.is_ok());
            // A triangle without area may be in a leaf as well.
            if count != expected && (count, usable) != (1, Err(Unusable::ZeroArea)) {
                return Err(format!("triangle {id} is in {count} leaves instead of {expected}"));
            }
        }
        Ok(())
    }

    /// As [`check`](Self::check), but counts the leaves of each triangle.
    fn check_nodes(&self, triangles: Triangles<'_>, seen: &mut [u32]) -> Result<(), String> {
        let mut parents = [vec![0_u32; self.nodes.len()], vec![0_u32; self.leaves.len()]];
        for (index, node) in self.nodes.iter().enumerate() {
            for (child, low, high) in node.children() {
                let holds = |corner: Vec3| low.cmple(corner).all() && corner.cmple(high).all();
                match child.kind() {
                    Kind::Node(below) => {
                        let Some(node) = self.nodes.get(below) else {
                            return Err(format!("no child {below} of {index}"));
                        };
                        parents[0][below] += 1;
                        if !node.children().all(|(_, low, high)| holds(low) && holds(high)) {
                            return Err(format!("node {below} sticks out of its parent {index}"));
                        }
                    }
                    Kind::Leaf { index: below, lanes } => {
                        let Some(leaf) = self.leaves.get(below) else {
                            return Err(format!("no leaf {below} of {index}"));
                        };
                        parents[1][below] += 1;
                        for lane in bits_of(lanes) {
                            let id = leaf.ids[lane];
                            let count = seen.get_mut(id as usize).ok_or_else(|| format!("leaf {below} has no id"))?;
                            *count += 1;
                            let corners = triangles.corners(id).map(|corner| corner * self.scale);
                            if leaf.corners(lane) != corners || !corners.into_iter().all(holds) {
                                return Err(format!("triangle {id} sticks out of leaf {below}, or is another"));
                            }
                        }
                    }
                }
            }
        }
        for (what, parents) in ["node", "leaf"].into_iter().zip(&parents) {
            let is_root = |index: usize| what == "node" && Child::node(index) == self.root;
            let has_one = |(index, &count): (usize, &u32)| count == u32::from(!is_root(index));
            if let Some(index) = parents.iter().enumerate().position(|parent| !has_one(parent)) {
                return Err(format!("{what} {index} has {} parents", parents[index]));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of nodes on the longest way from a node to a leaf.
    fn levels_below(bvh: &Bvh, node: usize) -> usize {
        let below = bvh.nodes[node].children().map(|(child, ..)| match child.kind() {
            Kind::Node(index) => levels_below(bvh, index),
            Kind::Leaf { .. } => 0,
        });
        1 + below.max().unwrap_or(0)
    }

    /// The levels of a hierarchy over flat triangles of these sizes, all with a corner in one place.
    fn levels(sizes: impl Iterator<Item = f32>) -> usize {
        let positions: Vec<Vec3> =
            sizes.flat_map(|size| [Vec3::ZERO, Vec3::new(size, 0.0, size), Vec3::new(0.0, size, size)]).collect();
        let indices: Vec<[u32; 3]> =
            (0..positions.len() as u32 / 3).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let mut bvh = Bvh::default();
        // From triangles, and then from patches.
        let levels = [0; 2].map(|_| {
            bvh.build(triangles);
            bvh.check(triangles).expect("a sound hierarchy");
            let Kind::Node(root) = bvh.root.kind() else { panic!("the root is a leaf") };
            levels_below(&bvh, root)
        });
        levels[0].max(levels[1])
    }

    #[test]
    fn no_triangles_make_more_levels_than_walks_have_room_for() {
        let many_in_one_place = levels(std::iter::repeat_n(1.0, 1 << 16));
        assert!(many_in_one_place <= 10, "{many_in_one_place}");
        // Each division of a node leaves nearly all triangles together.
        let each_half_as_large = levels((0..6000).map(|id| f32::exp2(-(id % 100) as f32)));
        assert!((6..=Bvh::MOST_LEVELS).contains(&each_half_as_large), "{each_half_as_large}");
    }
}
