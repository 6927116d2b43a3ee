//! The nodes from which the matrices of a rig's poses come.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, DVec3};

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
#[derive(Debug)]
pub(super) struct Matrices {
    moving_nodes: HashSet<u32>,
    pub(super) moving: Vec<MatrixSource>,
    pub(super) still: Vec<MatrixSource>,
    of_skins: HashMap<usize, Added>,
}

/// A range of consecutive matrices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Added {
    /// The first one's index among moving matrices, or among still ones.
    pub(super) first: u32,
    pub(super) moves: bool,
}

impl Matrices {
    pub(super) fn new(rest: &Rest) -> Self {
        let moving_nodes = rest.moving.iter().map(|moving| moving.node).collect();
        Self { moving_nodes, moving: Vec::new(), still: Vec::new(), of_skins: HashMap::new() }
    }

    /// Adds matrices; all of them count as moving if one moves.
    pub(super) fn add(&mut self, sources: &[MatrixSource]) -> Added {
        let moves = sources.iter().any(|source| self.moving_nodes.contains(&source.node));
        let list = if moves { &mut self.moving } else { &mut self.still };
        let first = list.len() as u32;
        list.extend_from_slice(sources);
        Added { first, moves }
    }

    /// As [`Matrices::add`], but those of skin `number` only once.
    pub(super) fn add_skin(&mut self, number: usize, joints: &[MatrixSource]) -> Added {
        if let Some(&added) = self.of_skins.get(&number) {
            return added;
        }
        let added = self.add(joints);
        self.of_skins.insert(number, added);
        added
    }
}
