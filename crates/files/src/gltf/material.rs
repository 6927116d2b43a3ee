//! Materials.

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::extensions::material::PbrSpecularGlossiness;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;
use serde_json::{Map, Value};
use umbrage_scene::{Alpha, ColorSpace, Error, Material, Materials, TextureUse, Volume, check_material};

use super::document::Document;
use super::layers;
use super::texture::Textures;

/// Reads all materials in the file's order, and after them glTF's default material if `with_default`.
///
/// Textures that can't be used are left out with a warning.
///
/// # Errors
/// Where an index is out of range, or a number isn't finite.
pub(super) fn read(document: &Document, with_default: bool, warnings: &mut Vec<String>) -> Result<Materials, Error> {
    let mut reader = Reader { document, textures: Textures::default(), warnings, glossy: 0 };
    let mut materials = Vec::new();
    for (number, json) in document.json.materials.iter().enumerate() {
        materials.push(reader.material(json, &format!("materials[{number}]"))?);
    }
    if with_default {
        materials.push(reader.material(&json::Material::default(), "the default material")?);
    }
    let Reader { textures, warnings, glossy, .. } = reader;
    if glossy > 0 {
        warnings.push(format!(
            "{glossy} materials of KHR_materials_pbrSpecularGlossiness are approximated by their diffuse colour"
        ));
    }
    let mut decoded = Vec::new();
    let mut new_from_old = Vec::new();
    for texture in textures.decode(document) {
        new_from_old.push(texture.is_ok().then_some(decoded.len() as u32));
        match texture {
            Ok(texture) => decoded.push(texture),
            Err(cause) => warnings.push(format!("a texture was left out: {cause}")),
        }
    }
    for texture in materials.iter_mut().flat_map(texture_uses) {
        let new = texture.and_then(|texture| new_from_old[texture.texture as usize]);
        *texture = texture.zip(new).map(|(texture, new)| TextureUse { texture: new, ..texture });
    }
    Ok(Materials { materials, textures: decoded })
}

pub(super) struct Reader<'a> {
    pub(super) document: &'a Document,
    textures: Textures,
    warnings: &'a mut Vec<String>,
    /// Number of materials approximated from the specular-glossiness model.
    glossy: usize,
}

/// A texture reference, which the JSON has in three types.
pub(super) struct JsonTexture {
    index: usize,
    set: u32,
    transform: Option<TextureTransform>,
}

impl JsonTexture {
    pub(super) fn of_info(json: &json::texture::Info) -> Self {
        let transform = json.extensions.as_ref().and_then(|extensions| extensions.texture_transform.clone());
        Self { index: json.index.value(), set: json.tex_coord, transform }
    }

    pub(super) fn of_normals(json: &json::material::NormalTexture) -> Self {
        let transform = json.extensions.as_ref().and_then(|extensions| transform(&extensions.others));
        Self { index: json.index.value(), set: json.tex_coord, transform }
    }

    /// The set of texture coordinates at which the texture is read.
    pub(super) fn tex_coord_set(&self) -> u32 {
        self.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(self.set)
    }
}

/// The set of texture coordinates along which a material needs tangents: the set of its normal map, else of its layers;
/// `None` where it needs none.
pub(super) fn tangent_coords(json: &json::Material) -> Option<u32> {
    let of_base = json.normal_texture.as_ref().map(|texture| JsonTexture::of_normals(texture).tex_coord_set());
    of_base.or_else(|| layers::tangent_coords(&json.extensions.as_ref()?.others))
}

