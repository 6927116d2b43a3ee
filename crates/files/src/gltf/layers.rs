//! The extensions that describe a material's layers.

use glam::Vec3;
use gltf::json::material::NormalTexture;
use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use umbrage_scene::ColorSpace::{Linear, Srgb};
use umbrage_scene::{Anisotropy, Clearcoat, ColorSpace, Error, Iridescence, Layers, Sheen, Specular, TextureUse};

use super::material::{JsonTexture, Reader};

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// The set of texture coordinates along which a material's layers need tangents; `None` where they need none.
pub(super) fn tangent_coords(extensions: &Map<String, Value>) -> Option<u32> {
    let of_coat = || {
        let texture = NormalTexture::deserialize(extensions.get(CLEARCOAT)?.get("clearcoatNormalTexture")?).ok()?;
        Some(JsonTexture::of_normals(&texture).tex_coord_set())
    };
    let of_grooves = || {
        let json = extensions.get(ANISOTROPY)?;
        let texture = json.get("anisotropyTexture").and_then(|texture| Info::deserialize(texture).ok());
        let set = texture.map_or(0, |texture| JsonTexture::of_info(&texture).tex_coord_set());
        (json.get("anisotropyStrength")?.as_f64()? != 0.0).then_some(set)
    };
    of_coat().or_else(of_grooves)
}

impl<'d> Reader<'d> {
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
        if let Some(mut json) = self.layer(extensions, "KHR_materials_specular", location)? {
            layers.specular = Specular {
                factor: json.number("specularFactor", layers.specular.factor)?,
                texture: json.texture("specularTexture", Linear)?,
                color: json.color("specularColorFactor", layers.specular.color)?,
                color_texture: json.texture("specularColorTexture", Srgb)?,
            };
        }
        if let Some(mut json) = self.layer(extensions, CLEARCOAT, location)? {
            let (normal_texture, normal_scale) = json.normals("clearcoatNormalTexture")?;
            layers.clearcoat = Clearcoat {
                factor: json.number("clearcoatFactor", 0.0)?,
                texture: json.texture("clearcoatTexture", Linear)?,
                roughness: json.number("clearcoatRoughnessFactor", 0.0)?,
                roughness_texture: json.texture("clearcoatRoughnessTexture", Linear)?,
                normal_texture,
                normal_scale,
            };
        }
        if let Some(mut json) = self.layer(extensions, "KHR_materials_sheen", location)? {
            layers.sheen = Sheen {
                color: json.color("sheenColorFactor", Vec3::ZERO)?,
                color_texture: json.texture("sheenColorTexture", Srgb)?,
                roughness: json.number("sheenRoughnessFactor", 0.0)?,
                roughness_texture: json.texture("sheenRoughnessTexture", Linear)?,
            };
        }
        if let Some(mut json) = self.layer(extensions, ANISOTROPY, location)? {
            layers.anisotropy = Anisotropy {
                strength: json.number("anisotropyStrength", 0.0)?,
                rotation_radians: json.number("anisotropyRotation", 0.0)?,
                texture: json.texture("anisotropyTexture", Linear)?,
            };
        }
        if let Some(mut json) = self.layer(extensions, "KHR_materials_iridescence", location)? {
            let Iridescence { thickness_minimum_nanometers: thin, thickness_maximum_nanometers: thick, .. } =
                layers.iridescence;
            layers.iridescence = Iridescence {
                factor: json.number("iridescenceFactor", 0.0)?,
                texture: json.texture("iridescenceTexture", Linear)?,
                ior: json.number("iridescenceIor", layers.iridescence.ior)?,
                thickness_minimum_nanometers: json.number("iridescenceThicknessMinimum", thin)?,
                thickness_maximum_nanometers: json.number("iridescenceThicknessMaximum", thick)?,
                thickness_texture: json.texture("iridescenceThicknessTexture", Linear)?,
            };
        }
        Ok((!layers.are_off()).then(|| Box::new(layers)))
    }

    /// The extension `name`; `None` where the material lacks it.
    fn layer<'r>(
        &'r mut self,
        extensions: &'r Map<String, Value>,
        name: &str,
        location: &str,
    ) -> Result<Option<Layer<'r, 'd>>, Error> {
        let Some(json) = extensions.get(name) else { return Ok(None) };
        let location = format!("{location}.{name}");
        match json.as_object() {
            Some(json) => Ok(Some(Layer { reader: self, json, location })),
            None => Err(self.document.malformed(location, "it is not an object")),
        }
    }
}

/// A layer's extension in the JSON.
struct Layer<'r, 'd> {
    reader: &'r mut Reader<'d>,
    json: &'r Map<String, Value>,
    location: String,
}

impl Layer<'_, '_> {
    /// The value of a member; `None` where it is absent.
    fn value<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, Error> {
        let value = self.json.get(name).map(T::deserialize).transpose();
        value.map_err(|cause| self.reader.document.malformed(&self.location, cause.to_string()))
    }

    fn number(&self, name: &str, default: f32) -> Result<f32, Error> {
        Ok(self.value(name)?.unwrap_or(default))
    }

    fn color(&self, name: &str, default: Vec3) -> Result<Vec3, Error> {
        Ok(self.value(name)?.map_or(default, Vec3::from_array))
    }

    fn texture(&mut self, name: &str, space: ColorSpace) -> Result<Option<TextureUse>, Error> {
        let json: Option<Info> = self.value(name)?.flatten();
        self.reader.plain(json.as_ref(), space, &format!("{}.{name}", self.location))
    }

    /// A texture of normals, and their scale.
    fn normals(&mut self, name: &str) -> Result<(Option<TextureUse>, f32), Error> {
        let json: Option<NormalTexture> = self.value(name)?.flatten();
        let Some(json) = json else { return Ok((None, Clearcoat::default().normal_scale)) };
        let location = format!("{}.{name}", self.location);
        Ok((self.reader.texture(&JsonTexture::of_normals(&json), Linear, &location)?, json.scale))
    }
}
