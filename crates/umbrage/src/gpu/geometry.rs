//! Uploads a frame's triangles, the input of the GPU's grids.

use std::sync::Arc;

use umbrage_gpu::{Geometry, Gpu, GpuError, MaskMaterial, MaskTexture, MaskVertex, TriangleFlags};
use umbrage_scene::rig::Rig;
use umbrage_scene::{Filter, Frame, Material, Materials, Mesh, OpaquePart, Texture, TextureUse};

use super::tables::wrap;
use crate::Sides;

/// A frame's triangles on the GPU; only new parts are uploaded.
#[derive(Debug)]
pub(super) struct FrameGeometry {
    geometry: Geometry,
    mesh: Option<Arc<Mesh>>,
    materials: Option<Arc<Materials>>,
    sides: Sides,
}

impl FrameGeometry {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { geometry: Geometry::new(gpu), mesh: None, materials: None, sides: Sides::default() }
    }

    /// Forgets the state of the GPU, so that everything is uploaded again.
    pub(super) fn forget(&mut self) {
        (self.mesh, self.materials) = (None, None);
    }

    /// Uploads a frame's vertices, and its other parts where they are new. For a rig, which the GPU poses, it only makes
    /// room for the vertices.
    ///
    /// # Errors
    /// Where a part is larger than the device allows.
    pub(super) fn upload(&mut self, gpu: &Gpu, frame: &Frame, rig: Option<&Rig>, sides: Sides) -> Result<(), GpuError> {
        match rig {
            Some(rig) => self.geometry.reserve_positions(gpu, rig.vertices as u32)?,
            None => self.geometry.write_positions(gpu, &frame.positions)?,
        }
        let has_mesh = self.mesh.as_ref().is_some_and(|mesh| Arc::ptr_eq(mesh, &frame.mesh));
        let has_materials = self.materials.as_ref().is_some_and(|old| Arc::ptr_eq(old, &frame.materials));
        if has_mesh && has_materials && self.sides == sides {
            return Ok(());
        }
        // The mesh is held, so that no other one takes its address; set only once it is uploaded.
        (self.mesh, self.materials, self.sides) = (None, None, sides);
        let flags: Vec<_> = frame.materials.materials.iter().map(|material| flags(material, sides)).collect();
        self.geometry.write_triangles(gpu, &frame.mesh.triangles, |id| {
            let material = frame.mesh.material_of_triangle[id as usize];
            flags[material as usize].with_material(material)
        })?;
        if flags.iter().any(|flags| flags.is_masked || flags.is_shadow_masked) {
            self.upload_masks(gpu, frame)?;
        }
        (self.mesh, self.materials) = (Some(Arc::clone(&frame.mesh)), Some(Arc::clone(&frame.materials)));
        Ok(())
    }

    fn upload_masks(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        let Materials { materials, textures } = &*frame.materials;
        let mut images: Vec<Vec<u8>> = Vec::new();
        let mut image_of_texture = vec![None; textures.len()];
        let mut image = |texture: u32| {
            *image_of_texture[texture as usize].get_or_insert_with(|| {
                images.push(opacities(&textures[texture as usize]));
                images.len() - 1
            })
        };
        let materials: Vec<_> = materials
            .iter()
            .map(|material| {
                // Images that no mask needs aren't uploaded.
                let flags = flags(material, self.sides);
                let asked = flags.is_masked || flags.is_shadow_masked;
                let texture = material.base_color_texture.filter(|_| asked);
                let texture = texture.map(|used| mask_texture(&used, textures, image(used.texture)));
                MaskMaterial {
                    opacity: material.base_color.w,
                    cutoff: cutoff(material.camera_part()).unwrap_or(0.0),
                    shadow_cutoff: cutoff(material.shadow_part()).unwrap_or(0.0),
                    texture,
                }
            })
            .collect();
        let vertices = (0..self.geometry.vertex_count() as usize).map(|vertex| mask_vertex(&frame.mesh, vertex));
        let has_vertex_opacity = !frame.mesh.colors.is_empty();
        self.geometry.masks_mut().write(gpu, &materials, &images, vertices, has_vertex_opacity)
    }

    pub(super) fn geometry(&self) -> &Geometry {
        &self.geometry
    }
}

fn flags(material: &Material, sides: Sides) -> TriangleFlags {
    TriangleFlags {
        is_masked: cutoff(material.camera_part()).is_some(),
        is_shadow_masked: cutoff(material.shadow_part()).is_some(),
        is_shadowless: material.shadow_part() == OpaquePart::None,
        is_one_sided: !sides.have_back(material),
    }
}

/// The least opacity that stops rays, where opacity decides.
fn cutoff(part: OpaquePart) -> Option<f32> {
    match part {
        OpaquePart::AtLeast(cutoff) => Some(cutoff),
        OpaquePart::All | OpaquePart::None => None,
    }
}

fn mask_texture(used: &TextureUse, textures: &[Texture], image: usize) -> MaskTexture {
    let texture = &textures[used.texture as usize];
    MaskTexture {
        tex_coord_set: u32::from(used.tex_coord_set.min(1)),
        image_from_mesh: used.image_from_mesh.to_cols_array(),
        size: texture.size(),
        wrap: wrap(texture),
        is_linear: texture.filter() == Filter::Linear,
        image,
    }
}

fn opacities(texture: &Texture) -> Vec<u8> {
    texture.levels().next().map_or_else(Vec::new, |texels| texels.iter().map(|texel| texel[3]).collect())
}

fn mask_vertex(mesh: &Mesh, vertex: usize) -> MaskVertex {
    let [first, second] = mesh.tex_coords.each_ref().map(|set| set.get(vertex).copied().unwrap_or_default());
    let opacity = mesh.colors.get(vertex).map_or(1.0, |color| color.w);
    [first.x, first.y, second.x, second.y, opacity]
}
