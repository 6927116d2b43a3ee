//! Converts and uploads a frame's data for shading on the GPU.

use std::sync::Arc;

use glam::Vec3;
use umbrage_gpu::shade::{
    Attributes, Moving, Shade, ShadeLayers, ShadeLight, ShadeMaterial, ShadeSample, ShadeSurroundings, ShadeTexture,
    Texels,
};
use umbrage_gpu::{Band, Gpu, GpuError};
use umbrage_scene::rig::Rig;
use umbrage_scene::{
    Alpha, ColorSpace, Filter, Frame, Layers, Light, Material, Materials, Mesh, Specular, Texture, TextureUse, Volume,
    Wrap,
};

use crate::background::Surroundings;
use crate::engine::Staged;
use crate::sampling::Sample;
use crate::shade::{Footprint, sheen_albedo_table, specular_albedo_table};
use crate::{Background, Panorama};

/// The parts of a frame that are on the GPU; only new parts are uploaded.
#[derive(Debug, Default)]
pub(super) struct Tables {
    mesh: Option<Arc<Mesh>>,
    materials: Option<Arc<Materials>>,
    panorama: Option<Arc<Panorama>>,
    /// The word where the panorama's list of levels begins.
    panorama_word: u32,
    lights: Vec<Light>,
    sky_lights: usize,
}

impl Tables {
    /// Uploads a frame's data for shading, except for positions and indices. For a rig, which the GPU poses, it only makes
    /// room for the normals and tangents.
    ///
    /// # Errors
    /// Where a part is larger than the device allows.
    pub(super) fn upload(
        &mut self,
        gpu: &Gpu,
        staged: &Staged<'_>,
        rig: Option<&Rig>,
        shade: &mut Shade,
    ) -> Result<(), GpuError> {
        let Staged { frame, surroundings, .. } = *staged;
        self.upload_images(gpu, &frame.materials, surroundings.background(), shade)?;
        shade.set_surroundings(self.surroundings(surroundings));
        let is_same_mesh = self.mesh.as_ref().is_some_and(|mesh| Arc::ptr_eq(mesh, &frame.mesh));
        // The mesh is held, so that no other one takes its address; set only once it is uploaded.
        self.mesh = None;
        shade.set_attributes(gpu, &attributes(frame, rig), is_same_mesh)?;
        self.mesh = Some(Arc::clone(&frame.mesh));
        self.lights.clear();
        self.upload_lights(gpu, staged, shade)
    }

    /// Uploads lights unless they are the same as before.
    ///
    /// # Errors
    /// Where they are more than the device allows.
    pub(super) fn upload_lights(&mut self, gpu: &Gpu, staged: &Staged<'_>, shade: &mut Shade) -> Result<(), GpuError> {
        let Staged { lights, sky_lights, .. } = *staged;
        if self.lights == lights && self.sky_lights == sky_lights && !lights.is_empty() {
            return Ok(());
        }
        self.lights.clear();
        shade.set_lights(gpu, &lights.iter().map(light).collect::<Vec<_>>(), sky_lights)?;
        self.sky_lights = sky_lights;
        self.lights.extend_from_slice(lights);
        Ok(())
    }

    /// Uploads materials with their textures, and the panorama, where any is new.
    fn upload_images(
        &mut self,
        gpu: &Gpu,
        materials: &Arc<Materials>,
        background: &Background,
        shade: &mut Shade,
    ) -> Result<(), GpuError> {
        let panorama = match background {
            Background::Image(panorama) => Some(panorama),
            Background::Color(_) | Background::Sky | Background::Transparent => None,
        };
        let has_materials = self.materials.as_ref().is_some_and(|old| Arc::ptr_eq(old, materials));
        let has_panorama = panorama.is_none_or(|new| self.panorama.as_ref().is_some_and(|old| Arc::ptr_eq(old, new)));
        if has_materials && has_panorama {
            return Ok(());
        }
        let has_sheen = |of: &Material| layer_bits(of) & ShadeLayers::SHEEN != 0;
        let sheen = materials.materials.iter().any(has_sheen).then(sheen_albedo_table);
        let mut texels = Texels::new(ColorSpace::linear_from_srgb(), specular_albedo_table(), sheen.as_ref());
        let words: Vec<u32> = materials.textures.iter().map(|texture| add_texture(&mut texels, texture)).collect();
        self.panorama_word = panorama.map_or(0, |panorama| add_panorama(&mut texels, panorama));
        let rows: Vec<_> = materials.materials.iter().map(|of| material(of, &materials.textures, &words)).collect();
        (self.materials, self.panorama) = (None, None);
        shade.set_materials(gpu, &rows, &texels)?;
        (self.materials, self.panorama) = (Some(Arc::clone(materials)), panorama.cloned());
        Ok(())
    }

