//! Whether what a frame is made of belongs together.

use std::f32::consts::FRAC_PI_2;

use rayon::prelude::*;
use umbrage_rays::{Camera, LightSource, Projection};

use crate::{Frame, Light, Material, Materials, TextureUse};

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
    /// The first triangle with a corner past the last vertex.
    #[error("triangle {triangle} has vertex {vertex} of {vertices}")]
    Vertex {
        /// Its id.
        triangle: usize,
        /// The corner.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The first triangle with a material past the last one.
    #[error("triangle {triangle} has material {material} of {materials}")]
    Material {
        /// Its id.
        triangle: usize,
        /// The material.
        material: u32,
        /// How many materials there are.
        materials: usize,
    },
    /// The first material with a texture past the last one.
    #[error("material {material} has texture {texture} of {textures}")]
    Texture {
        /// Its index.
        material: usize,
        /// The texture.
        texture: u32,
        /// How many textures there are.
        textures: usize,
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
        let (mesh, vertices) = (&*self.mesh, self.positions.len());
        let is_bad = |triangle: &[u32; 3]| triangle.iter().any(|&vertex| vertex as usize >= vertices);
        if let Some(triangle) = mesh.triangles.par_iter().position_first(is_bad) {
            let corners = mesh.triangles[triangle];
            let vertex = corners.into_iter().find(|&vertex| vertex as usize >= vertices).unwrap_or_default();
            return Err(BadFrame::Vertex { triangle, vertex, vertices });
        }
        let materials = self.materials.materials.len();
        let is_bad = |&material: &u32| material as usize >= materials;
        if let Some(triangle) = mesh.material_of_triangle.par_iter().position_first(is_bad) {
            return Err(BadFrame::Material { triangle, material: mesh.material_of_triangle[triangle], materials });
        }
        check_textures(&self.materials)?;
        for (light, of) in lights.iter().enumerate() {
            check_light(of).map_err(|cause| BadFrame::Light { light, cause })?;
        }
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

fn check_textures(Materials { materials, textures }: &Materials) -> Result<(), BadFrame> {
    for (index, material) in materials.iter().enumerate() {
        for TextureUse { texture, .. } in textures_of(material).into_iter().flatten() {
            if texture as usize >= textures.len() {
                return Err(BadFrame::Texture { material: index, texture, textures: textures.len() });
            }
        }
    }
    Ok(())
}

fn textures_of(material: &Material) -> [Option<TextureUse>; 7] {
    [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.occlusion_texture,
        material.emissive_texture,
        material.transmission_texture,
        material.volume.thickness_texture,
    ]
}

fn check_light(light: &Light) -> Result<(), &'static str> {
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
    Ok(())
}

fn check_camera(camera: &Camera) -> Result<(), &'static str> {
    let Camera { position, right, up, forward, projection } = *camera;
    if ![position, right, up, forward].iter().all(|vector| vector.is_finite()) {
        return Err("its position or an axis is not finite");
    }
    let (Projection::Perspective { tan_half_height: size } | Projection::Orthographic { half_height: size }) =
        projection;
    if size.is_finite() && size > 0.0 { Ok(()) } else { Err("its view's height is not above zero") }
}
