use fearless_simd::Simd;
use umbrage_scene::{Alpha, Frame, Material, TextureUse};

use super::hits::BlockHits;
use super::lanes::{Each, LANES, each, lanes_of, put, vector_of};
use super::texels::{Tangents, Texels};
use super::triangles::BlockTriangles;

/// Parameters of the materials and textures of a block's lanes, without the vertices' colours.
pub(super) struct Paint {
    pub(super) base_color: [Each<f32>; 3],
    /// For blended materials.
    pub(super) opacity: Each<f32>,
    pub(super) metallic: Each<f32>,
    pub(super) roughness: Each<f32>,
    /// The share of light that the dielectric part reflects straight ahead.
    pub(super) dielectric: Each<f32>,
    /// Of the dielectric part alone.
    pub(super) transmission: Each<f32>,
    pub(super) ambient_occlusion: Each<f32>,
    pub(super) emitted: [Each<f32>; 3],
    pub(super) bumps: Bumps,
    /// The lanes of blended materials, the first in the lowest bit.
    pub(super) blended: u16,
    /// The lanes whose surface bounds a volume.
    pub(super) volume: u16,
    pub(super) unlit: u16,
    /// The lanes that show nothing but shadows.
    pub(super) catches: u16,
    /// The lanes whose material has layers.
    pub(super) layered: u16,
}

/// Values of normal textures.
pub(super) struct Bumps {
    /// The lanes that have one, the first in the lowest bit.
    pub(super) lanes: u16,
    /// Along the tangent, the bitangent and the normal.
    pub(super) bump: [Each<f32>; 3],
    /// Tangents of any length, not yet at right angles to the normal.
    pub(super) tangent: [Each<f32>; 3],
    pub(super) bitangent_sign: Each<f32>,
}

impl Paint {
    pub(super) fn new<S: Simd>(frame: &Frame, hits: &BlockHits<'_, S>, texels: &Texels<'_, S>) -> Self {
        let mut materials = MaterialLanes::new(frame, hits);
        let Some((material, lanes)) = materials.next() else { return Self::plain(&Material::default()) };
        let mut paint = Self::plain(material);
        paint.read_textures(lanes, material, texels);
        for (material, lanes) in materials {
            lanes_of(lanes).for_each(|lane| paint.put(lane, material));
            paint.read_textures(lanes, material, texels);
        }
        paint
    }

    /// A material without textures, in all lanes.
    fn plain(material: &Material) -> Self {
        Self {
            base_color: material.base_color.truncate().to_array().map(each),
            opacity: each(material.base_color.w),
            metallic: each(material.metallic),
            roughness: each(material.roughness),
            dielectric: each(dielectric(material)),
            transmission: each(material.transmission.max(0.0)),
            ambient_occlusion: each(1.0),
            emitted: material.emissive.to_array().map(each),
            bumps: Bumps::none(),
            blended: if material.alpha == Alpha::Blend { u16::MAX } else { 0 },
            volume: if material.bounds_volume() { u16::MAX } else { 0 },
            unlit: if material.unlit { u16::MAX } else { 0 },
            catches: if material.catches_shadows { u16::MAX } else { 0 },
            layered: if material.layers.is_some() { u16::MAX } else { 0 },
        }
    }

    /// A material without textures, in one lane.
    fn put(&mut self, lane: usize, material: &Material) {
        put(lane, material.base_color.truncate(), &mut self.base_color);
        self.opacity[lane] = material.base_color.w;
        self.metallic[lane] = material.metallic;
        self.roughness[lane] = material.roughness;
        self.dielectric[lane] = dielectric(material);
        self.transmission[lane] = material.transmission.max(0.0);
        put(lane, material.emissive, &mut self.emitted);
        let bit = 1 << lane;
        self.blended = self.blended & !bit | if material.alpha == Alpha::Blend { bit } else { 0 };
        self.volume = self.volume & !bit | if material.bounds_volume() { bit } else { 0 };
        self.unlit = self.unlit & !bit | if material.unlit { bit } else { 0 };
        self.catches = self.catches & !bit | if material.catches_shadows { bit } else { 0 };
        self.layered = self.layered & !bit | if material.layers.is_some() { bit } else { 0 };
    }

