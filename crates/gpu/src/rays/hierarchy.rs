use umbrage_rays::Bvh;
use umbrage_rays::internals::{BVH_WIDTH, BvhChild, BvhInside, BvhKind, BvhLeaf, BvhNode};

use super::space::{Part, RaySpace};
use crate::link::shared_constants;
use crate::{Gpu, GpuError};

shared_constants! { "rays::hierarchy":
    /// Bit of a child that is a leaf.
    CHILD_LEAF: u32 = 1 << 31;
    /// Stands for no child.
    NO_CHILD: u32 = u32::MAX;
}

/// Words of a node: bounds and references of its children.
const NODE_WORDS: usize = 7 * BVH_WIDTH;

/// Most nodes: entries of the walk's stack have 24 bits for one.
const MOST_NODES: usize = 1 << 24;

/// A bounding volume hierarchy from the CPU, on the GPU: 224 bytes for a node, 32 for a leaf.
#[derive(Debug)]
pub struct Hierarchy {
    /// The second one has triangles with huge coordinates, and is empty unless there are others as well.
    parts: [Part; 2],
    has_far: bool,
    /// The last uploaded nodes and ids; kept to reuse the memory.
    nodes: Vec<[u32; NODE_WORDS]>,
    ids: Vec<[u32; BvhLeaf::LANES]>,
}

impl Hierarchy {
    /// Makes an empty hierarchy.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let parts = [Part::new(gpu), Part::new(gpu)];
        Self { parts, has_far: false, nodes: Vec::new(), ids: Vec::new() }
    }

    /// Uploads a hierarchy. Buffers are reused, and grow if they must.
    ///
    /// # Errors
    /// If it needs more bytes than one buffer of the device can have, or has more than 2²⁴ nodes.
    pub fn write(&mut self, gpu: &Gpu, bvh: &Bvh) -> Result<(), GpuError> {
        self.write_as(gpu, bvh, |id| id)
    }

    /// As [`Hierarchy::write`], for a hierarchy over a subset of triangles: `ids` are their ids in the whole scene.
    ///
    /// # Errors
    /// As [`Hierarchy::write`].
    pub(crate) fn write_some(&mut self, gpu: &Gpu, bvh: &Bvh, ids: &[u32]) -> Result<(), GpuError> {
        // Unused slots of leaves have no id.
        self.write_as(gpu, bvh, |id| ids.get(id as usize).copied().unwrap_or(u32::MAX))
    }

    fn write_as(&mut self, gpu: &Gpu, bvh: &Bvh, id_in_scene: impl Fn(u32) -> u32) -> Result<(), GpuError> {
        let Self { parts, has_far, nodes, ids } = self;
        *has_far = bvh.far().is_some();
        for (index, (part, bvh)) in parts.iter_mut().zip([Some(bvh), bvh.far()].into_iter().flatten()).enumerate() {
            let inside = bvh.inside();
            if inside.nodes.len() > MOST_NODES {
                return Err(GpuError::OutOfMemory(format!("a hierarchy of {} nodes", inside.nodes.len())));
            }
            let space = RaySpace::new(bounds(&inside)).after_others(index > 0);
            write_nodes(&inside, space.scale, nodes);
            ids.clear();
            ids.extend(inside.leaves.iter().map(|leaf| leaf.ids.map(&id_in_scene)));
            part.write_space(gpu, space)?;
            part.nodes.write(gpu, nodes)?;
            part.ids.write(gpu, ids)?;
        }
        Ok(())
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(Part::bytes).sum()
    }
}

impl AsRef<[Part]> for Hierarchy {
    fn as_ref(&self) -> &[Part] {
        &self.parts[..1 + usize::from(self.has_far)]
    }
}

/// The bounds of all triangles, the lower corner first; above the upper one if there are none.
fn bounds(inside: &BvhInside<'_>) -> [[f32; 3]; 2] {
    let mut all = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    if let (BvhKind::Node(root), false) = (inside.root.kind(), inside.nodes.is_empty()) {
        let [lowest, highest] = &mut all;
        for slot in children(&inside.nodes[root]) {
            for (axis, (lowest, highest)) in lowest.iter_mut().zip(&mut *highest).enumerate() {
                let [low, high] = bound(&inside.nodes[root], axis, slot, inside.scale);
                *lowest = lowest.min((low / inside.scale).max(f32::MIN));
                *highest = highest.max((high / inside.scale).min(f32::MAX));
            }
        }
    }
    all
}

/// The slots of a node that have a child.
fn children(node: &BvhNode) -> impl Iterator<Item = usize> {
    (0..BVH_WIDTH).filter(|&slot| node.children[slot] != BvhChild::NONE)
}

/// The bounds of a child on an axis, moved outward where scaling has lost the last bits of small coordinates.
fn bound(node: &BvhNode, axis: usize, slot: usize, scale: f32) -> [f32; 2] {
    let [low, high] = [2 * axis, 2 * axis + 1].map(|bound| node.bounds[bound][slot]);
    if scale == 1.0 { [low, high] } else { [low.next_down(), high.next_up()] }
}