    fn surroundings(&self, surroundings: &Surroundings<'_>) -> ShadeSurroundings {
        let irradiance = surroundings.irradiance_coefficients().map(|of| of.extend(0.0).to_array());
        let all = ShadeSurroundings { irradiance, ..ShadeSurroundings::default() };
        match surroundings.background() {
            Background::Color(color) => {
                ShadeSurroundings { kind: ShadeSurroundings::COLOR, color: color.to_array(), ..all }
            }
            Background::Sky => ShadeSurroundings { kind: ShadeSurroundings::SKY, ..all },
            Background::Transparent => ShadeSurroundings { kind: ShadeSurroundings::TRANSPARENT, ..all },
            Background::Image(panorama) => ShadeSurroundings {
                kind: ShadeSurroundings::IMAGE,
                panorama_size: panorama.size().map(|side| side as u32),
                panorama_levels: panorama.levels().len() as u32,
                panorama_word: self.panorama_word,
                ..all
            },
        }
    }
}

/// The rays of a sample, with the cones of their pixels.
pub(super) fn sample_rays(band: &Band, sample: &Sample) -> ShadeSample {
    let Footprint { width, width_per_depth } = Footprint::new(&band.view, sample.of);
    ShadeSample {
        footprint: width,
        footprint_per_depth: width_per_depth,
        ..ShadeSample::new(band.clone(), sample.offset_pixels)
    }
}

fn attributes<'a>(frame: &'a Frame, rig: Option<&Rig>) -> Attributes<'a> {
    let [first_set, second_set] = &frame.mesh.tex_coords;
    let (normals, tangents) = match rig {
        None => (Moving::Uploaded(frame.normals.as_slice()), Moving::Uploaded(frame.tangents.as_slice())),
        Some(rig) => {
            let posed = |has: bool| if has { rig.vertices } else { 0 };
            (Moving::Posed(posed(rig.has_normals)), Moving::Posed(posed(rig.has_tangents)))
        }
    };
    Attributes {
        material_of_triangle: &frame.mesh.material_of_triangle,
        tex_coords: [first_set, second_set],
        colors: &frame.mesh.colors,
        normals,
        tangents,
    }
}

fn light(light: &Light) -> ShadeLight {
    ShadeLight::new(&light.source, light.shape.is_flat(), light.color * light.intensity, light.range)
}

fn material(material: &Material, textures: &[Texture], words: &[u32]) -> ShadeMaterial {
    let mut uses = [ShadeTexture::default(); 16];
    let of_layers = material.layers.as_ref().map_or([None; 10], |layers| layers.textures());
    let of_layers = (ShadeMaterial::SPECULAR..).zip(of_layers);
    let of_base = [
        (ShadeMaterial::BASE_COLOR, material.base_color_texture),
        (ShadeMaterial::METALLIC_ROUGHNESS, material.metallic_roughness_texture),
        (ShadeMaterial::NORMAL, material.normal_texture),
        (ShadeMaterial::OCCLUSION, material.occlusion_texture),
        (ShadeMaterial::EMISSIVE, material.emissive_texture),
        (ShadeMaterial::TRANSMISSION, material.transmission_texture),
    ];
    for (index, used) in of_base.into_iter().chain(of_layers) {
        uses[index] = used.map_or_else(ShadeTexture::default, |used| texture(&used, textures, words));
    }
    ShadeMaterial {
        base_color: material.base_color.to_array(),
        emissive: material.emissive.to_array(),
        metallic: material.metallic,
        roughness: material.roughness,
        ior: material.ior,
        transmission: material.transmission.max(0.0),
        normal_scale: material.normal_scale,
        occlusion_strength: material.occlusion_strength,
        is_blended: u32::from(material.alpha == Alpha::Blend),
        is_unlit: u32::from(material.unlit),
        catches_shadows: u32::from(material.catches_shadows),
        bounds_volume: u32::from(material.bounds_volume()),
        dispersion: material.dispersion,
        attenuation_distance: attenuation_distance(&material.volume),
        mask_cutoff: if let Alpha::Mask { cutoff } = material.alpha { cutoff } else { 0.0 },
        attenuation_color: material.volume.attenuation_color.to_array(),
        layer_bits: layer_bits(material),
        layers: material.layers.as_ref().map_or_else(ShadeLayers::default, |layers| shade_layers(layers)),
        textures: uses,
    }
}