    /// Multiplies the material of some lanes by its textures.
    fn read_textures<S: Simd>(&mut self, lanes: u16, material: &Material, texels: &Texels<'_, S>) {
        if let Some(texture) = material.base_color_texture {
            let [red, green, blue, opacity] = &texels.read(texture, lanes);
            for (channel, texel) in self.base_color.iter_mut().zip([red, green, blue]) {
                multiply(channel, texel, lanes);
            }
            multiply(&mut self.opacity, opacity, lanes);
        }
        if let Some(texture) = material.metallic_roughness_texture {
            let [_, roughness, metallic, _] = &texels.read(texture, lanes);
            multiply(&mut self.metallic, metallic, lanes);
            multiply(&mut self.roughness, roughness, lanes);
        }
        if let Some(texture) = material.transmission_texture {
            multiply(&mut self.transmission, &texels.read(texture, lanes)[0], lanes);
        }
        if let Some(texture) = material.occlusion_texture {
            let part = texels.read(texture, lanes)[0].map(|texel| 1.0 + material.occlusion_strength * (texel - 1.0));
            multiply(&mut self.ambient_occlusion, &part, lanes);
        }
        if let Some(texture) = material.emissive_texture {
            for (channel, texel) in self.emitted.iter_mut().zip(&texels.read(texture, lanes)) {
                multiply(channel, texel, lanes);
            }
        }
        if let Some(texture) = material.normal_texture {
            self.bumps.read(lanes, texels, texture, material.normal_scale);
        }
    }
}

/// Reflectance between air and the material straight ahead.
fn dielectric(material: &Material) -> f32 {
    let ratio = (material.ior - 1.0) / (material.ior + 1.0);
    ratio * ratio
}

fn multiply(to: &mut Each<f32>, by: &Each<f32>, lanes: u16) {
    for (lane, (to, by)) in to.iter_mut().zip(by).enumerate() {
        *to *= if lanes >> lane & 1 == 1 { *by } else { 1.0 };
    }
}

/// The materials of a block's lanes with a hit, each with its lanes.
pub(super) struct MaterialLanes<'a> {
    frame: &'a Frame,
    triangles: &'a BlockTriangles,
    left: u16,
}

impl<'a> MaterialLanes<'a> {
    pub(super) fn new<S: Simd>(frame: &'a Frame, hits: &'a BlockHits<'a, S>) -> Self {
        Self { frame, triangles: hits.triangles, left: hits.shown }
    }
}

impl<'a> Iterator for MaterialLanes<'a> {
    type Item = (&'a Material, u16);

    fn next(&mut self) -> Option<Self::Item> {
        let of_triangles = &self.frame.mesh.material_of_triangle;
        let left = self.triangles.with_lanes().filter(|(_, lanes)| lanes & self.left != 0);
        let mut left = left.map(|(id, lanes)| (of_triangles[id as usize], lanes));
        let (material, mut lanes) = left.next()?;
        left.filter(|(other, _)| *other == material).for_each(|(_, others)| lanes |= others);
        lanes &= self.left;
        self.left &= !lanes;
        Some((&self.frame.materials.materials[material as usize], lanes))
    }
}

impl Bumps {
    pub(super) fn none() -> Self {
        Self { lanes: 0, bump: [[0.0; LANES]; 3], tangent: [[0.0; LANES]; 3], bitangent_sign: [0.0; LANES] }
    }

    /// Reads a normal texture in some lanes.
    pub(super) fn read<S: Simd>(&mut self, lanes: u16, texels: &Texels<'_, S>, texture: TextureUse, scale: f32) {
        let [mut x, mut y, mut z, _] = texels.read(texture, lanes);
        for (channel, scale) in [(&mut x, scale), (&mut y, scale), (&mut z, 1.0)] {
            channel.iter_mut().for_each(|texel| *texel = (*texel * 2.0 - 1.0) * scale);
        }
        self.set(lanes, texels, texture.tex_coord_set, &[x, y, z]);
    }

    /// Takes bumps in the tangent frame of the file, or else in that of a set of texture coordinates; none where there is
    /// neither.
    pub(super) fn set<S: Simd>(
        &mut self,
        lanes: u16,
        texels: &Texels<'_, S>,
        tex_coord_set: u8,
        bump: &[Each<f32>; 3],
    ) {
        let Tangents { lanes: with_tangent, tangent, bitangent_sign } = &texels.tangents(tex_coord_set);
        let lanes = lanes & with_tangent;
        self.lanes |= lanes;
        for lane in lanes_of(lanes) {
            put(lane, vector_of(lane, bump), &mut self.bump);
            put(lane, vector_of(lane, tangent), &mut self.tangent);
            self.bitangent_sign[lane] = bitangent_sign[lane];
        }
    }
}
