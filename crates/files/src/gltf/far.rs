//! Scenes far from the origin of their coordinates: nodes in f64, from the JSON to matrices near an origin of their own.

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::json::animation::Property;
use serde::Deserialize;
use umbrage_scene::Error;

use super::animation::Animations;
use super::document::Document;
use super::nodes::{Nodes, Trs};
use super::rest::Rest;
use crate::origin::local;

/// Transforms of nodes at rest, in f64.
#[derive(Debug)]
pub(super) struct Far {
    /// Origin of poses in the world.
    pub(super) origin: DVec3,
    /// The transforms to their parents of all nodes.
    parent_from_node: Vec<DAffine3>,
    at_rest: FarNodes,
}

/// Nodes at a moment, in the world's coordinates.
#[derive(Clone, Debug)]
pub(super) struct FarNodes {
    /// World transform of each node.
    pub(super) world_from_node: Vec<DAffine3>,
    /// Local transform of each animated node.
    locals: Vec<FarTrs>,
}

/// As [`Trs`].
#[derive(Clone, Copy, Debug)]
struct FarTrs {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

/// The numbers of a node as the file has them.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct FarNode {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

impl FarTrs {
    fn parent_from_node(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl FarNode {
    fn trs(&self) -> FarTrs {
        if let Some(matrix) = &self.matrix {
            let (scale, rotation, translation) = DMat4::from_cols_array(matrix).to_scale_rotation_translation();
            return FarTrs { translation, rotation: unit(rotation), scale };
        }
        FarTrs {
            translation: self.translation.map_or(DVec3::ZERO, DVec3::from_array),
            rotation: self.rotation.map_or(DQuat::IDENTITY, |rotation| unit(DQuat::from_array(rotation))),
            scale: self.scale.map_or(DVec3::ONE, DVec3::from_array),
        }
    }

    fn parent_from_node(&self) -> DAffine3 {
        match &self.matrix {
            Some(matrix) => DAffine3::from_mat4(DMat4::from_cols_array(matrix)),
            None => self.trs().parent_from_node(),
        }
    }
}

fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY }
}

/// Converts a transform to the world to one to coordinates from `origin`.
pub(super) fn near(world_from_any: DAffine3, origin: DVec3) -> Affine3A {
    let DAffine3 { matrix3, translation } = world_from_any;
    Affine3A::from_mat3_translation(matrix3.as_mat3(), local(translation, origin))
}

/// The same numbers.
pub(super) fn wide(transform: &Affine3A) -> DAffine3 {
    let [x, y, z] = transform.matrix3.to_cols_array_2d().map(|axis| Vec3::from(axis).as_dvec3());
    DAffine3 { matrix3: glam::DMat3::from_cols(x, y, z), translation: Vec3::from(transform.translation).as_dvec3() }
}

impl Far {
    /// Reads the nodes of a file again.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub(super) fn read(
        document: &Document,
        nodes: &Nodes,
        animations: &Animations,
        rest: &Rest,
        origin: DVec3,
    ) -> Result<Self, Error> {
        document.take_for::<(FarNode, [DAffine3; 3])>(nodes.order.len(), "nodes")?;
        let of_file = document.far_nodes();
        let rounded = nodes.parent_from_node.iter().map(wide);
        let parent_from_node: Vec<DAffine3> = rounded
            .enumerate()
            .map(|(node, rounded)| of_file.get(node).map_or(rounded, FarNode::parent_from_node))
            .collect();
        let world_from_node = nodes.to_world(parent_from_node.clone());
        let mut locals: Vec<FarTrs> = rest.animated.iter().map(FarTrs::from).collect();
        for (channel, &slot) in animations.channels.iter().zip(&rest.slot_of_channel) {
            let of_file = of_file.get(channel.node as usize);
            if let (false, Some(node)) = (channel.property == Property::MorphTargetWeights, of_file) {
                locals[slot as usize] = node.trs();
            }
        }
        Ok(Self { origin, parent_from_node, at_rest: FarNodes { world_from_node, locals } })
    }

    /// The nodes at rest.
    pub(super) fn nodes(&self) -> FarNodes {
        self.at_rest.clone()
    }

    /// World transforms of all nodes at rest.
    pub(super) fn near_from_node(&self) -> Vec<Affine3A> {
        self.at_rest.world_from_node.iter().map(|&world_from_node| near(world_from_node, self.origin)).collect()
    }

    /// Moves nodes as their channels have moved `locals`, both those of `nodes` and those near the origin.
    pub(super) fn follow(
        &self,
        rest: &Rest,
        animations: &Animations,
        locals: &[Trs],
        nodes: &mut FarNodes,
        near_from_node: &mut [Affine3A],
    ) {
        for (channel, &slot) in animations.channels.iter().zip(&rest.slot_of_channel) {
            let moved = |nodes: &mut FarNodes, assign: fn(&mut FarTrs, FarTrs)| {
                assign(&mut nodes.locals[slot as usize], FarTrs::from(&locals[slot as usize]));
            };
            match channel.property {
                Property::Translation => moved(nodes, |to, from| to.translation = from.translation),
                Property::Rotation => moved(nodes, |to, from| to.rotation = from.rotation),
                Property::Scale => moved(nodes, |to, from| to.scale = from.scale),
                Property::MorphTargetWeights => {}
            }
        }
        for moving in &rest.moving {
            let node = moving.node as usize;
            let parent_from_node = match moving.slot {
                Some(slot) => nodes.locals[slot as usize].parent_from_node(),
                None => self.parent_from_node[node],
            };
            nodes.world_from_node[node] = moving.to_world(parent_from_node, &nodes.world_from_node);
            near_from_node[node] = near(nodes.world_from_node[node], self.origin);
        }
    }
}

impl From<&Trs> for FarTrs {
    fn from(trs: &Trs) -> Self {
        let Trs { translation, rotation, scale } = *trs;
        Self { translation: translation.as_dvec3(), rotation: unit(rotation.as_dquat()), scale: scale.as_dvec3() }
    }
}
