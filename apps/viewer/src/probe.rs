//! Descriptions of a pixel's surface.

use glam::Vec3;
use umbrage::Sides;
use umbrage::rays::{LightSource, View};
use umbrage::scene::{Frame, Light};

/// The surface at a pixel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probe {
    pub(crate) pixel: [u32; 2],
    /// `None` for the background.
    pub(crate) surface: Option<Surface>,
}

/// A point of a triangle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    pub(crate) found: umbrage::Probe,
    pub(crate) material: String,
    /// Each light's name and its effect at the point, in words.
    pub(crate) lights: Vec<(String, String)>,
}

impl Probe {
    pub(crate) fn new(frame: &Frame, view: &View, pixel: [u32; 2], sides: Sides) -> Self {
        let surface = umbrage::Probe::new(frame, view, pixel, sides).map(|found| {
            let lights = frame.lights.iter().zip(&found.shadows).enumerate().map(|(number, (light, shadow))| {
                let lighting = match shadow {
                    Some(by) => format!("shadowed by triangle {}, {:.5} away", by.triangle, by.distance),
                    None => unshadowed(light, found.position.as_vec3(), found.normal).to_owned(),
                };
                (light_name(number, light), lighting)
            });
            let material = frame.material(found.triangle);
            let number = frame.mesh.material_of_triangle[found.triangle as usize];
            Surface {
                material: if material.name.is_empty() { format!("number {number}") } else { material.name.clone() },
                lights: lights.collect(),
                found,
            }
        });
        Self { pixel, surface }
    }
}

/// The effect of an unoccluded light at a point, in words.
fn unshadowed(light: &Light, position: Vec3, normal: Vec3) -> &'static str {
    let (to_light, is_in_cone) = match light.source {
        LightSource::Directional { direction } => (-direction, true),
        LightSource::Point { position: from } => (from - position, true),
        LightSource::Spot { position: from, direction, outer_radians, .. } => {
            let way = (position - from).normalize_or_zero();
            (from - position, way.dot(direction) > outer_radians.cos())
        }
    };
    let is_sun = matches!(light.source, LightSource::Directional { .. });
    if !is_in_cone || !is_sun && light.range.is_some_and(|range| to_light.length() > range) {
        // Outside of the cone or the range.
        "out of reach"
    } else if to_light.dot(normal) <= 0.0 {
        "shines on the other side"
    } else {
        "lit"
    }
}

/// A light's name, or else its number from 1.
pub(crate) fn light_name(number: usize, light: &Light) -> String {
    if light.name.is_empty() { format!("Light {}", number + 1) } else { light.name.to_string() }
}
