//! Whether what a frame is made of belongs together.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::{Camera, LightSource, Projection};

use crate::{Frame, Light, LightShape, Material, Materials};

/// What is wrong with a frame that was made by hand.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BadFrame {
    /// There isn't one for each.
    #[error("{count} {what} for {expected} {of_what}")]
    Count {
        /// What there are too few or too many of.
        what: &'static str,
        /// How many.
        count: usize,
        /// What there should be one for each of.
        of_what: &'static str,
        /// How many there are of these.
        expected: usize,
    },
    /// The first triangle with a corner past the last vertex or a material past the last one, or the first material with a
    /// texture past the last one.
    #[error("{holder} {number} has {what} {index} of {count}")]
    Index {
        /// What points there.
        holder: &'static str,
        /// Which one.
        number: usize,
        /// What it points to.
        what: &'static str,
        /// Where that would be.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// The first light that is none.
    #[error("light {light}: {cause}")]
    Light {
        /// Its index.
        light: usize,
        /// What is wrong with it.
        cause: &'static str,
    },
    /// The first camera that is none.
    #[error("camera {camera}: {cause}")]
    Camera {
        /// Its index.
        camera: usize,
        /// What is wrong with it.
        cause: &'static str,
    },
    /// The first material with a number that is none.
    #[error("material {material}: {cause}")]
    Material {
        /// Its index.
        material: usize,
        /// What is wrong with it.
        cause: &'static str,
    },
}

impl Frame {
    /// Whether the frame can be rendered: all that points at something points at something that is there, vertices and
    /// triangles have all of what any of them has, lights and cameras are where and what their numbers say. Frames that
    /// scenes are posed as are so.
    ///
    /// Positions may be no numbers: such triangles are left out.
    ///
    /// # Errors
    /// What is wrong first.
    pub fn check(&self) -> Result<(), BadFrame> {
        self.check_lit_by(&self.lights)
    }

    /// As [`Frame::check`], but lit by `lights` rather than the frame's own.
    ///
    /// # Errors
    /// What is wrong first.
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

/// Whether all that the `holders` point to is among `count` of it.
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

/// Whether lights are where and what their numbers say, as [`Frame::check`] asks.
///
/// # Errors
/// What is wrong first.
pub fn check_lights(lights: &[Light]) -> Result<(), BadFrame> {
    let check = |(light, of)| check_light(of).map_err(|cause| BadFrame::Light { light, cause });
    lights.iter().enumerate().try_for_each(check)
}

pub(crate) fn check_light(light: &Light) -> Result<(), &'static str> {
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

pub(crate) fn check_material(material: &Material) -> Result<(), &'static str> {
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

/// Whether a camera is one, as [`Frame::check`] asks.
///
/// # Errors
/// What is wrong, in words.
pub fn check_camera(camera: &Camera) -> Result<(), &'static str> {
    let Camera { position, right, up, forward, projection } = *camera;
    if ![position, right, up, forward].iter().all(|vector| vector.is_finite()) {
        return Err("its position or an axis is not finite");
    }
    // Axes that went through matrices in f32 are as good as this.
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