impl Reader<'_> {
    fn material(&mut self, json: &json::Material, location: &str) -> Result<Material, Error> {
        use ColorSpace::{Linear, Srgb};
        let pbr = &json.pbr_metallic_roughness;
        let pbr_location = format!("{location}.pbrMetallicRoughness");
        let mut material = Material {
            name: json.name.clone().unwrap_or_default(),
            base_color: Vec4::from_array(pbr.base_color_factor.0),
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            emissive: Vec3::from_array(json.emissive_factor.0),
            alpha: match json.alpha_mode {
                Checked::Valid(AlphaMode::Mask) => {
                    Alpha::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0) }
                }
                Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
                Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => Alpha::Opaque,
            },
            double_sided: json.double_sided,
            ..Material::default()
        };
        material.base_color_texture =
            self.plain(pbr.base_color_texture.as_ref(), Srgb, &format!("{pbr_location}.baseColorTexture"))?;
        material.metallic_roughness_texture = self.plain(
            pbr.metallic_roughness_texture.as_ref(),
            Linear,
            &format!("{pbr_location}.metallicRoughnessTexture"),
        )?;
        material.emissive_texture =
            self.plain(json.emissive_texture.as_ref(), Srgb, &format!("{location}.emissiveTexture"))?;
        if let Some(texture) = &json.normal_texture {
            let location = format!("{location}.normalTexture");
            material.normal_texture = self.texture(&JsonTexture::of_normals(texture), Linear, &location)?;
            material.normal_scale = texture.scale;
        }
        if let Some(texture) = &json.occlusion_texture {
            let transform = texture.extensions.as_ref().and_then(|extensions| transform(&extensions.others));
            let json = JsonTexture { index: texture.index.value(), set: texture.tex_coord, transform };
            material.occlusion_texture = self.texture(&json, Linear, &format!("{location}.occlusionTexture"))?;
            material.occlusion_strength = texture.strength.0;
        }
        if let Some(extensions) = &json.extensions {
            self.extensions(extensions, &mut material, &format!("{location}.extensions"))?;
        }
        self.bring_to_range(&mut material, location);
        check_material(&material).map_err(|cause| self.document.malformed(location, cause))?;
        Ok(material)
    }

    /// Clamps numbers to the format's range, with a warning for each.
    fn bring_to_range(&mut self, material: &mut Material, location: &str) {
        let Material {
            base_color,
            emissive,
            metallic,
            roughness,
            occlusion_strength,
            alpha,
            transmission,
            ior,
            dispersion,
            volume,
            ..
        } = material;
        // 0 has a meaning of its own.
        let least_ior = if *ior == 0.0 { 0.0 } else { 1.0 };
        let mut none = 0.0;
        let cutoff = if let Alpha::Mask { cutoff } = alpha { cutoff } else { &mut none };
        let colors = [
            ("the base colour", &mut base_color.as_mut()[..], 1.0),
            ("the emissive colour", emissive.as_mut(), f32::MAX),
        ];
        let numbers = [
            ("the metalness", metallic, 0.0, 1.0),
            ("the roughness", roughness, 0.0, 1.0),
            ("the occlusion's strength", occlusion_strength, 0.0, 1.0),
            ("the alpha cutoff", cutoff, 0.0, f32::MAX),
            ("the transmission", transmission, 0.0, 1.0),
            ("the index of refraction", ior, least_ior, f32::MAX),
            ("the dispersion", dispersion, 0.0, f32::MAX),
            ("the thickness", &mut volume.thickness, 0.0, f32::MAX),
        ];
        let parts = colors
            .into_iter()
            .flat_map(|(name, color, most)| color.iter_mut().map(move |part| (name, part, 0.0, most)));
        for (name, number, least, most) in numbers.into_iter().chain(parts) {
            let asked = *number;
            if asked.is_finite() && !(least..=most).contains(&asked) {
                *number = asked.clamp(least, most);
                self.warnings.push(format!("{location}: {name} of {asked} is out of range and was taken as {number}"));
            }
        }
    }

    fn extensions(
        &mut self,
        json: &json::extensions::material::Material,
        material: &mut Material,
        location: &str,
    ) -> Result<(), Error> {
        material.unlit = json.unlit.is_some();
        if let Some(strength) = &json.emissive_strength {
            // A product that overflows becomes the largest number.
            material.emissive = (material.emissive * strength.emissive_strength.0).min(Vec3::MAX);
        }
        if let Some(ior) = &json.ior {
            material.ior = ior.ior.0;
        }
        if let Some(transmission) = &json.transmission {
            let location = format!("{location}.KHR_materials_transmission.transmissionTexture");
            material.transmission = transmission.transmission_factor.0;
            material.transmission_texture =
                self.plain(transmission.transmission_texture.as_ref(), ColorSpace::Linear, &location)?;
        }
        if let Some(volume) = &json.volume {
            let location = format!("{location}.KHR_materials_volume.thicknessTexture");
            material.volume = Volume {
                thickness: volume.thickness_factor.0,
                thickness_texture: self.plain(volume.thickness_texture.as_ref(), ColorSpace::Linear, &location)?,
                // Zero is outside the extension's range, and would take all light away.
                attenuation_distance: Some(volume.attenuation_distance.0)
                    .filter(|&distance| distance > 0.0)
                    .unwrap_or(f32::INFINITY),
                attenuation_color: Vec3::from_array(volume.attenuation_color.0),
            };
        }
        if let Some(dispersion) = json.others.get("KHR_materials_dispersion").and_then(|json| json.get("dispersion")) {
            material.dispersion = dispersion.as_f64().unwrap_or(f64::NAN) as f32;
        }
        material.layers = self.layers(&json.others, location)?;
        if let Some(glossy) = &json.pbr_specular_glossiness {
            self.specular_glossiness(glossy, material, &format!("{location}.KHR_materials_pbrSpecularGlossiness"))?;
        }
        Ok(())
    }

    fn specular_glossiness(
        &mut self,
        json: &PbrSpecularGlossiness,
        material: &mut Material,
        location: &str,
    ) -> Result<(), Error> {
        self.glossy += 1;
        material.base_color = Vec4::from_array(json.diffuse_factor.0);
        material.base_color_texture =
            self.plain(json.diffuse_texture.as_ref(), ColorSpace::Srgb, &format!("{location}.diffuseTexture"))?;
        material.metallic = 0.0;
        material.roughness = 1.0 - json.glossiness_factor.0;
        material.metallic_roughness_texture = None;
        Ok(())
    }

    pub(super) fn plain(
        &mut self,
        json: Option<&json::texture::Info>,
        space: ColorSpace,
        location: &str,
    ) -> Result<Option<TextureUse>, Error> {
        json.map_or(Ok(None), |json| self.texture(&JsonTexture::of_info(json), space, location))
    }

    pub(super) fn texture(
        &mut self,
        json: &JsonTexture,
        space: ColorSpace,
        location: &str,
    ) -> Result<Option<TextureUse>, Error> {
        let number = self.textures.number(self.document, json.index, space, location, self.warnings)?;
        let set = json.tex_coord_set();
        if set > 1 {
            self.warnings
                .push(format!("{location} was left out, as only texture coordinates 0 and 1 are read, not {set}"));
            return Ok(None);
        }
        let image_from_mesh = json.transform.as_ref().map_or(Affine2::IDENTITY, image_from_mesh);
        Ok(number.map(|texture| TextureUse { texture, tex_coord_set: set as u8, image_from_mesh }))
    }
}

