//! A glTF scene at one moment: animated nodes, then everything that follows them.

use std::sync::{Arc, PoisonError};

use glam::{Affine3A, Vec3};
use gltf::json::animation::Property;
use umbrage_scene::rig::{Pose, Rig};
use umbrage_scene::{
    Animated, Animation, Error, Frame, Materials, NamedCamera, check_camera, check_light, check_material,
};

use super::GltfScene;
use super::animation::Animations;
use super::attached::{NodeCamera, NodeLight};
use super::far::{Far, FarNodes};
use super::matrices::MatrixSource;
use super::moved::change_material;
use super::nodes::Trs;
use super::rest::Rest;

/// Intermediate results of a pose before its vertices. Kept by the scene, so that a later pose allocates nothing.
#[derive(Debug)]
pub(super) struct Scratch {
    /// Local transform of each animated node.
    locals: Vec<Trs>,
    /// World transform of each node, from the scene's origin.
    pub(super) world_from_node: Vec<Affine3A>,
    pub(super) pose: Pose,
    /// Nodes of a scene far from the origin of its coordinates.
    far: Option<FarNodes>,
}

impl Animated for GltfScene {
    fn duration_seconds(&self) -> f64 {
        self.animations.duration_seconds
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        self.at(seconds, frame, |pose, frame| self.rig.pose(pose, frame))
    }

    fn origin(&self) -> [f64; 3] {
        self.rest.origin().into()
    }

    fn rig(&self) -> Option<&Arc<Rig>> {
        Some(&self.rig)
    }

    fn pose_rig(&self, seconds: f64, frame: &mut Frame, pose: &mut Pose) -> Result<(), Error> {
        self.at(seconds, frame, |new, frame| {
            pose.matrices.clone_from(&new.matrices);
            pose.weights.clone_from(&new.weights);
            frame.positions.clear();
            frame.normals.clear();
            frame.tangents.clear();
        })
    }

    fn animations(&self) -> &[Animation] {
        &self.animations.animations
    }

