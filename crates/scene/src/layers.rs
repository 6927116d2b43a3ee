use glam::Vec3;

use crate::TextureUse;

/// What shapes a material's reflection beyond metal, colour and roughness, and what lies on top of it. By default all of it is
/// off. Colours are linear; a texture multiplies its factor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// How much of what isn't metal mirrors, and in which colour.
    pub specular: Specular,
    /// A clear lacquer, on top of all else.
    pub clearcoat: Clearcoat,
    /// Fibres that stand up from cloth, below the lacquer.
    pub sheen: Sheen,
    /// Grooves that stretch highlights.
    pub anisotropy: Anisotropy,
    /// A film so thin that light interferes in it.
    pub iridescence: Iridescence,
}

impl Layers {
    /// Whether the material looks as it would without.
    #[must_use]
    pub fn are_off(&self) -> bool {
        self.specular == Specular::default()
            && self.clearcoat.factor == 0.0
            && self.sheen.color == Vec3::ZERO
            && self.anisotropy.strength == 0.0
            && self.iridescence.factor == 0.0
    }

    /// All of their textures.
    #[must_use]
    pub fn textures(&self) -> [Option<TextureUse>; 10] {
        let Self { specular, clearcoat, sheen, anisotropy, iridescence } = self;
        [
            specular.texture,
            specular.color_texture,
            clearcoat.texture,
            clearcoat.roughness_texture,
            clearcoat.normal_texture,
            sheen.color_texture,
            sheen.roughness_texture,
            anisotropy.texture,
            iridescence.texture,
            iridescence.thickness_texture,
        ]
    }

    pub(crate) fn textures_mut(&mut self) -> [&mut Option<TextureUse>; 10] {
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

    /// Whether all of their numbers are finite.
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

/// Strength and colour of what isn't metal mirrors (`KHR_materials_specular`).
#[derive(Clone, Debug, PartialEq)]
pub struct Specular {
    /// How much of it is mirrored, 0 … 1.
    pub factor: f32,
    /// The factor in alpha.
    pub texture: Option<TextureUse>,
    /// What mirrors straight ahead is multiplied by; at grazing angles all colours are mirrored. Not below 0.
    pub color: Vec3,
    /// The colour (sRGB).
    pub color_texture: Option<TextureUse>,
}

impl Default for Specular {
    /// As the index of refraction says.
    fn default() -> Self {
        Self { factor: 1.0, texture: None, color: Vec3::ONE, color_texture: None }
    }
}

/// A clear lacquer of index 1.5 (`KHR_materials_clearcoat`).
#[derive(Clone, Debug, PartialEq)]
pub struct Clearcoat {
    /// How much of the surface it covers, 0 … 1.
    pub factor: f32,
    /// The factor in red.
    pub texture: Option<TextureUse>,
    /// Perceptual roughness, 0 for a mirror.
    pub roughness: f32,
    /// Roughness in green.
    pub roughness_texture: Option<TextureUse>,
    /// Its own tangent-space normals; without, it is as smooth as the vertices' normals, whatever is below.
    pub normal_texture: Option<TextureUse>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
}

impl Clearcoat {
    /// What part of the light it reflects straight ahead.
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
    /// What they reflect, 0 … 1; black for none.
    pub color: Vec3,
    /// The colour (sRGB).
    pub color_texture: Option<TextureUse>,
    /// How far fibres lean from the normal, 0 … 1.
    pub roughness: f32,
    /// Roughness in alpha.
    pub roughness_texture: Option<TextureUse>,
}

/// Grooves across which, or fibres along which highlights are stretched (`KHR_materials_anisotropy`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// How much rougher the surface is in the direction of the stretch, 0 … 1.
    pub strength: f32,
    /// From the tangent to that direction, towards the bitangent.
    pub rotation_radians: f32,
    /// The direction along tangent and bitangent in red and green, from −1 to 1, which is turned by the rotation, and the
    /// strength in blue.
    pub texture: Option<TextureUse>,
}

/// A film so thin that light interferes in it (`KHR_materials_iridescence`).
#[derive(Clone, Debug, PartialEq)]
pub struct Iridescence {
    /// How much of the mirrored light the film colours, 0 … 1.
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
