//! A scene's rest pose, and the nodes that its animations move.

use std::ops::Mul;

use glam::{Affine3A, DVec3};
use gltf::json::animation::Property;
use umbrage_scene::Error;

use super::animation::Animations;
use super::document::Document;
use super::far::Far;
use super::nodes::{Nodes, Trs, trs};

/// Transforms at rest, and the nodes to compute for every pose.
#[derive(Debug)]
pub(super) struct Rest {
    /// World transforms of all nodes, from the scene's origin.
    pub(super) world_from_node: Vec<Affine3A>,
    /// The morph weights of all nodes, one node after the other.
    pub(super) weights: Vec<f32>,
    /// The transforms to their parents of the nodes that have channels.
    pub(super) animated: Vec<Trs>,
    /// For each channel its node's index in `animated`, or its node's first index in `weights`.
    pub(super) slot_of_channel: Vec<u32>,
    /// The nodes that have channels and all nodes below them, parents before their children.
    pub(super) moving: Vec<Moving>,
    /// The nodes of a scene far from the origin of its coordinates.
    pub(super) far: Option<Far>,
}

/// A node that may move in every pose.
#[derive(Debug)]
pub(super) struct Moving {
    pub(super) node: u32,
    pub(super) parent: Option<u32>,
    /// Index in [`Rest::animated`], for a node with channels.
    pub(super) slot: Option<u32>,
    /// The node's transform at rest.
    pub(super) parent_from_node: Affine3A,
}

impl Moving {
    /// The node's transform to the world, from those to its parent and of its parent, in f32 or in f64.
    pub(super) fn to_world<T: Copy + Mul<Output = T>>(&self, parent_from_node: T, world_from_node: &[T]) -> T {
        self.parent.map_or(parent_from_node, |parent| world_from_node[parent as usize] * parent_from_node)
    }
}

impl Rest {
    pub(super) fn new(document: &Document, nodes: &Nodes, weights: &MorphWeights, animations: &Animations) -> Self {
        let mut slots: Vec<Option<u32>> = vec![None; nodes.parents.len()];
        let mut animated = Vec::new();
        let mut slot_of_channel = Vec::new();
        for channel in &animations.channels {
            let node = channel.node as usize;
            slot_of_channel.push(if channel.property == Property::MorphTargetWeights {
                weights.first_of_node[node]
            } else {
                *slots[node].get_or_insert_with(|| {
                    animated.push(trs(&document.json.nodes[node]));
                    animated.len() as u32 - 1
                })
            });
        }
        let mut moves = vec![false; nodes.parents.len()];
        let mut moving = Vec::new();
        for &node in &nodes.order {
            let parent = nodes.parents[node as usize];
            let slot = slots[node as usize];
            if slot.is_some() || parent.is_some_and(|parent| moves[parent as usize]) {
                moves[node as usize] = true;
                let parent_from_node = nodes.parent_from_node[node as usize];
                moving.push(Moving { node, parent, slot, parent_from_node });
            }
        }
        let world_from_node = nodes.to_world(nodes.parent_from_node.clone());
        Self { world_from_node, weights: weights.weights.clone(), animated, slot_of_channel, moving, far: None }
    }

    /// Changes the origin of poses.
    pub(super) fn place(&mut self, far: Far) {
        self.world_from_node = far.near_from_node();
        self.far = Some(far);
    }

    /// Origin of poses in the world.
    pub(super) fn origin(&self) -> DVec3 {
        self.far.as_ref().map_or(DVec3::ZERO, |far| far.origin)
    }
}

/// The weights of the morph targets of all nodes at rest.
#[derive(Debug)]
pub(super) struct MorphWeights {
    weights: Vec<f32>,
    /// Each node's first index in `weights`, and the end.
    pub(super) first_of_node: Vec<u32>,
}

impl MorphWeights {
    /// Reads the weights of nodes, or else of their meshes, or else zeros.
    ///
    /// # Errors
    /// Where a node's mesh doesn't exist, or all nodes together have absurdly many weights.
    pub(super) fn read(document: &Document) -> Result<Self, Error> {
        const MAX_WEIGHTS: usize = 1 << 26;
        let mut read = Self { weights: Vec::new(), first_of_node: vec![0] };
        for (number, node) in document.json.nodes.iter().enumerate() {
            if let Some(mesh) = node.mesh {
                let location = format_args!("nodes[{number}].mesh");
                let mesh = document.element(&document.json.meshes, "meshes", mesh.value(), location)?;
                let targets = mesh.primitives.iter().map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len));
                let end = read.weights.len() + targets.max().unwrap_or(0);
                if end > MAX_WEIGHTS {
                    let cause = format!("the nodes so far have {end} morph weights; {MAX_WEIGHTS} are the most");
                    return Err(document.malformed(format_args!("nodes[{number}]"), cause));
                }
                let given = node.weights.as_ref().or(mesh.weights.as_ref());
                let new = end - read.weights.len();
                read.weights.extend(given.into_iter().flatten().take(new));
                read.weights.resize(end, 0.0);
            }
            read.first_of_node.push(read.weights.len() as u32);
        }
        Ok(read)
    }

    /// Number of weights of node `node`.
    pub(super) fn count(&self, node: usize) -> usize {
        (self.first_of_node[node + 1] - self.first_of_node[node]) as usize
    }
}
