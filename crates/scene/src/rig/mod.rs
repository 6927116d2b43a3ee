//! Sources of posed vertices and their transforms, as tables for [`Rig::pose`] or a GPU.

mod pose;

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};

/// Sources of a scene's vertices, the same in every pose.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The shapes that parts are copies of.
    pub shapes: Vec<Arc<Shape>>,
    /// In the order of their vertices, which have no gaps.
    pub parts: Vec<RigPart>,
    /// How many vertices all parts have together.
    pub vertices: usize,
    /// Whether any shape has normals. Vertices of others then have the normal zero.
    pub has_normals: bool,
    /// Whether any shape has tangents. Vertices of others then have the tangent zero.
    pub has_tangents: bool,
    /// Number of a pose's matrices, from the first on, that may change in the next pose.
    pub moving_matrices: usize,
}

/// A copy of a shape.
#[derive(Clone, Copy, Debug)]
pub struct RigPart {
    /// Index in [`Rig::shapes`].
    pub shape: u32,
    /// Index of its first vertex among those of all parts.
    pub first_vertex: u32,
    /// Index in [`Pose::weights`] of its first morph target's weight.
    pub first_weight: u32,
    /// Its transform, applied after its morph targets.
    pub placement: Placement,
    /// Whether it may change in the next pose.
    pub moves: bool,
}

/// Transform of a part. Indices are into [`Pose::matrices`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// One matrix moves all vertices.
    Rigid {
        /// Its index.
        matrix: u32,
    },
    /// Each vertex follows the joints of its [`Influences`] (linear blend skinning).
    Skinned {
        /// The index of joint 0's matrix.
        first_matrix: u32,
    },
}

/// Matrices and weights of a rig at a moment.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// From the space of meshes to the world, from the scene's origin; moving ones first (see [`Rig::moving_matrices`]).
    pub matrices: Vec<Affine3A>,
    /// Weights of morph targets.
    pub weights: Vec<f32>,
}

/// Vertices before posing, in a mesh's own space.
#[derive(Debug, Default)]
pub struct Shape {
    /// Positions before morph targets and transforms.
    pub positions: Vec<Vec3>,
    /// Of unit length, or zero where the file's is unusable; empty, or one for each position.
    pub normals: Vec<Vec3>,
    /// Unit tangents and the sign of the bitangent, or zero; empty, or one for each position.
    pub tangents: Vec<Vec4>,
    /// Sets of four influences for each position; none where the shape has no joints.
    pub influences: Vec<Vec<Influences>>,
    /// Offsets that are added to vertices, scaled by weights.
    pub morph_targets: Vec<MorphTarget>,
}

/// Four joints of a vertex and their weights: 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influences {
    /// Indices of the skin's joints.
    pub joints: [u16; 4],
    /// At least zero; all weights of a vertex add up to one over all sets. Joints without weight are joint 0.
    pub weights: [f32; 4],
}

/// The differences that a morph target adds at weight one.
#[derive(Debug, Default)]
pub struct MorphTarget {
    /// To positions.
    pub positions: Deltas,
    /// To normals.
    pub normals: Deltas,
    /// To tangents' directions.
    pub tangents: Deltas,
}

/// Differences, for all vertices or for some.
#[derive(Debug)]
pub enum Deltas {
    /// One for each vertex.
    Dense(Vec<Vec3>),
    /// Differences of some vertices; zero for the others.
    Sparse {
        /// The affected vertices, ascending.
        vertices: Vec<u32>,
        /// One for each of `vertices`.
        deltas: Vec<Vec3>,
    },
}

impl Default for Deltas {
    fn default() -> Self {
        Self::Sparse { vertices: Vec::new(), deltas: Vec::new() }
    }
}