/// Replaces `words` by the nodes, the root first, with bounds that are scaled for a space of this scale.
fn write_nodes(inside: &BvhInside<'_>, scale: f32, words: &mut Vec<[u32; NODE_WORDS]>) {
    words.clear();
    let BvhKind::Node(root) = inside.root.kind() else { return };
    // The root and the first node change places.
    let moved = |index: usize| match index {
        _ if index == root => 0,
        0 => root,
        _ => index,
    };
    // A power of two, as both scales are.
    let factor = scale / inside.scale;
    words.extend((0..inside.nodes.len()).map(|index| {
        let node = &inside.nodes[moved(index)];
        let mut words = [0; NODE_WORDS];
        words[6 * BVH_WIDTH..].fill(NO_CHILD);
        for slot in children(node) {
            for axis in 0..3 {
                let bounds = bound(node, axis, slot, inside.scale);
                for (side, at) in bounds.into_iter().enumerate() {
                    words[(2 * axis + side) * BVH_WIDTH + slot] = (at * factor).to_bits();
                }
            }
            words[6 * BVH_WIDTH + slot] = match node.children[slot].kind() {
                BvhKind::Node(index) => moved(index) as u32,
                BvhKind::Leaf { index, lanes } => {
                    CHILD_LEAF | (index * BvhLeaf::LANES) as u32 | (lanes.count_ones() - 1)
                }
            };
        }
        words
    }));
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use umbrage_rays::Triangles;

    use super::*;
    use crate::layout::{module, other_constants};
    use crate::link::link;

    const CHILD_IDS: u32 = BvhLeaf::LANES as u32 - 1;

    #[test]
    fn sizes_are_those_of_the_shader() {
        let sizes = [
            ("HIERARCHY_DEPTH", Bvh::MOST_LEVELS as u32),
            ("NODE_VECTORS", NODE_WORDS as u32 / 4),
            ("NODE_CHILDREN", 6 * BVH_WIDTH as u32 / 4),
            ("CHILD_IDS", CHILD_IDS),
        ];
        assert_eq!(other_constants(&module(&link("rays::hierarchy")), &sizes), [""; 0]);
    }

    /// The ids below a node of the words, each with the box that it is in; and the number of nodes.
    fn leaves_below(words: &[[u32; NODE_WORDS]], node: usize, found: &mut Vec<(u32, [f32; 6])>) -> usize {
        let mut count = 1;
        for slot in 0..BVH_WIDTH {
            let child = words[node][6 * BVH_WIDTH + slot];
            let bounds = std::array::from_fn(|bound| f32::from_bits(words[node][bound * BVH_WIDTH + slot]));
            match child {
                NO_CHILD => {}
                _ if child & CHILD_LEAF == 0 => count += leaves_below(words, child as usize, found),
                _ => {
                    let last = child & !CHILD_LEAF;
                    found.extend(((last & !CHILD_IDS)..=last).map(|id| (id, bounds)));
                }
            }
        }
        count
    }

    fn checked(bvh: &Bvh, triangles: Triangles<'_>) -> usize {
        let inside = bvh.inside();
        let space = RaySpace::new(bounds(&inside));
        let mut words = vec![[7; NODE_WORDS]];
        write_nodes(&inside, space.scale, &mut words);
        if words.is_empty() {
            assert!(space.reach() == 0.0);
            return 0;
        }
        let mut found = Vec::new();
        assert_eq!(leaves_below(&words, 0, &mut found), inside.nodes.len());
        for &(index, bounds) in &found {
            let id = inside.leaves[index as usize / BvhLeaf::LANES].ids[index as usize % BvhLeaf::LANES];
            for corner in triangles.corners(id) {
                for (axis, at) in (corner.as_dvec3() * f64::from(space.scale)).to_array().into_iter().enumerate() {
                    let [low, high] = [bounds[2 * axis], bounds[2 * axis + 1]].map(f64::from);
                    assert!(low <= at && at <= high && at.abs() <= 1.0, "{id} is at {at}, beyond {low} to {high}");
                }
            }
        }
        found.len()
    }

    #[test]
    fn words_lead_to_every_triangle() {
        let at = |index: usize, corner: usize| {
            Vec3::new((index * 7 % 31) as f32, (index * 11 % 29) as f32, (index * 5 % 23) as f32)
                + [Vec3::X, Vec3::Y, Vec3::Z][corner]
        };
        let indices: Vec<[u32; 3]> = (0..500).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let positions: Vec<Vec3> = (0..1500).map(|vertex| at(vertex / 3, vertex % 3)).collect();
        let mut bvh = Bvh::default();
        for count in [0, 1, 8, 9, 500] {
            let triangles = Triangles { positions: &positions, indices: &indices[..count] };
            // From triangles, and then from patches.
            for _ in 0..2 {
                bvh.build(triangles);
                assert!(bvh.far().is_none());
                assert_eq!(checked(&bvh, triangles), count);
            }
        }
        for distance in [1e6, 1e30] {
            let mut damaged = positions.clone();
            damaged[700] = Vec3::new(-1.0, 1e-20, 0.3) * distance;
            let triangles = Triangles { positions: &damaged, indices: &indices };
            bvh.build(triangles);
            let far = bvh.far().map_or(0, |far| checked(far, triangles));
            assert_eq!((checked(&bvh, triangles), far), if distance > 1e7 { (499, 1) } else { (500, 0) });
        }
    }
}
