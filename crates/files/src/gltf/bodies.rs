//! Groups of triangles that move together: below the same animated node, or mostly following the same joint.

use std::collections::HashMap;

use umbrage_scene::Mesh;
use umbrage_scene::rig::{Influences, Placement, RigPart, Shape};

use super::matrices::Matrices;
use super::rest::Rest;

/// A group of triangles with a motion of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Object {
    /// Triangles that don't move.
    Still,
    /// Triangles whose nearest animated node is this one.
    Node(u32),
    /// The morphing part with this first vertex.
    Morphed(u32),
    /// Triangles of the skin with this first matrix.
    Skin(u32),
}

/// Numbers objects and parts of a mesh in order of appearance.
pub(super) struct Bodies<'a> {
    matrices: &'a Matrices,
    /// By moving node, the nearest animated node at or above it.
    animated: HashMap<u32, u32>,
    objects: HashMap<Object, u32>,
    /// By object and joint of its skin.
    parts: HashMap<(Object, u16), u32>,
}

impl<'a> Bodies<'a> {
    pub(super) fn new(matrices: &'a Matrices, rest: &Rest) -> Self {
        let mut animated = HashMap::new();
        for moving in &rest.moving {
            let above = moving.parent.filter(|_| moving.slot.is_none()).and_then(|parent| animated.get(&parent));
            let own = above.copied().unwrap_or(moving.node);
            animated.insert(moving.node, own);
        }
        Self { matrices, animated, objects: HashMap::new(), parts: HashMap::new() }
    }

    /// Appends the object and part of each triangle of `part`, whose triangles are the mesh's last.
    pub(super) fn add(&mut self, part: &RigPart, shape: &Shape, triangles: &[[u32; 3]], mesh: &mut Mesh) {
        let object = match part.placement {
            _ if !shape.morph_targets.is_empty() => Object::Morphed(part.first_vertex),
            _ if !part.moves => Object::Still,
            Placement::Skinned { first_matrix } => Object::Skin(first_matrix),
            Placement::Rigid { matrix } => {
                let node = self.matrices.moving[matrix as usize].node;
                Object::Node(self.animated.get(&node).copied().unwrap_or(node))
            }
        };
        let is_skinned = matches!(object, Object::Skin(_));
        mesh.part_of_triangle.extend(triangles.iter().map(|&corners| {
            let joint = if is_skinned { main_joint(&shape.influences, corners) } else { 0 };
            *self.parts.entry((object, joint)).or_insert_with(|| {
                let next = self.objects.len() as u32;
                mesh.object_of_part.push(*self.objects.entry(object).or_insert(next));
                mesh.object_of_part.len() as u32 - 1
            })
        }));
    }
}

/// The joint with the largest weight over a triangle's corners; the lowest of several.
fn main_joint(sets: &[Vec<Influences>], corners: [u32; 3]) -> u16 {
    let of_corners = || sets.iter().flat_map(|set| corners.map(|corner| set[corner as usize]));
    let weight = |joint: u16| -> f32 {
        let all = of_corners().flat_map(|all| all.joints.into_iter().zip(all.weights));
        all.filter(|&(other, _)| other == joint).map(|(_, weight)| weight).sum()
    };
    let joints = of_corners().flat_map(|all| all.joints);
    joints.max_by(|&a, &b| weight(a).total_cmp(&weight(b)).then(b.cmp(&a))).unwrap_or(0)
}
