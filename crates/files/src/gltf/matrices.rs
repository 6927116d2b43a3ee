//! The nodes from which the matrices of a rig's poses come: those of meshes, and the joints of skins.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, DVec3, Mat4};
use umbrage_scene::Error;

use super::document::Document;
use super::far::{FarNodes, near, wide};
use super::rest::Rest;

/// The source of a pose's matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct MatrixSource {
    pub(super) node: u32,
    /// Transform from the mesh to the node: an instance's, or a joint's inverse bind matrix.
    pub(super) node_from_mesh: Option<Affine3A>,
}

impl MatrixSource {
    /// The matrix for nodes with these transforms.
    pub(super) fn at(&self, world_from_node: &[Affine3A]) -> Affine3A {
        let world_from_node = world_from_node[self.node as usize];
        self.node_from_mesh.map_or(world_from_node, |node_from_mesh| world_from_node * node_from_mesh)
    }

    /// As [`MatrixSource::at`], composed in f64 and then from `origin`.
    pub(super) fn far(&self, nodes: &FarNodes, origin: DVec3) -> Affine3A {
        let world_from_node = nodes.world_from_node[self.node as usize];
        near(self.node_from_mesh.map_or(world_from_node, |of| world_from_node * wide(&of)), origin)
    }
}

/// The matrices of a rig's poses. Moving ones will come first.
#[derive(Debug, Default)]
pub(super) struct Matrices {
    moving_nodes: HashSet<u32>,
    pub(super) moving: Vec<MatrixSource>,
    pub(super) still: Vec<MatrixSource>,
    of_skins: HashMap<usize, MatrixRange>,
}

/// A range of consecutive matrices.
#[derive(Clone, Copy, Debug)]
pub(super) struct MatrixRange {
    /// The first one's index among moving matrices, or among still ones.
    pub(super) first: u32,
    pub(super) moves: bool,
}

impl Matrices {
    pub(super) fn new(rest: &Rest) -> Self {
        let moving_nodes = rest.moving.iter().map(|moving| moving.node).collect();
        Self { moving_nodes, ..Self::default() }
    }

    /// Adds matrices; all of them count as moving if one moves.
    pub(super) fn add(&mut self, sources: &[MatrixSource]) -> MatrixRange {
        let moves = sources.iter().any(|source| self.moving_nodes.contains(&source.node));
        let list = if moves { &mut self.moving } else { &mut self.still };
        let first = list.len() as u32;
        list.extend_from_slice(sources);
        MatrixRange { first, moves }
    }

    /// As [`Matrices::add`], but those of skin `number` only once.
    pub(super) fn add_skin(&mut self, number: usize, joints: &[MatrixSource]) -> MatrixRange {
        if let Some(&added) = self.of_skins.get(&number) {
            return added;
        }
        let added = self.add(joints);
        self.of_skins.insert(number, added);
        added
    }
}

/// Reads the joints of all skins.
///
/// # Errors
/// Where a joint or a matrix is broken or missing.
pub(super) fn read_skins(document: &Document) -> Result<Vec<Vec<MatrixSource>>, Error> {
    let mut skins = Vec::new();
    for (number, json) in document.json.skins.iter().enumerate() {
        let location = format!("skins[{number}]");
        let matrices = match json.inverse_bind_matrices {
            None => Vec::new(),
            Some(accessor) => {
                let accessor = document.accessor(accessor, format_args!("{location}.inverseBindMatrices"))?;
                let matrices: Vec<_> =
                    accessor.floats(None, |columns: [f32; 16]| Affine3A::from_mat4(Mat4::from_cols_array(&columns)))?;
                if matrices.len() < json.joints.len() {
                    let cause = format!("{} matrices for {} joints", matrices.len(), json.joints.len());
                    return Err(accessor.malformed(cause));
                }
                if let Some(at) = matrices.iter().position(|matrix| !matrix.is_finite()) {
                    return Err(accessor.malformed(format!("matrix {at} is not finite")));
                }
                matrices
            }
        };
        let mut joints = Vec::new();
        for (at, node) in json.joints.iter().enumerate() {
            let location = format_args!("{location}.joints[{at}]");
            document.element(&document.json.nodes, "nodes", node.value(), location)?;
            let joint_from_mesh = matrices.get(at).copied().unwrap_or(Affine3A::IDENTITY);
            joints.push(MatrixSource { node: node.value() as u32, node_from_mesh: Some(joint_from_mesh) });
        }
        skins.push(joints);
    }
    Ok(skins)
}
