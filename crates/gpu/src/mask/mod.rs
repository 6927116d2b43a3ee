//! Opacity masks of triangles: the tables that stages test points against.

use crate::{Buffer, Gpu, GpuError};

/// Flags of a triangle's sides and mask, which share a word with the triangle's material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TriangleFlags {
    /// A camera's ray may pass through it.
    pub is_masked: bool,
    /// Light may pass through it.
    pub is_shadow_masked: bool,
    /// Light always passes through it.
    pub is_shadowless: bool,
    /// Rays of either kind pass through its back.
    pub is_one_sided: bool,
}

impl TriangleFlags {
    /// The number of a triangle with these flags and the material at an index below 2²⁴.
    #[must_use]
    pub fn with_material(self, material: u32) -> u32 {
        let bit = |flag: bool, bit: u32| u32::from(flag) << bit;
        let of_masks = bit(self.is_masked, 31) | bit(self.is_shadow_masked, 30) | bit(self.is_shadowless, 29);
        material & 0x00ff_ffff | of_masks | bit(self.is_one_sided, 28)
    }
}

/// Opacity of a material.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaskMaterial {
    /// The material's own opacity, multiplied by those of vertices and of the texture.
    pub opacity: f32,
    /// A point is there for camera rays if the opacity is at least this.
    pub cutoff: f32,
    /// A point casts a shadow if the opacity is at least this.
    pub shadow_cutoff: f32,
    /// The texture, if there is one.
    pub texture: Option<MaskTexture>,
}

/// A texture from which a material reads opacities.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaskTexture {
    /// The set of texture coordinates: 0 or 1.
    pub tex_coord_set: u32,
    /// Matrix from the mesh's texture coordinates to the image's: two columns, then the translation.
    pub image_from_mesh: [f32; 6],
    /// Width and height of the image.
    pub size: [u32; 2],
    /// Wrapping beyond the edges on each axis, as in [`ShadeTexture::wrap`](crate::shade::ShadeTexture::wrap).
    pub wrap: [u32; 2],
    /// Whether four texels are mixed; else the nearest is read.
    pub is_linear: bool,
    /// The image's index in the list of images.
    pub image: usize,
}

/// A vertex of a scene with masks: both sets of texture coordinates, and its opacity.
pub type MaskVertex = [f32; 5];

/// Tables of materials, vertices and opacities, as `table.wgsl` reads them.
#[derive(Debug)]
pub struct Masks {
    words: Buffer,
}

impl Masks {
    /// Tables of a scene without masks.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self { words: Buffer::storage(gpu, "masks") }
    }

    /// Uploads a scene's materials, images (a byte of opacity for each texel, in rows) and vertices.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn write(
        &mut self,
        gpu: &Gpu,
        materials: &[MaskMaterial],
        images: &[Vec<u8>],
        vertices: impl IntoIterator<Item = MaskVertex>,
        has_vertex_opacity: bool,
    ) -> Result<(), GpuError> {
        const HEADER: usize = 4;
        let mut starts = Vec::with_capacity(images.len());
        let mut bytes: Vec<u8> = Vec::new();
        for image in images {
            starts.push(bytes.len() as u32);
            bytes.extend(image);
        }
        let mut words = vec![0; HEADER];
        for material in materials {
            words.extend(material.words(&starts));
        }
        words[0] = words.len() as u32;
        words.extend(vertices.into_iter().flatten().map(f32::to_bits));
        words[1] = words.len() as u32;
        words[2] = HEADER as u32;
        words[3] = u32::from(has_vertex_opacity);
        words.extend(bytes.chunks(4).map(|chunk| {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            u32::from_le_bytes(word)
        }));
        self.words.write(gpu, &words)
    }

    pub(crate) fn buffer(&self) -> &Buffer {
        &self.words
    }
}

impl MaskMaterial {
    fn words(&self, image_starts: &[u32]) -> [u32; 20] {
        let mut words = [0; 20];
        words[..3].copy_from_slice(&[self.opacity, self.cutoff, self.shadow_cutoff].map(f32::to_bits));
        if let Some(texture) = &self.texture {
            words[3] = 1;
            words[4] = texture.tex_coord_set;
            words[8..14].copy_from_slice(&texture.image_from_mesh.map(f32::to_bits));
            words[14..16].copy_from_slice(&texture.size);
            words[16..18].copy_from_slice(&texture.wrap);
            words[18] = u32::from(texture.is_linear);
            words[19] = image_starts[texture.image];
        }
        words
    }
}
