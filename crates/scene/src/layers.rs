use glam::Vec3;

use crate::TextureUse;

/// Optional layers of a material: properties of its reflection beyond metalness, colour and roughness, and coats on top. All
/// are off by default. Colours are linear; a texture multiplies its factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Strength and colour of dielectric specular reflection.
    pub specular: Specular,
    /// A clear lacquer on top of all other layers.
    pub clearcoat: Clearcoat,
    /// Fibres that stand up from cloth, below the lacquer.
    pub sheen: Sheen,
    /// Grooves that stretch highlights.
    pub anisotropy: Anisotropy,
    /// A film so thin that light interferes in it.
    pub iridescence: Iridescence,
}

impl Layers {
    /// Whether the layers change nothing.
    #[must_use]
    pub fn are_off(&self) -> bool {
        self.specular == Specular::default()
            && self.clearcoat.factor == 0.0
            && self.sheen.color == Vec3::ZERO
            && self.anisotropy.strength == 0.0
            && self.iridescence.factor == 0.0
    }

    /// The textures of all layers.
    #[must_use]
    pub fn textures(&self) -> [Option<TextureUse>; 10] {
        self.clone().textures_mut().map(|texture| *texture)
    }

    /// As [`textures`](Self::textures), to change them.
    pub fn textures_mut(&mut self) -> [&mut Option<TextureUse>; 10] {
        let Self { specular, clearcoat, sheen, anisotropy, iridescence } = self;
        [
            &mut specular.texture,
            &mut specular.color_texture,
            &mut clearcoat.texture,
            &mut clearcoat.roughness_texture,
            &mut clearcoat.normal_texture,
            &mut sheen.color_texture,
            &mut sheen.roughness_texture,
            &mut anisotropy.texture,
            &mut iridescence.texture,
            &mut iridescence.thickness_texture,
        ]
    }

    /// Whether all numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let Self { specular, clearcoat, sheen, anisotropy, iridescence } = self;
        let numbers = [
            specular.factor,
            clearcoat.factor,
            clearcoat.roughness,
            clearcoat.normal_scale,
            sheen.roughness,
            anisotropy.strength,
            anisotropy.rotation_radians,
            iridescence.factor,
            iridescence.ior,
            iridescence.thickness_minimum_nanometers,
            iridescence.thickness_maximum_nanometers,
        ];
        specular.color.is_finite() && sheen.color.is_finite() && numbers.iter().all(|number| number.is_finite())
    }
}

/// Strength and colour of dielectric specular reflection (`KHR_materials_specular`).
#[derive(Clone, Debug, PartialEq)]
pub struct Specular {
    /// Strength, 0 … 1.
    pub factor: f32,
    /// The factor in alpha.
    pub texture: Option<TextureUse>,
    /// Colour that multiplies F0, at least 0; reflection at grazing angles stays uncoloured.
    pub color: Vec3,
    /// The colour (sRGB).
    pub color_texture: Option<TextureUse>,
}

impl Default for Specular {
    /// Reflection by the index of refraction alone.
    fn default() -> Self {
        Self { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None }
    }
}

/// A clear lacquer of index 1.5 (`KHR_materials_clearcoat`).
#[derive(Clone, Debug, PartialEq)]
pub struct Clearcoat {
    /// Coverage, 0 … 1.
    pub factor: f32,
    /// The factor in red.
    pub texture: Option<TextureUse>,
    /// Perceptual roughness, 0 for a mirror.
    pub roughness: f32,
    /// Roughness in green.
    pub roughness_texture: Option<TextureUse>,
    /// The lacquer's own tangent-space normals; without a texture, it has the vertices' normals and ignores the base's
    /// normal map.
    pub normal_texture: Option<TextureUse>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
}

impl Clearcoat {
    /// Reflectance at normal incidence.
    pub const F0: f32 = 0.04;
}

impl Default for Clearcoat {
    /// None.
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            roughness: 0.0,
            roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
        }
    }
}

/// Fibres that scatter light back and ahead at grazing angles (`KHR_materials_sheen`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Reflected colour, 0 … 1; black for no sheen.
    pub color: Vec3,
    /// The colour (sRGB).
    pub color_texture: Option<TextureUse>,
    /// Spread of the fibres around the normal, 0 … 1.
    pub roughness: f32,
    /// Roughness in alpha.
    pub roughness_texture: Option<TextureUse>,
}

/// Grooves or fibres that stretch highlights in one direction (`KHR_materials_anisotropy`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// Increase of roughness in the direction of the stretch, 0 … 1.
    pub strength: f32,
    /// Angle from the tangent to that direction, towards the bitangent.
    pub rotation_radians: f32,
    /// The direction along tangent and bitangent in red and green, from −1 to 1, which is turned by the rotation, and the
    /// strength in blue.
    pub texture: Option<TextureUse>,
}

/// A film so thin that light interferes in it (`KHR_materials_iridescence`).
#[derive(Clone, Debug, PartialEq)]
pub struct Iridescence {
    /// Share of the specular reflection that the film colours, 0 … 1.
    pub factor: f32,
    /// The factor in red.
    pub texture: Option<TextureUse>,
    /// The film's index of refraction, at least 1.
    pub ior: f32,
    /// Its thickness where the texture has 0.
    pub thickness_minimum_nanometers: f32,
    /// Its thickness where the texture has 1, and without a texture.
    pub thickness_maximum_nanometers: f32,
    /// Thickness in green, between the two.
    pub thickness_texture: Option<TextureUse>,
}

impl Default for Iridescence {
    /// None, of glTF's default index and thickness.
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            ior: 1.3,
            thickness_minimum_nanometers: 100.0,
            thickness_maximum_nanometers: 400.0,
            thickness_texture: None,
        }
    }
}
