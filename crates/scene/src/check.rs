//! Validation of frames: counts, indices, lights, cameras and materials.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::{Camera, LightSource, Projection};

use crate::{Frame, Light, LightShape, Material, Materials};

/// An error in a frame that was made by hand.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BadFrame {
    /// A list has another length than the list that it belongs to.
    #[error("{count} {what} for {expected} {of_what}")]
    Count {
        /// Name of the list.
        what: &'static str,
        /// Its length.
        count: usize,
        /// Name of the list that it belongs to.
        of_what: &'static str,
        /// Length of that list, which is the expected one.
        expected: usize,
    },
    /// The first triangle with a corner past the last vertex or a material past the last one, or the first material with a
    /// texture past the last one.
    #[error("{holder} {number} has {what} {index} of {count}")]
    Index {
        /// Kind of the item that holds the index.
        holder: &'static str,
        /// Its own index.
        number: usize,
        /// Kind of the indexed item.
        what: &'static str,
        /// The index, out of range.
        index: u32,
        /// Length of the indexed list.
        count: usize,
    },
    /// The first invalid light.
    #[error("light {light}: {cause}")]
    Light {
        /// Its index.
        light: usize,
        /// The reason, in words.
        cause: &'static str,
    },
    /// The first invalid camera.
    #[error("camera {camera}: {cause}")]
    Camera {
        /// Its index.
        camera: usize,
        /// The reason, in words.
        cause: &'static str,
    },
    /// The first material with a number that isn't finite.
    #[error("material {material}: {cause}")]
    Material {
        /// Its index.
        material: usize,
        /// The reason, in words.
        cause: &'static str,
    },
}

impl Frame {
    /// Checks that the frame can be rendered: indices are in range, each triangle has a material, attributes of vertices
    /// are complete or empty, and numbers of lights, cameras and materials are valid. Frames posed by scenes pass.
    ///
    /// Positions may be NaN or infinite: their triangles are left out.
    ///
    /// # Errors
    /// The first error found.
    pub fn check(&self) -> Result<(), BadFrame> {
        self.check_lit_by(&self.lights)
    }