/// The distance after which light has the colour of a volume; 0 where it never has.
fn attenuation_distance(volume: &Volume) -> f32 {
    let Volume { attenuation_distance, attenuation_color, .. } = *volume;
    let is_clear = attenuation_color == Vec3::ONE || !attenuation_distance.is_finite();
    if is_clear { 0.0 } else { attenuation_distance.max(f32::MIN_POSITIVE) }
}

fn layer_bits(material: &Material) -> u32 {
    let Some(layers) = &material.layers else { return 0 };
    let Layers { specular, clearcoat, sheen, anisotropy, iridescence } = &**layers;
    let has = |bit: u32, is_there: bool| if is_there { bit } else { 0 };
    has(ShadeLayers::SPECULAR, *specular != Specular::default())
        | has(ShadeLayers::COAT, clearcoat.factor > 0.0)
        | has(ShadeLayers::SHEEN, sheen.color != Vec3::ZERO)
        | has(ShadeLayers::GROOVES, anisotropy.strength > 0.0)
        | has(ShadeLayers::FILM, iridescence.factor > 0.0)
}

fn shade_layers(layers: &Layers) -> ShadeLayers {
    let Layers { specular, clearcoat, sheen, anisotropy, iridescence } = layers;
    let (sine, cosine) = libm::sincosf(anisotropy.rotation_radians);
    ShadeLayers {
        specular_color: specular.color.to_array(),
        specular: specular.factor,
        sheen_color: sheen.color.to_array(),
        sheen_roughness: sheen.roughness,
        coat: clearcoat.factor,
        coat_roughness: clearcoat.roughness,
        coat_normal_scale: clearcoat.normal_scale,
        stretch: anisotropy.strength,
        stretch_turn: [cosine, sine],
        film: iridescence.factor,
        film_ior: iridescence.ior.clamp(1.0, 1e3),
        film_nanometers: [iridescence.thickness_minimum_nanometers, iridescence.thickness_maximum_nanometers],
        ..ShadeLayers::default()
    }
}

fn texture(used: &TextureUse, textures: &[Texture], words: &[u32]) -> ShadeTexture {
    let texture = &textures[used.texture as usize];
    ShadeTexture {
        matrix: used.image_from_mesh.matrix2.to_cols_array(),
        translation: used.image_from_mesh.translation.to_array(),
        size: texture.size(),
        wrap: wrap(texture),
        levels: texture.levels().len() as u32,
        levels_word: words[used.texture as usize],
        tex_coord_set: u32::from(used.tex_coord_set.min(1)),
        is_nearest: u32::from(texture.filter() == Filter::Nearest),
        is_srgb: u32::from(texture.space() == ColorSpace::Srgb),
        ..ShadeTexture::default()
    }
}

/// The wrap mode of a texture on each axis, for shading and for masks.
pub(super) fn wrap(texture: &Texture) -> [u32; 2] {
    texture.wrap().map(|wrap| match wrap {
        Wrap::Repeat => ShadeTexture::REPEAT,
        Wrap::MirroredRepeat => ShadeTexture::MIRRORED_REPEAT,
        Wrap::ClampToEdge => ShadeTexture::CLAMP_TO_EDGE,
    })
}

fn add_texture(texels: &mut Texels, texture: &Texture) -> u32 {
    texels.add(texture.levels().map(|level| level.into_owned().into_iter().map(u32::from_le_bytes)))
}

fn add_panorama(texels: &mut Texels, panorama: &Panorama) -> u32 {
    texels.add(panorama.levels().map(|level| level.iter().flat_map(|texel| texel.to_array().map(f32::to_bits))))
}
