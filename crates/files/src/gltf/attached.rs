//! Cameras and lights attached to nodes.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use gltf::json;
use gltf::json::camera::Type;
use gltf::json::extensions::scene::khr_lights_punctual;
use gltf::json::validation::Checked;
use umbrage_rays::{Camera, LightSource, Projection};
use umbrage_scene::{Error, Light, NamedCamera};

use super::document::Document;
use super::nodes::Nodes;

/// Maximum ratio of a cone's inner angle to its outer one: a ratio of 1, an edge without softness, would divide by zero.
pub(super) const SHARPEST: f32 = 0.999;

/// A camera on a node.
#[derive(Debug)]
pub(super) struct NodeCamera {
    pub(super) node: u32,
    /// Its index in the file.
    pub(super) number: usize,
    name: Arc<str>,
    projection: Projection,
}

/// A light on a node.
#[derive(Debug)]
pub(super) struct NodeLight {
    pub(super) node: u32,
    /// Its index in the file.
    pub(super) number: usize,
    /// The light; the position and direction of its source are placeholders.
    light: Light,
}

/// Reads the cameras of the scene's nodes, including hidden ones, as the extension says.
///
/// # Errors
/// Where an index is out of range.
pub(super) fn cameras(
    document: &Document,
    nodes: &Nodes,
    warnings: &mut Vec<String>,
) -> Result<Vec<NodeCamera>, Error> {
    let mut cameras = Vec::new();
    for (number, node) in among(document, &nodes.in_scene) {
        let Some(camera) = node.camera else { continue };
        let location = format_args!("nodes[{number}].camera");
        let json = document.element(&document.json.cameras, "cameras", camera.value(), location)?;
        let Some(projection) = projection(json) else {
            warnings.push(format!("cameras[{}] was left out, as it sees nothing", camera.value()));
            continue;
        };
        let name = node.name.as_ref().or(json.name.as_ref()).map_or("", String::as_str);
        cameras.push(NodeCamera { node: number as u32, number: camera.value(), name: name.into(), projection });
    }
    Ok(cameras)
}

/// Reads the lights of the visible nodes.
///
/// # Errors
/// Where an index is out of range.
pub(super) fn lights(document: &Document, nodes: &Nodes, warnings: &mut Vec<String>) -> Result<Vec<NodeLight>, Error> {
    let extension = document.json.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let all = extension.map_or(&[][..], |extension| &extension.lights);
    let mut lights = Vec::new();
    for (number, node) in among(document, &nodes.visible) {
        let Some(light) = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref())
        else {
            continue;
        };
        let of_file = light.light.value();
        let location = format_args!("nodes[{number}].extensions.KHR_lights_punctual.light");
        let json = document.element(all, "extensions.KHR_lights_punctual.lights", of_file, location)?;
        let Some(source) = source(json, of_file, warnings) else {
            warnings.push(format!("light {of_file} was left out, as its type is none of point, spot and directional"));
            continue;
        };
        let name = node.name.as_ref().or(json.name.as_ref()).map_or("", String::as_str);
        let color = Vec3::from_array(json.color);
        if json.intensity < 0.0 || color.min_element() < 0.0 {
            warnings.push(format!("light {of_file} has a negative colour or intensity, which was taken as 0"));
        }
        let range = json.range.filter(|&range| range > 0.0 && range.is_finite());
        if json.range.is_some() && range.is_none() {
            warnings.push(format!("the range of light {of_file} is not above 0 and was left out"));
        }
        let not_negative = |number: f32| if number < 0.0 { 0.0 } else { number };
        let made = Light::new(source, not_negative(json.intensity));
        let light = Light { name: name.into(), color: color.map(not_negative), range, ..made };
        lights.push(NodeLight { node: number as u32, number: of_file, light });
    }
    Ok(lights)
}

fn among<'a>(document: &'a Document, chosen: &'a [bool]) -> impl Iterator<Item = (usize, &'a json::Node)> {
    document.json.nodes.iter().enumerate().filter(|&(number, _)| chosen[number])
}

fn projection(json: &json::Camera) -> Option<Projection> {
    let positive = |number: f32| (number > 0.0 && number.is_finite()).then_some(number);
    match json.type_ {
        Checked::Valid(Type::Perspective) => {
            let angle = positive(json.perspective.as_ref()?.yfov).filter(|&angle| angle < PI)?;
            Some(Projection::Perspective { tan_half_height: positive(libm::tanf(0.5 * angle))? })
        }
        Checked::Valid(Type::Orthographic) => {
            Some(Projection::Orthographic { half_height: positive(json.orthographic.as_ref()?.ymag.abs())? })
        }
        Checked::Invalid => None,
    }
}

fn source(json: &khr_lights_punctual::Light, number: usize, warnings: &mut Vec<String>) -> Option<LightSource> {
    let (position, direction) = (Vec3::ZERO, Vec3::NEG_Z);
    match json.type_ {
        Checked::Valid(khr_lights_punctual::Type::Point) => Some(LightSource::Point { position }),
        Checked::Valid(khr_lights_punctual::Type::Directional) => Some(LightSource::Directional { direction }),
        Checked::Valid(khr_lights_punctual::Type::Spot) => {
            let spot = json.spot.clone().unwrap_or_default();
            let asked = (spot.inner_cone_angle, spot.outer_cone_angle);
            let outer_radians = if asked.1 > 0.0 { asked.1.min(FRAC_PI_2) } else { std::f32::consts::FRAC_PI_4 };
            let inner_radians = asked.0.clamp(0.0, outer_radians * SHARPEST);
            if (inner_radians, outer_radians) != asked {
                warnings.push(format!(
                    "the cone of light {number} was mended to {inner_radians} … {outer_radians} radians"
                ));
            }
            Some(LightSource::Spot { position, direction, inner_radians, outer_radians })
        }
        Checked::Invalid => None,
    }
}

impl NodeCamera {
    /// The camera at its node's transform. The node's scale and shear don't change the camera's axes, but mirroring does.
    pub(super) fn at(&self, world_from_node: &Affine3A) -> NamedCamera {
        let axes = world_from_node.matrix3;
        let forward = Vec3::from(-axes.z_axis).try_normalize().unwrap_or(Vec3::NEG_Z);
        let upright = |axis: Vec3| axis.reject_from_normalized(forward).try_normalize();
        let right = upright(axes.x_axis.into()).unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let up = if up.dot(axes.y_axis.into()) < 0.0 { -up } else { up };
        let position = world_from_node.translation.into();
        NamedCamera {
            name: Arc::clone(&self.name),
            camera: Camera { position, right, up, forward, projection: self.projection },
        }
    }
}

impl NodeLight {
    /// The light at its node's transform. The node's scale changes neither its strength nor its range.
    pub(super) fn at(&self, world_from_node: &Affine3A) -> Light {
        let here = Vec3::from(world_from_node.translation);
        let along = Vec3::from(-world_from_node.matrix3.z_axis).try_normalize().unwrap_or(Vec3::NEG_Z);
        let mut light = self.light.clone();
        match &mut light.source {
            LightSource::Point { position } => *position = here,
            LightSource::Directional { direction } => *direction = along,
            LightSource::Spot { position, direction, .. } => (*position, *direction) = (here, along),
        }
        light
    }
}
