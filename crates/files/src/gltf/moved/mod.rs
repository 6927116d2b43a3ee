//! `KHR_animation_pointer`: the visibility of nodes, and the numbers of materials, lights and cameras that an animation changes.

mod material;

use std::f32::consts::{FRAC_PI_2, PI};

use umbrage_rays::{LightSource, Projection};
use umbrage_scene::{Error, Light, NamedCamera};

use super::curve::Curve;
use super::document::Document;

use material::MaterialNumber;
pub(super) use material::{Emission, change as change_material};

/// A pointer's target: a node, or a material, light or camera of the file and one of its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Target {
    Material(usize, MaterialNumber),
    Light(usize, LightNumber),
    Camera(usize, CameraNumber),
    /// A node's own visibility.
    Visibility(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum LightNumber {
    Color,
    Intensity,
    Range,
    InnerAngle,
    OuterAngle,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum CameraNumber {
    /// Vertical field of view of a perspective camera, in radians.
    Angle,
    /// Half height of an orthographic view.
    HalfHeight,
}

/// One number, or one colour, over time.
#[derive(Debug)]
pub(super) struct Moved {
    pub(super) target: Target,
    pub(super) curve: Curve,
}

impl Target {
    /// Parses a pointer; `None` for properties that can't be animated.
    pub(super) fn of(pointer: &str) -> Option<Self> {
        if let Some(of_node) = pointer.strip_prefix("/nodes/") {
            let node = of_node.strip_suffix("/extensions/KHR_node_visibility/visible")?;
            return Some(Self::Visibility(node.parse().ok()?));
        }
        if let Some(of_light) = pointer.strip_prefix("/extensions/KHR_lights_punctual/lights/") {
            let (light, name) = of_light.split_once('/')?;
            let number = match name {
                "color" => LightNumber::Color,
                "intensity" => LightNumber::Intensity,
                "range" => LightNumber::Range,
                "spot/innerConeAngle" => LightNumber::InnerAngle,
                "spot/outerConeAngle" => LightNumber::OuterAngle,
                _ => return None,
            };
            return Some(Self::Light(light.parse().ok()?, number));
        }
        if let Some(of_material) = pointer.strip_prefix("/materials/") {
            let (material, path) = of_material.split_once('/')?;
            return Some(Self::Material(material.parse().ok()?, MaterialNumber::of(path)?));
        }
        let (camera, name) = pointer.strip_prefix("/cameras/")?.split_once('/')?;
        let number = match name {
            "perspective/yfov" => CameraNumber::Angle,
            "orthographic/ymag" => CameraNumber::HalfHeight,
            _ => return None,
        };
        Some(Self::Camera(camera.parse().ok()?, number))
    }

    /// Checks that the target exists, which `location` in the JSON refers to.
    ///
    /// # Errors
    /// Where it doesn't.
    pub(super) fn check(self, document: &Document, location: &str) -> Result<(), Error> {
        let json = &document.json;
        let lights = json.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        let lights = lights.map_or(&[][..], |extension| &extension.lights);
        match self {
            Self::Material(number, _) => document.element(&json.materials, "materials", number, location).map(drop),
            Self::Light(number, _) => document.element(lights, "lights", number, location).map(drop),
            Self::Camera(number, _) => document.element(&json.cameras, "cameras", number, location).map(drop),
            Self::Visibility(node) => document.element(&json.nodes, "nodes", node, location).map(drop),
        }
    }

    /// Number of components of a keyframe.
    pub(super) fn components(self) -> usize {
        match self {
            Self::Material(_, number) => number.components(),
            Self::Light(_, LightNumber::Color) => 3,
            Self::Light(..) | Self::Camera(..) | Self::Visibility(_) => 1,
        }
    }
}

impl Moved {
    /// Changes `light`, if this moves light `number` of the file.
    pub(super) fn change_light(&self, number: usize, seconds: f64, light: &mut Light) {
        let Target::Light(of, moved) = self.target else { return };
        if of != number {
            return;
        }
        let mut value = [0.0; 3];
        self.curve.sample(seconds, &mut value[..self.curve.width]);
        match (moved, &mut light.source) {
            (LightNumber::Color, _) => light.color = value.into(),
            (LightNumber::Intensity, _) => light.intensity = value[0],
            (LightNumber::Range, _) => light.range = Some(value[0]).filter(|range| *range > 0.0),
            (LightNumber::InnerAngle, LightSource::Spot { inner_radians, outer_radians, .. }) => {
                *inner_radians = value[0].clamp(0.0, *outer_radians * super::attached::SHARPEST);
            }
            (LightNumber::OuterAngle, LightSource::Spot { inner_radians, outer_radians, .. }) => {
                *outer_radians = value[0].clamp(f32::MIN_POSITIVE, FRAC_PI_2);
                *inner_radians = inner_radians.min(*outer_radians * super::attached::SHARPEST);
            }
            _ => {}
        }
    }

    /// Changes `named`, if this moves camera `number` of the file.
    pub(super) fn change_camera(&self, number: usize, seconds: f64, named: &mut NamedCamera) {
        let Target::Camera(of, moved) = self.target else { return };
        if of != number {
            return;
        }
        let mut value = [0.0];
        self.curve.sample(seconds, &mut value);
        let [value] = value;
        match (moved, &mut named.camera.projection) {
            (CameraNumber::Angle, Projection::Perspective { tan_half_height }) => {
                // A flat view, as wide as a view can be, where the file goes beyond.
                *tan_half_height = libm::tanf(0.5 * value.clamp(1e-3, PI - 1e-3));
            }
            (CameraNumber::HalfHeight, Projection::Orthographic { half_height }) => {
                *half_height = value.abs().max(f32::MIN_POSITIVE);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_to_lights_and_cameras_are_understood() {
        let light = |number| Some(Target::Light(12, number));
        for (pointer, target) in [
            ("/extensions/KHR_lights_punctual/lights/12/color", light(LightNumber::Color)),
            ("/extensions/KHR_lights_punctual/lights/12/spot/outerConeAngle", light(LightNumber::OuterAngle)),
            ("/extensions/KHR_lights_punctual/lights/12/name", None),
            ("/extensions/KHR_lights_punctual/lights/x/color", None),
            ("/cameras/3/perspective/yfov", Some(Target::Camera(3, CameraNumber::Angle))),
            ("/cameras/3/perspective/znear", None),
            (
                "/materials/3/emissiveFactor",
                MaterialNumber::of("emissiveFactor").map(|number| Target::Material(3, number)),
            ),
            ("/materials/3/name", None),
        ] {
            assert_eq!(Target::of(pointer), target, "{pointer}");
        }
    }
}
