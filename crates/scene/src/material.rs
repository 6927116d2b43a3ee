use glam::{Affine2, Vec2, Vec3, Vec4};

use crate::texture::TilePool;
use crate::{Error, Layers, Texture, TextureTraffic};

/// Every material and texture of a scene.
#[derive(Clone, Debug, Default)]
pub struct Materials {
    /// Materials, indexed by [`Mesh::material_of_triangle`](crate::Mesh).
    pub materials: Vec<Material>,
    /// Textures, indexed by [`TextureUse::texture`].
    pub textures: Vec<Texture>,
}

impl Materials {
    /// Reads of textures on demand ([`Texture::kept_in`]) so far, by all
    /// users of the textures; `None` where all textures are in memory.
    #[must_use]
    pub fn texture_traffic(&self) -> Option<TextureTraffic> {
        self.tile_pool().map(TilePool::traffic)
    }

    /// Checks that all reads of textures so far have succeeded.
    ///
    /// # Errors
    /// [`Error::TextureFile`], where the file of textures on demand couldn't be read: some texels were black then.
    pub fn check_textures(&self) -> Result<(), Error> {
        match self.tile_pool().and_then(TilePool::failure) {
            Some(why) => Err(Error::TextureFile(why.to_owned())),
            None => Ok(()),
        }
    }

    /// The textures of a file have one pool.
    fn tile_pool(&self) -> Option<&TilePool> {
        self.textures.iter().find_map(Texture::tile_pool).map(|pool| &**pool)
    }
}

/// A glTF 2.0 metallic-roughness material. Colours are linear; a texture multiplies its factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name in the file; may be empty.
    pub name: String,
    /// Colour and opacity.
    pub base_color: Vec4,
    /// Colour (sRGB) and opacity.
    pub base_color_texture: Option<TextureUse>,
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// Perceptual roughness, 0 for a mirror.
    pub roughness: f32,
    /// Roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureUse>,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// Ambient occlusion in red.
    pub occlusion_texture: Option<TextureUse>,
    /// How much of `occlusion_texture` applies, 0 … 1.
    pub occlusion_strength: f32,
    /// Emitted radiance: emissive factor times emissive strength.
    pub emissive: Vec3,
    /// Emitted colour (sRGB).
    pub emissive_texture: Option<TextureUse>,
    /// Effect of opacity.
    pub alpha: Alpha,
    /// Whether triangles have a back, too; otherwise all rays pass through them from behind.
    pub double_sided: bool,
    /// Shown in its base colour, unaffected by light (`KHR_materials_unlit`).
    pub unlit: bool,
    /// How much light passes through instead of being scattered, 0 … 1 (`KHR_materials_transmission`).
    pub transmission: f32,
    /// Transmission in red.
    pub transmission_texture: Option<TextureUse>,
    /// Index of refraction (`KHR_materials_ior`).
    pub ior: f32,
    /// Dispersion, 20 over Abbe's number: blue light is refracted more than red (`KHR_materials_dispersion`).
    pub dispersion: f32,
    /// The medium inside (`KHR_materials_volume`).
    pub volume: Volume,
    /// Whether it is a shadow catcher: it shows the background, darkened by the share of light that occluders block. Its
    /// colours are then ignored; it should be opaque.
    pub catches_shadows: bool,
    /// Properties that few materials have; `None` for none of them.
    pub layers: Option<Box<Layers>>,
}

impl Default for Material {
    /// glTF's default material, but rough plastic rather than rough metal.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
            transmission: 0.0,
            transmission_texture: None,
            ior: 1.5,
            dispersion: 0.0,
            volume: Volume::default(),
            catches_shadows: false,
            layers: None,
        }
    }
}

impl Material {
    /// Whether its surfaces bound a transmissive volume, rather than being thin walls. They are then double-sided, as
    /// `KHR_materials_volume` says.
    #[must_use]
    pub fn bounds_volume(&self) -> bool {
        self.transmission > 0.0 && self.volume.thickness > 0.0
    }

    /// Whether its surfaces may show objects straight behind them.
    #[must_use]
    pub fn is_see_through(&self) -> bool {
        self.alpha == Alpha::Blend || self.transmission > 0.0
    }

    /// The material of files without materials: rough, light grey and two-sided.
    #[must_use]
    pub fn clay() -> Self {
        Self { base_color: Vec4::new(0.7, 0.7, 0.7, 1.0), double_sided: true, ..Self::default() }
    }

    /// All of its textures, but those of its layers.
    #[inline]
    #[must_use]
    pub fn textures(&self) -> [Option<TextureUse>; 7] {
        [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.occlusion_texture,
            self.emissive_texture,
            self.transmission_texture,
            self.volume.thickness_texture,
        ]
    }
}

/// Effect of a material's opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Opacity is ignored.
    Opaque,
    /// Points with an opacity below the cutoff are not there.
    Mask {
        /// Usually 0.5.
        cutoff: f32,
    },
    /// Opacity blends the surface with the background.
    Blend,
}

/// The medium inside a closed transmissive surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Thickness in the mesh's own units; 0 for a thin wall.
    pub thickness: f32,
    /// Thickness in green.
    pub thickness_texture: Option<TextureUse>,
    /// Distance over which white light takes `attenuation_color`, in world units; infinite for clear.
    pub attenuation_distance: f32,
    /// Linear colour.
    pub attenuation_color: Vec3,
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness: 0.0,
            thickness_texture: None,
            attenuation_distance: f32::INFINITY,
            attenuation_color: Vec3::ONE,
        }
    }
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index in [`Materials::textures`].
    pub texture: u32,
    /// Which set of texture coordinates: 0 or 1.
    pub tex_coord_set: u8,
    /// From the mesh's texture coordinates to the image's (`KHR_texture_transform`).
    pub image_from_mesh: Affine2,
}

impl TextureUse {
    /// Texture `texture` over coordinate set 0, untransformed.
    #[must_use]
    pub fn new(texture: u32) -> Self {
        Self { texture, tex_coord_set: 0, image_from_mesh: Affine2::IDENTITY }
    }

    /// Where in the image the mesh coordinates `tex_coords` (set 0 and set 1) are.
    #[must_use]
    pub fn image_coords(&self, tex_coords: [Vec2; 2]) -> Vec2 {
        self.image_from_mesh.transform_point2(tex_coords[usize::from(self.tex_coord_set.min(1))])
    }
}