/// Rotation from x towards y.
pub(super) fn turn(radians: f32) -> Mat2 {
    let (sine, cosine) = libm::sincosf(radians);
    Mat2::from_cols(Vec2::new(cosine, sine), Vec2::new(-sine, cosine))
}

/// Scale, then rotation, then offset. With v downwards, the extension's counter-clockwise turn has a negative angle.
fn image_from_mesh(json: &TextureTransform) -> Affine2 {
    let linear = turn(-json.rotation.0) * Mat2::from_diagonal(Vec2::from_array(json.scale.0));
    Affine2::from_mat2_translation(linear, Vec2::from_array(json.offset.0))
}

/// Reads the texture transform from the extensions of a texture type for which the parsing library has no such field.
fn transform(extensions: &Map<String, Value>) -> Option<TextureTransform> {
    serde_json::from_value(extensions.get("KHR_texture_transform")?.clone()).ok()
}

fn texture_uses(material: &mut Material) -> impl Iterator<Item = &mut Option<TextureUse>> {
    let of_layers = material.layers.iter_mut().flat_map(|layers| layers.textures_mut());
    let others = [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.normal_texture,
        &mut material.occlusion_texture,
        &mut material.emissive_texture,
        &mut material.transmission_texture,
        &mut material.volume.thickness_texture,
    ];
    others.into_iter().chain(of_layers)
}
