//! A glTF scene at one moment: animated nodes, then what they move.

use std::sync::{Arc, PoisonError};

use glam::{Affine3A, Vec3};
use gltf::json::animation::Property;

use super::GltfScene;
use super::attached::{NodeCamera, NodeLight};
use super::moved::change_material;
use super::nodes::Trs;
use crate::check::{check_light, check_material};
use crate::rig::{Pose, Rig};
use crate::{Animated, Animation, Error, Frame, Materials, NamedCamera, check_camera};

/// What a pose computes before its vertices. Kept by the scene, so that a later pose allocates nothing.
#[derive(Debug)]
pub(super) struct Scratch {
    /// For each of the scene's animated nodes.
    locals: Vec<Trs>,
    /// For each node.
    world_from_node: Vec<Affine3A>,
    pose: Pose,
}

impl Animated for GltfScene {
    fn duration_seconds(&self) -> f64 {
        self.animations.duration_seconds
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        self.at(seconds, frame, |pose, frame| self.rig.pose(pose, frame))
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
    /// Fills a frame but for its vertices, with which `pose_vertices` is left.
    ///
    /// # Errors
    /// Where a camera or a light is nowhere: numbers that nodes multiply may overflow.
    fn at(&self, seconds: f64, frame: &mut Frame, pose_vertices: impl FnOnce(&Pose, &mut Frame)) -> Result<(), Error> {
        // Not held while posing: a thread that waits for others may be given another pose to do in the meantime.
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut scratch = idle.unwrap_or_else(|| self.scratch());
        self.animate(seconds, &mut scratch);
        let visible = self.visibility.as_ref().map(|visibility| visibility.at(seconds));
        frame.mesh = match (&self.visibility, &visible) {
            (Some(visibility), Some(visible)) => visibility.mesh(visible),
            _ => Arc::clone(&self.mesh),
        };
        frame.materials = self.materials_at(seconds)?;
        let moved = &self.animations.moved;
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
        let world_from_node = self.rest.world_from_node.clone();
        let matrices = self.matrix_sources.iter().map(|source| source.at(&world_from_node)).collect();
        Scratch {
            locals: self.rest.animated.clone(),
            pose: Pose { matrices, weights: self.rest.weights.clone() },
            world_from_node,
        }
    }

    /// Fills `scratch` for a moment. What no channel moves is in it already, and stays.
    fn animate(&self, seconds: f64, scratch: &mut Scratch) {
        for (channel, &slot) in self.animations.channels.iter().zip(&self.rest.slot_of_channel) {
            let slot = slot as usize;
            let mut value = [0.0; 4];
            match channel.property {
                Property::MorphTargetWeights => {
                    let weights = &mut scratch.pose.weights[slot..][..channel.curve.width];
                    channel.curve.sample(seconds, weights);
                }
                Property::Translation => {
                    channel.curve.sample(seconds, &mut value[..3]);
                    scratch.locals[slot].translation = Vec3::from_slice(&value);
                }
                Property::Scale => {
                    channel.curve.sample(seconds, &mut value[..3]);
                    scratch.locals[slot].scale = Vec3::from_slice(&value);
                }
                Property::Rotation => {
                    channel.curve.sample(seconds, &mut value);
                    scratch.locals[slot].rotation = super::nodes::rotation(value);
                }
            }
        }
        for moving in &self.rest.moving {
            let parent_from_node = match moving.slot {
                Some(slot) => scratch.locals[slot as usize].parent_from_node(),
                None => moving.parent_from_node,
            };
            scratch.world_from_node[moving.node as usize] = match moving.parent {
                Some(parent) => scratch.world_from_node[parent as usize] * parent_from_node,
                None => parent_from_node,
            };
        }
        let moving = &mut scratch.pose.matrices[..self.rig.moving_matrices];
        for (matrix, source) in moving.iter_mut().zip(&self.matrix_sources) {
            *matrix = source.at(&scratch.world_from_node);
        }
    }
}