    fn variants(&self) -> &[String] {
        &self.variants
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

impl GltfScene {
    /// Fills a frame except for its vertices, which `pose_vertices` computes.
    ///
    /// # Errors
    /// Where a camera or a light is invalid: products of nodes' transforms may overflow.
    fn at(&self, seconds: f64, frame: &mut Frame, pose_vertices: impl FnOnce(&Pose, &mut Frame)) -> Result<(), Error> {
        // Not held while posing: a thread that waits for others may be given another pose to do in the meantime.
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut scratch = idle.unwrap_or_else(|| self.scratch());
        self.animate(seconds, &mut scratch);
        let moved = &self.animations.moved;
        let visible = self.visibility.as_ref().map(|visibility| visibility.at(seconds, moved));
        frame.mesh = match (&self.visibility, &visible) {
            (Some(visibility), Some(visible)) => visibility.mesh(visible),
            _ => Arc::clone(&self.mesh),
        };
        frame.materials = self.materials_at(seconds)?;
        frame.cameras.extend(self.cameras.iter().map(|camera| {
            let mut named = camera.at(&scratch.world_from_node[camera.node as usize]);
            moved.iter().for_each(|moved| moved.change_camera(camera.number, seconds, &mut named));
            named
        }));
        let is_lit = |light: &&NodeLight| visible.as_ref().is_none_or(|visible| visible[light.node as usize]);
        let lights = self.lights.iter().filter(is_lit);
        frame.lights.extend(lights.map(|light| {
            let mut there = light.at(&scratch.world_from_node[light.node as usize]);
            moved.iter().for_each(|moved| moved.change_light(light.number, seconds, &mut there));
            there
        }));
        pose_vertices(&scratch.pose, frame);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(scratch);
        for (NodeCamera { node, .. }, NamedCamera { name, camera }) in self.cameras.iter().zip(&frame.cameras) {
            check_camera(camera).map_err(|cause| self.is_nowhere(*node, "camera", name, seconds, cause))?;
        }
        for (NodeLight { node, .. }, light) in self.lights.iter().filter(is_lit).zip(&frame.lights) {
            check_light(light).map_err(|cause| self.is_nowhere(*node, "light", &light.name, seconds, cause))?;
        }
        Ok(())
    }

    /// The materials at a moment: the same ones always, unless an animation changes some.
    ///
    /// # Errors
    /// Where one of their numbers overflows, as splines may.
    fn materials_at(&self, seconds: f64) -> Result<Arc<Materials>, Error> {
        if self.emissions.is_empty() {
            return Ok(Arc::clone(&self.materials));
        }
        let mut materials = (*self.materials).clone();
        for (number, (emission, material)) in self.emissions.iter().zip(&mut materials.materials).enumerate() {
            change_material(&self.animations.moved, number, seconds, *emission, material);
            check_material(material).map_err(|cause| {
                Error::malformed(&self.path, format!("materials[{number}]"), format!("at {seconds} seconds: {cause}"))
            })?;
        }
        Ok(Arc::new(materials))
    }

    fn is_nowhere(&self, node: u32, what: &str, name: &str, seconds: f64, cause: &str) -> Error {
        let cause = format!("at {seconds} seconds, of the {what} `{name}`: {cause}");
        Error::malformed(&self.path, format!("nodes[{node}]"), cause)
    }

    fn scratch(&self) -> Scratch {
        let mut scratch = Scratch::new(&self.rest);
        scratch.pose.matrices = self.matrix_sources.iter().map(|source| scratch.matrix(source, &self.rest)).collect();
        scratch
    }

    /// Fills `scratch` for a moment. Values that no channel moves are in it already, and stay.
    fn animate(&self, seconds: f64, scratch: &mut Scratch) {
        scratch.move_nodes(&self.rest, &self.animations, seconds);
        let moving = self.matrix_sources[..self.rig.moving_matrices].iter().enumerate();
        moving.for_each(|(index, source)| scratch.pose.matrices[index] = scratch.matrix(source, &self.rest));
    }
}

impl Scratch {
    /// All nodes at rest, and no matrices.
    pub(super) fn new(rest: &Rest) -> Self {
        Self {
            locals: rest.animated.clone(),
            pose: Pose { matrices: Vec::new(), weights: rest.weights.clone() },
            world_from_node: rest.world_from_node.clone(),
            far: rest.far.as_ref().map(Far::nodes),
        }
    }

    /// Applies all channels at a moment, without computing matrices.
    pub(super) fn move_nodes(&mut self, rest: &Rest, animations: &Animations, seconds: f64) {
        for (channel, &slot) in animations.channels.iter().zip(&rest.slot_of_channel) {
            let slot = slot as usize;
            let mut value = [0.0; 4];
            match channel.property {
                Property::MorphTargetWeights => {
                    let weights = &mut self.pose.weights[slot..][..channel.curve.width];
                    channel.curve.sample(seconds, weights);
                }
                Property::Translation => {
                    channel.curve.sample(seconds, &mut value[..3]);
                    self.locals[slot].translation = Vec3::from_slice(&value);
                }
                Property::Scale => {
                    channel.curve.sample(seconds, &mut value[..3]);
                    self.locals[slot].scale = Vec3::from_slice(&value);
                }
                Property::Rotation => {
                    channel.curve.sample(seconds, &mut value);
                    self.locals[slot].rotation = super::nodes::rotation(value);
                }
            }
        }
        if let (Some(far), Some(nodes)) = (&rest.far, &mut self.far) {
            far.follow(rest, animations, &self.locals, nodes, &mut self.world_from_node);
            return;
        }
        for moving in &rest.moving {
            let parent_from_node = match moving.slot {
                Some(slot) => self.locals[slot as usize].parent_from_node(),
                None => moving.parent_from_node,
            };
            self.world_from_node[moving.node as usize] = moving.to_world(parent_from_node, &self.world_from_node);
        }
    }

    /// The matrix of a source, with nodes where they are now.
    pub(super) fn matrix(&self, source: &MatrixSource, rest: &Rest) -> Affine3A {
        match &self.far {
            Some(nodes) => source.far(nodes, rest.origin()),
            None => source.at(&self.world_from_node),
        }
    }
}
