//! The rig of a file, and which nodes the matrices of its poses come from.

use std::collections::{HashMap, HashSet};

use glam::Affine3A;
use gltf::json::animation::Property;

use super::animation::Animations;
use super::parts::{self, Parts};
use super::rest::Rest;
use super::skin::Skins;
use crate::rig::{Part, Placement, Rig, Shape};

/// Where a matrix of a pose comes from.
#[derive(Debug)]
pub(super) struct MatrixSource {
    node: u32,
    /// What stands between the mesh and the node: an instance's transform or a joint's inverse bind matrix.
    node_from_mesh: Option<Affine3A>,
}

impl MatrixSource {
    pub(super) fn at(&self, world_from_node: &[Affine3A]) -> Affine3A {
        let world_from_node = world_from_node[self.node as usize];
        self.node_from_mesh.map_or(world_from_node, |node_from_mesh| world_from_node * node_from_mesh)
    }
}

/// A rig of all parts, and where the matrices of its poses come from.
pub(super) fn rig(parts: Parts, skins: &Skins, rest: &Rest, animations: &Animations) -> (Rig, Vec<MatrixSource>) {
    let matrices = Matrices::new(&parts, skins, rest);
    let channels = animations.channels.iter().zip(&rest.slot_of_channel);
    let morphing = channels.filter(|(channel, _)| channel.property == Property::MorphTargetWeights);
    let morphing: HashSet<u32> = morphing.map(|(_, &first_weight)| first_weight).collect();
    let shapes: Vec<Shape> = parts.primitives.into_iter().map(|primitive| primitive.shape).collect();
    let parts_of_rig = parts.parts.into_iter().map(|part| {
        let matrix = matrices.first(part.placement);
        let is_skinned = matches!(part.placement, parts::Placement::Skin { .. });
        // Nodes without weights share the index of the next node's.
        let is_morphed = !shapes[part.primitive as usize].morph_targets.is_empty();
        Part {
            shape: part.primitive,
            first_vertex: part.first_vertex,
            first_weight: part.first_weight,
            placement: if is_skinned {
                Placement::Skinned { first_matrix: matrix }
            } else {
                Placement::Rigid { matrix }
            },
            moves: matrices.moves(matrix) || is_morphed && morphing.contains(&part.first_weight),
        }
    });
    let rig = Rig {
        parts: parts_of_rig.collect(),
        vertices: parts.vertices,
        has_normals: shapes.iter().any(|shape| !shape.normals.is_empty()),
        has_tangents: shapes.iter().any(|shape| !shape.tangents.is_empty()),
        moving_matrices: matrices.moving,
        shapes,
    };
    (rig, matrices.sources)
}

/// The matrices of a rig's poses.
#[derive(Default)]
struct Matrices {
    sources: Vec<MatrixSource>,
    /// How many of them, from the first on, move.
    moving: usize,
    /// The first one's index for each placement.
    first: HashMap<parts::Placement, u32>,
}

impl Matrices {
    fn new(parts: &Parts, skins: &Skins, rest: &Rest) -> Self {
        let moving_nodes: HashSet<u32> = rest.moving.iter().map(|moving| moving.node).collect();
        let mut matrices = Self::default();
        for moves in [true, false] {
            for &parts::Part { placement, .. } in &parts.parts {
                let sources = sources(placement, parts, skins);
                // Of a skin all matrices move where one does, so that they stay together.
                let is_now = sources.iter().any(|source| moving_nodes.contains(&source.node)) == moves;
                if is_now && !matrices.first.contains_key(&placement) {
                    matrices.first.insert(placement, matrices.sources.len() as u32);
                    matrices.sources.extend(sources);
                }
            }
            if moves {
                matrices.moving = matrices.sources.len();
            }
        }
        matrices
    }

    fn first(&self, placement: parts::Placement) -> u32 {
        self.first[&placement]
    }

    fn moves(&self, matrix: u32) -> bool {
        (matrix as usize) < self.moving
    }
}

fn sources(placement: parts::Placement, parts: &Parts, skins: &Skins) -> Vec<MatrixSource> {
    match placement {
        parts::Placement::Node(node) => vec![MatrixSource { node, node_from_mesh: None }],
        parts::Placement::Instance { node, instance } => {
            vec![MatrixSource { node, node_from_mesh: Some(parts.instances[instance as usize]) }]
        }
        parts::Placement::Skin { first_joint } => {
            let joints = skins.of_first(first_joint).iter();
            joints.map(|joint| MatrixSource { node: joint.node, node_from_mesh: Some(joint.joint_from_mesh) }).collect()
        }
    }
}
