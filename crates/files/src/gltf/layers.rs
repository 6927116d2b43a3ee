//! The extensions that describe a material's layers.

use glam::Vec3;
use gltf::json::material::NormalTexture;
use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use umbrage_scene::{Anisotropy, Clearcoat, ColorSpace, Error, Iridescence, Layers, Sheen, Specular, TextureUse};

use super::material::{JsonTexture, Reader};

const SPECULAR: &str = "KHR_materials_specular";
const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";
const IRIDESCENCE: &str = "KHR_materials_iridescence";

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct JsonSpecular {
    specular_factor: f32,
    specular_texture: Option<Info>,
    specular_color_factor: [f32; 3],
    specular_color_texture: Option<Info>,
}

impl Default for JsonSpecular {
    fn default() -> Self {
        let Specular { factor, color, .. } = Specular::default();
        Self {
            specular_factor: factor,
            specular_texture: None,
            specular_color_factor: color.to_array(),
            specular_color_texture: None,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct JsonClearcoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Info>,
    clearcoat_normal_texture: Option<NormalTexture>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct JsonSheen {
    sheen_color_factor: [f32; 3],
    sheen_color_texture: Option<Info>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<Info>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct JsonAnisotropy {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct JsonIridescence {
    iridescence_factor: f32,
    iridescence_texture: Option<Info>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    iridescence_thickness_texture: Option<Info>,
}

impl Default for JsonIridescence {
    fn default() -> Self {
        let Iridescence { factor, ior, thickness_minimum_nanometers, thickness_maximum_nanometers, .. } =
            Iridescence::default();
        Self {
            iridescence_factor: factor,
            iridescence_texture: None,
            iridescence_ior: ior,
            iridescence_thickness_minimum: thickness_minimum_nanometers,
            iridescence_thickness_maximum: thickness_maximum_nanometers,
            iridescence_thickness_texture: None,
        }
    }
}

/// The set of texture coordinates along which a material's layers need tangents; `None` where they need none.
pub(super) fn tangent_coords(extensions: &Map<String, Value>) -> Option<u32> {
    let of_coat = || {
        let texture = serde_json::from_value(extensions.get(CLEARCOAT)?.get("clearcoatNormalTexture")?.clone()).ok()?;
        Some(JsonTexture::of_normals(&texture).tex_coord_set())
    };
    let of_grooves = || {
        let json: JsonAnisotropy = serde_json::from_value(extensions.get(ANISOTROPY)?.clone()).ok()?;
        let set = json.anisotropy_texture.map_or(0, |texture| JsonTexture::of_info(&texture).tex_coord_set());
        (json.anisotropy_strength != 0.0).then_some(set)
    };
    of_coat().or_else(of_grooves)
}

impl Reader<'_> {
    /// Reads a material's layers from its `extensions`; `None` where they change nothing.
    ///
    /// # Errors
    /// Where a value has the wrong type, or an index is out of range.
    pub(super) fn layers(
        &mut self,
        extensions: &Map<String, Value>,
        location: &str,
    ) -> Result<Option<Box<Layers>>, Error> {
        let mut layers = Layers::default();
        if let Some(json) = self.extension(extensions, SPECULAR, location)? {
            layers.specular = self.specular(&json, &format!("{location}.{SPECULAR}"))?;
        }
        if let Some(json) = self.extension(extensions, CLEARCOAT, location)? {
            layers.clearcoat = self.clearcoat(&json, &format!("{location}.{CLEARCOAT}"))?;
        }
        if let Some(json) = self.extension(extensions, SHEEN, location)? {
            layers.sheen = self.sheen(&json, &format!("{location}.{SHEEN}"))?;
        }
        if let Some(json) = self.extension(extensions, ANISOTROPY, location)? {
            layers.anisotropy = self.anisotropy(&json, &format!("{location}.{ANISOTROPY}"))?;
        }
        if let Some(json) = self.extension(extensions, IRIDESCENCE, location)? {
            layers.iridescence = self.iridescence(&json, &format!("{location}.{IRIDESCENCE}"))?;
        }
        Ok((!layers.are_off()).then(|| Box::new(layers)))
    }

    fn extension<T: DeserializeOwned>(
        &self,
        extensions: &Map<String, Value>,
        name: &str,
        location: &str,
    ) -> Result<Option<T>, Error> {
        let Some(json) = extensions.get(name) else { return Ok(None) };
        let broken =
            |cause: serde_json::Error| self.document.malformed(format!("{location}.{name}"), cause.to_string());
        T::deserialize(json).map(Some).map_err(broken)
    }

    fn specular(&mut self, json: &JsonSpecular, location: &str) -> Result<Specular, Error> {
        let color_location = format!("{location}.specularColorTexture");
        Ok(Specular {
            factor: json.specular_factor,
            texture: self.quantity(json.specular_texture.as_ref(), location, "specularTexture")?,
            color: Vec3::from_array(json.specular_color_factor),
            color_texture: self.plain(json.specular_color_texture.as_ref(), ColorSpace::Srgb, &color_location)?,
        })
    }

    fn clearcoat(&mut self, json: &JsonClearcoat, location: &str) -> Result<Clearcoat, Error> {
        let mut clearcoat = Clearcoat {
            factor: json.clearcoat_factor,
            texture: self.quantity(json.clearcoat_texture.as_ref(), location, "clearcoatTexture")?,
            roughness: json.clearcoat_roughness_factor,
            roughness_texture: self.quantity(
                json.clearcoat_roughness_texture.as_ref(),
                location,
                "clearcoatRoughnessTexture",
            )?,
            ..Clearcoat::default()
        };
        if let Some(texture) = &json.clearcoat_normal_texture {
            let location = format!("{location}.clearcoatNormalTexture");
            clearcoat.normal_texture =
                self.texture(&JsonTexture::of_normals(texture), ColorSpace::Linear, &location)?;
            clearcoat.normal_scale = texture.scale;
        }
        Ok(clearcoat)
    }

    fn sheen(&mut self, json: &JsonSheen, location: &str) -> Result<Sheen, Error> {
        let color_location = format!("{location}.sheenColorTexture");
        Ok(Sheen {
            color: Vec3::from_array(json.sheen_color_factor),
            color_texture: self.plain(json.sheen_color_texture.as_ref(), ColorSpace::Srgb, &color_location)?,
            roughness: json.sheen_roughness_factor,
            roughness_texture: self.quantity(
                json.sheen_roughness_texture.as_ref(),
                location,
                "sheenRoughnessTexture",
            )?,
        })
    }

    fn anisotropy(&mut self, json: &JsonAnisotropy, location: &str) -> Result<Anisotropy, Error> {
        Ok(Anisotropy {
            strength: json.anisotropy_strength,
            rotation_radians: json.anisotropy_rotation,
            texture: self.quantity(json.anisotropy_texture.as_ref(), location, "anisotropyTexture")?,
        })
    }

    fn iridescence(&mut self, json: &JsonIridescence, location: &str) -> Result<Iridescence, Error> {
        Ok(Iridescence {
            factor: json.iridescence_factor,
            texture: self.quantity(json.iridescence_texture.as_ref(), location, "iridescenceTexture")?,
            ior: json.iridescence_ior,
            thickness_minimum_nanometers: json.iridescence_thickness_minimum,
            thickness_maximum_nanometers: json.iridescence_thickness_maximum,
            thickness_texture: self.quantity(
                json.iridescence_thickness_texture.as_ref(),
                location,
                "iridescenceThicknessTexture",
            )?,
        })
    }

    /// A texture of quantities rather than colours.
    fn quantity(&mut self, json: Option<&Info>, location: &str, name: &str) -> Result<Option<TextureUse>, Error> {
        self.plain(json, ColorSpace::Linear, &format!("{location}.{name}"))
    }
}
