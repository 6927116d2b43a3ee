//! What a pixel shows, in words.

use glam::{DVec3, Vec3};
use umbrage::Sides;
use umbrage::rays::LightSource;
use umbrage::rays::View;
use umbrage::scene::{Frame, Light};

/// What is at a pixel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probe {
    pub(crate) pixel: [u32; 2],
    /// `None` for the background.
    pub(crate) surface: Option<Surface>,
}

/// A point of a triangle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    pub(crate) triangle: u32,
    pub(crate) is_front: bool,
    pub(crate) material: String,
    pub(crate) position: DVec3,
    pub(crate) distance: f64,
    pub(crate) normal: Vec3,
    /// For each light its name and what it does there.
    pub(crate) lights: Vec<(String, Lighting)>,
}

/// What a light does to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lighting {
    Lit,
    /// The point is outside of the light's cone, or farther away than it reaches.
    OutOfReach,
    /// It shines on the other side of the surface.
    Behind,
    /// A triangle keeps it away, so far from the point.
    Shadowed {
        by: u32,
        distance: f64,
    },
}

impl Probe {
    pub(crate) fn new(frame: &Frame, view: &View, pixel: [u32; 2], sides: Sides) -> Self {
        let surface = umbrage::Probe::new(frame, view, pixel, sides).map(|found| {
            let lights = frame.lights.iter().zip(&found.shadows).enumerate().map(|(number, (light, shadow))| {
                let lighting = match shadow {
                    Some(blocker) => Lighting::Shadowed { by: blocker.triangle, distance: blocker.distance },
                    None => unshadowed(light, found.position.as_vec3(), found.normal),
                };
                (light_name(number, light), lighting)
            });
            let material = frame.material(found.triangle);
            let number = frame.mesh.material_of_triangle[found.triangle as usize];
            Surface {
                triangle: found.triangle,
                is_front: found.is_front,
                material: if material.name.is_empty() { format!("number {number}") } else { material.name.clone() },
                position: found.position,
                distance: found.distance,
                normal: found.normal,
                lights: lights.collect(),
            }
        });
        Self { pixel, surface }
    }
}

/// What a light that nothing is in the way of does to a point.
fn unshadowed(light: &Light, position: Vec3, normal: Vec3) -> Lighting {
    let (from, is_in_cone) = match light.source {
        LightSource::Directional { direction } => (None, direction.dot(normal) < 0.0),
        LightSource::Point { position } => (Some(position), true),
        LightSource::Spot { position: from, direction, outer_radians, .. } => {
            let way = (position - from).normalize_or_zero();
            (Some(from), way.dot(direction) > outer_radians.cos())
        }
    };
    match (light.source, from) {
        (LightSource::Directional { .. }, _) => {
            if is_in_cone {
                Lighting::Lit
            } else {
                Lighting::Behind
            }
        }
        (_, Some(from)) if !is_in_cone || light.range.is_some_and(|range| from.distance(position) > range) => {
            Lighting::OutOfReach
        }
        (_, Some(from)) if (from - position).dot(normal) <= 0.0 => Lighting::Behind,
        _ => Lighting::Lit,
    }
}

/// A light's name, or else its number from 1.
pub(crate) fn light_name(number: usize, light: &Light) -> String {
    if light.name.is_empty() { format!("Light {}", number + 1) } else { light.name.to_string() }
}
