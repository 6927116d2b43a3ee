//! What vertices are made from and what moves them, as tables for whoever poses them.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use glam::Affine3A;
use gltf::json::animation::Property;

pub use super::morph::{Deltas, MorphTarget};
pub use super::primitive::Shape;
pub use super::skin::Influences;

use super::animation::Animations;
use super::parts::{self, Parts, overlapping};
use super::rest::Rest;
use super::skin::Skins;

/// What a scene's vertices are made from, which stays the same in every pose.
#[derive(Debug)]
pub struct Rig {
    /// What parts are copies of.
    pub shapes: Vec<Shape>,
    /// In the order of their vertices, which have no gaps.
    pub parts: Vec<Part>,
    /// How many vertices all parts have together.
    pub vertices: usize,
    /// Whether any shape has normals. Vertices of others then have the normal zero.
    pub has_normals: bool,
    /// Whether any shape has tangents. Vertices of others then have the tangent zero.
    pub has_tangents: bool,
    /// How many of a pose's matrices, from the first on, may be others in the next pose.
    pub moving_matrices: usize,
}

/// A copy of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Place in [`Rig::shapes`].
    pub shape: u32,
    /// Place of its first vertex among those of all parts.
    pub first_vertex: u32,
    /// Place in [`Pose::weights`] of its first morph target's.
    pub first_weight: u32,
    /// What moves it, once its targets are added.
    pub placement: Placement,
    /// Whether it may look otherwise in the next pose.
    pub moves: bool,
}

/// What moves a part. Places are those in [`Pose::matrices`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// One matrix moves all vertices.
    Rigid {
        /// Its place.
        matrix: u32,
    },
    /// Each vertex follows the joints of its [`Influences`] (linear blend skinning).
    Skinned {
        /// The place of joint 0.
        first_matrix: u32,
    },
}

/// What moves a rig's vertices at a moment.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// From the space of meshes to the world; first those that move (see [`Rig::moving_matrices`]).
    pub matrices: Vec<Affine3A>,
    /// Of morph targets.
    pub weights: Vec<f32>,
}

/// Where a matrix of a pose comes from.
#[derive(Debug)]
pub(super) struct MatrixSource {
    node: u32,
    /// What stands between the mesh and the node: an instance's place or a joint's inverse bind matrix.
    node_from_mesh: Option<Affine3A>,
}

impl MatrixSource {
    pub(super) fn at(&self, world_from_node: &[Affine3A]) -> Affine3A {
        let world_from_node = world_from_node[self.node as usize];
        self.node_from_mesh.map_or(world_from_node, |node_from_mesh| world_from_node * node_from_mesh)
    }
}

impl Rig {
    /// A rig of all parts, and where the matrices of its poses come from.
    pub(super) fn new(parts: Parts, skins: &Skins, rest: &Rest, animations: &Animations) -> (Self, Vec<MatrixSource>) {
        let matrices = Matrices::new(&parts, skins, rest);
        let channels = animations.channels.iter().zip(&rest.slot_of_channel);
        let morphing = channels.filter(|(channel, _)| channel.property == Property::MorphTargetWeights);
        let morphing: HashSet<u32> = morphing.map(|(_, &first_weight)| first_weight).collect();
        let shapes: Vec<Shape> = parts.primitives.into_iter().map(|primitive| primitive.shape).collect();
        let parts_of_rig = parts.parts.into_iter().map(|part| {
            let matrix = matrices.first(part.placement);
            let is_skinned = matches!(part.placement, parts::Placement::Skin { .. });
            // Nodes without weights share the place of the next node's.
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
        let rig = Self {
            parts: parts_of_rig.collect(),
            vertices: parts.vertices,
            has_normals: shapes.iter().any(|shape| !shape.normals.is_empty()),
            has_tangents: shapes.iter().any(|shape| !shape.tangents.is_empty()),
            moving_matrices: matrices.moving,
            shapes,
        };
        (rig, matrices.sources)
    }

    /// The parts of which any vertex is in `vertices`.
    pub(super) fn with_vertices_in(&self, vertices: Range<usize>) -> &[Part] {
        overlapping(&self.parts, vertices, |part| part.first_vertex)
    }
}

/// The matrices of a rig's poses.
#[derive(Default)]
struct Matrices {
    sources: Vec<MatrixSource>,
    /// How many of them, from the first on, move.
    moving: usize,
    /// The first one's place for each placement.
    places: HashMap<parts::Placement, u32>,
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
                if is_now && !matrices.places.contains_key(&placement) {
                    matrices.places.insert(placement, matrices.sources.len() as u32);
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
        self.places[&placement]
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