    /// As [`Frame::check`], but lit by `lights` rather than the frame's own.
    ///
    /// # Errors
    /// The first error found.
    pub fn check_lit_by(&self, lights: &[Light]) -> Result<(), BadFrame> {
        self.check_counts()?;
        let Materials { materials, textures } = &*self.materials;
        check_indices(["triangle", "vertex"], &self.mesh.triangles, |corners| *corners, self.positions.len())?;
        let of_triangle = &self.mesh.material_of_triangle;
        check_indices(["triangle", "material"], of_triangle, |&material| [material], materials.len())?;
        let marks = &self.mesh.marks;
        check_indices(["point", "vertex"], marks.points(), |&vertex| [vertex], self.positions.len())?;
        check_indices(["line", "vertex"], marks.lines(), |line| *line, self.positions.len())?;
        check_indices(["run of points and lines", "material"], &marks.materials(), |&of| [of], materials.len())?;
        let used = |material: &Material| {
            let of_layers = material.layers.as_ref().map_or([None; 10], |layers| layers.textures());
            material.textures().into_iter().chain(of_layers).flatten().map(|used| used.texture)
        };
        check_indices(["material", "texture"], materials, used, textures.len())?;
        for (material, of) in materials.iter().enumerate() {
            check_material(of).map_err(|cause| BadFrame::Material { material, cause })?;
        }
        check_lights(lights)?;
        for (camera, named) in self.cameras.iter().enumerate() {
            check_camera(&named.camera).map_err(|cause| BadFrame::Camera { camera, cause })?;
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), BadFrame> {
        let (triangles, materials) = (self.mesh.triangles.len(), self.mesh.material_of_triangle.len());
        if materials != triangles {
            let (what, of_what) = ("materials", "triangles");
            return Err(BadFrame::Count { what, count: materials, of_what, expected: triangles });
        }
        let [first_set, second_set] = &self.mesh.tex_coords;
        for (what, count) in [
            ("normals", self.normals.len()),
            ("tangents", self.tangents.len()),
            ("texture coordinates of set 0", first_set.len()),
            ("texture coordinates of set 1", second_set.len()),
            ("colours", self.mesh.colors.len()),
        ] {
            let expected = self.positions.len();
            if count != 0 && count != expected {
                return Err(BadFrame::Count { what, count, of_what: "vertices", expected });
            }
        }
        Ok(())
    }
}

/// Checks that all indices of `holders` are below `count`.
fn check_indices<T: Sync, I: IntoIterator<Item = u32>>(
    [holder, what]: [&'static str; 2],
    holders: &[T],
    indices: impl Fn(&T) -> I + Sync,
    count: usize,
) -> Result<(), BadFrame> {
    let bad = |of: &T| indices(of).into_iter().find(|&index| index as usize >= count);
    match holders.par_iter().enumerate().find_map_first(|(number, of)| Some((number, bad(of)?))) {
        Some((number, index)) => Err(BadFrame::Index { holder, number, what, index, count }),
        None => Ok(()),
    }
}

/// Checks that numbers of lights are finite and in range, as [`Frame::check`] does.
///
/// # Errors
/// The first error found.
pub fn check_lights(lights: &[Light]) -> Result<(), BadFrame> {
    let check = |(light, of)| check_light(of).map_err(|cause| BadFrame::Light { light, cause });
    lights.iter().enumerate().try_for_each(check)
}

/// Checks a light's numbers, as [`Frame::check`] does.
///
/// # Errors
/// The reason, in words.
pub fn check_light(light: &Light) -> Result<(), &'static str> {
    let (position, direction, cone) = match light.source {
        LightSource::Point { position } => (Some(position), None, None),
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            (Some(position), Some(direction), Some((inner_radians, outer_radians)))
        }
        LightSource::Directional { direction } => (None, Some(direction), None),
    };
    if position.is_some_and(|position| !position.is_finite()) {
        return Err("its position is not finite");
    }
    if direction.is_some_and(|direction| direction.try_normalize().is_none()) {
        return Err("its direction is not finite, or too short to be one");
    }
    if cone.is_some_and(|(inner, outer)| !(0.0 <= inner && inner <= outer && outer <= FRAC_PI_2)) {
        return Err("its cone's angles are not 0 ≤ inner ≤ outer ≤ π/2");
    }
    if !light.color.is_finite() || !light.intensity.is_finite() {
        return Err("its colour or intensity is not finite");
    }
    if light.range.is_some_and(|range| range.is_nan() || range <= 0.0) {
        return Err("its range is not above zero");
    }
    let is_length = |length: f32| (0.0..=f32::MAX).contains(&length);
    match light.shape {
        LightShape::Ball(degrees)
            if position.is_none() && !(0.0..=Light::MAX_SUN_RADIUS_DEGREES).contains(&degrees) =>
        {
            Err("its radius is not from 0 to 45 degrees")
        }
        LightShape::Ball(radius) | LightShape::Disk(radius) if !is_length(radius) => {
            Err("its radius is not from 0 to any finite number")
        }
        LightShape::Rectangle { width, height } if !is_length(width) || !is_length(height) => {
            Err("its width or height is not from 0 to any finite number")
        }
        LightShape::Rectangle { .. } | LightShape::Disk(_) if cone.is_none_or(|(_, outer)| outer != FRAC_PI_2) => {
            Err("it is flat, but not a spot that sends its light to one side, with an outer angle of π/2")
        }
        _ => Ok(()),
    }
}

/// Checks that a material's numbers are finite, as [`Frame::check`] does.
///
/// # Errors
/// The reason, in words.
pub fn check_material(material: &Material) -> Result<(), &'static str> {
    let Material {
        base_color,
        metallic,
        roughness,
        emissive,
        normal_scale,
        occlusion_strength,
        transmission,
        ior,
        dispersion,
        ref volume,
        ref layers,
        ..
    } = *material;
    let numbers =
        [metallic, roughness, normal_scale, occlusion_strength, transmission, ior, dispersion, volume.thickness];
    let is_finite = base_color.is_finite()
        && emissive.is_finite()
        && volume.attenuation_color.is_finite()
        && layers.as_ref().is_none_or(|layers| layers.is_finite())
        && numbers.iter().all(|number| number.is_finite());
    if is_finite { Ok(()) } else { Err("one of its numbers is not finite") }
}

/// Checks that a camera's numbers are finite and its axes orthonormal, as [`Frame::check`] does.
///
/// # Errors
/// The reason, in words.
pub fn check_camera(camera: &Camera) -> Result<(), &'static str> {
    let Camera { position, right, up, forward, projection } = *camera;
    if ![position, right, up, forward].iter().all(|vector| vector.is_finite()) {
        return Err("its position or an axis is not finite");
    }
    // Tolerance for axes that went through f32 matrices.
    const OFF: f32 = 1e-2;
    let is_unit = |axis: Vec3| (axis.length_squared() - 1.0).abs() < OFF;
    let is_upright = |a: Vec3, b: Vec3| a.dot(b).abs() < OFF;
    let are_axes = is_unit(right) && is_unit(up) && is_unit(forward);
    if !(are_axes && is_upright(right, up) && is_upright(up, forward) && is_upright(forward, right)) {
        return Err("its axes are not of unit length and at right angles");
    }
    let (Projection::Perspective { tan_half_height: size } | Projection::Orthographic { half_height: size }) =
        projection;
    if size.is_finite() && size > 0.0 { Ok(()) } else { Err("its view's height is not above zero") }
}
