//! Inputs of shading, as `tables.wgsl` and `develop.wgsl` declare them; a test compares the layouts.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec3};
use umbrage_rays::{LightSource, Projection};

use crate::Band;

/// The camera rays of one sample, and the layer of surfaces that they see: 176 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeSample {
    /// World position of the camera.
    pub position: [f32; 3],
    /// [`ShadeSample::PERSPECTIVE`] or [`ShadeSample::ORTHOGRAPHIC`].
    pub projection: u32,
    /// Towards the right edge of the image, of unit length.
    pub right: [f32; 3],
    /// Half the height of the view, in world units, at depth 1 for a perspective.
    pub half_height: f32,
    /// Towards the upper edge of the image, of unit length.
    pub up: [f32; 3],
    /// Width of a ray's cone at depth 0, in world units.
    pub footprint: f32,
    /// Into the image, of unit length.
    pub forward: [f32; 3],
    /// How much wider the cone becomes for each unit of depth.
    pub footprint_per_depth: f32,
    /// Position of the sample in the pixel, from (0, 0) at its upper left to (1, 1).
    pub offset_pixels: [f32; 2],
    /// Width and height of the rows that are shaded at once.
    pub size_pixels: [u32; 2],
    /// Depth of a pixel without a triangle.
    pub miss_depth: f32,
    /// Words from one light's mask to the next one's.
    pub words_per_light: u32,
    /// 1 for the sample that starts the film, else 0.
    pub is_first_sample: u32,
    /// 1 for the layer nearest to the camera, else 0.
    pub is_first_layer: u32,
    /// 1 for the layer behind which the surroundings are seen, else 0.
    pub is_last_layer: u32,
    /// First pixel of the film's plane of normals and depths; [`ShadeScene::NO_WORD`] for none.
    pub first_plane: u32,
    /// First pixel of the film's plane of transmittance; [`ShadeScene::NO_WORD`] for none.
    pub through_plane: u32,
    /// First pixel of the film's plane of colour without tone mapping; [`ShadeScene::NO_WORD`] for none.
    pub flat_plane: u32,
    /// The first of the rows that are shaded at once.
    pub first_row: u32,
    /// Number of rows of the whole image.
    pub image_height: u32,
    /// Maximum number of mirrors and glass surfaces in a row.
    pub bounces: u32,
    /// Minimum throughput, 0 to 1: paths that contribute no more are cut.
    pub least_contribution: f32,
    /// First pixel of the planes of followed rays; [`ShadeScene::NO_WORD`] for none.
    pub ways_plane: u32,
    /// Number of these planes.
    pub ways_count: u32,
    /// First word of the transmittances before lights, in the lights' masks; [`ShadeScene::NO_WORD`] if all of them are one.
    pub tints_word: u32,
    /// Number of the first of these pixels in the image, row by row: random points depend on it …
    pub first_pixel: u32,
    /// … and on the number of the sample.
    pub number: u32,
    /// Number of points whose visibility from lights is found before they are shaded.
    pub points: u32,
    /// 1 if a mask of ambient visibility follows the masks of lights, else 0.
    pub looks_around: u32,
    #[doc(hidden)]
    pub padding: u32,
}

impl ShadeSample {
    /// `projection` of rays from one point.
    pub const PERSPECTIVE: u32 = 0;
    /// `projection` of parallel rays.
    pub const ORTHOGRAPHIC: u32 = 1;

    /// The rays of some rows of a view through one point in each pixel. [`Shade::prepare`](super::Shade::prepare) sets
    /// the members that depend on the film and its layers, the caller the cone's width.
    #[must_use]
    pub fn new(band: impl Into<Band>, offset_pixels: DVec2) -> Self {
        let band = band.into();
        let view = &band.view;
        let (projection, half_height) = match view.camera.projection {
            Projection::Perspective { tan_half_height } => (Self::PERSPECTIVE, tan_half_height),
            Projection::Orthographic { half_height } => (Self::ORTHOGRAPHIC, half_height),
        };
        Self {
            position: view.camera.position.to_array(),
            projection,
            right: view.camera.right.to_array(),
            half_height,
            up: view.camera.up.to_array(),
            forward: view.camera.forward.to_array(),
            offset_pixels: offset_pixels.as_vec2().to_array(),
            size_pixels: band.size(),
            first_row: band.rows.start,
            image_height: view.height,
            miss_depth: f32::INFINITY,
            first_pixel: band.rows.start * view.width,
            tints_word: ShadeScene::NO_WORD,
            ..Self::default()
        }
    }
}

/// The scene's surroundings: 176 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeSurroundings {
    /// Irradiance by direction: coefficients of the real spherical harmonics of bands 0 to 2, convolved with the cosine
    /// lobe; the fourth number is unused.
    pub irradiance: [[f32; 4]; 9],
    /// Radiance of [`ShadeSurroundings::COLOR`].
    pub color: [f32; 3],
    /// [`ShadeSurroundings::COLOR`], [`ShadeSurroundings::SKY`], [`ShadeSurroundings::IMAGE`] or
    /// [`ShadeSurroundings::TRANSPARENT`].
    pub kind: u32,
    /// Width and height of the panorama's full image.
    pub panorama_size: [u32; 2],
    /// Number of its levels.
    pub panorama_levels: u32,
    /// Index of its list of levels in the [`Texels`](super::Texels).
    pub panorama_word: u32,
}

impl ShadeSurroundings {
    /// `kind` of one colour everywhere.
    pub const COLOR: u32 = 0;
    /// `kind` of the procedural sky.
    pub const SKY: u32 = 1;
    /// `kind` of a latitude–longitude image.
    pub const IMAGE: u32 = 2;
    /// `kind` of a sky that lights and is mirrored, but isn't seen.
    pub const TRANSPARENT: u32 = 3;
}

/// Parameters of a frame, the same for all pixels: 208 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ShadeScene {
    /// The surroundings.
    pub surroundings: ShadeSurroundings,
    /// First word of the triangles' materials in the attributes.
    pub material_word: u32,
    /// First word of the vertices' normals; this and the next are [`ShadeScene::NO_WORD`] for none.
    pub normal_word: u32,
    /// First word of the vertices' tangents.
    pub tangent_word: u32,
    /// First word of the vertices' colours.
    pub color_word: u32,
    /// First words of both sets of the vertices' texture coordinates.
    pub tex_coord_words: [u32; 2],
    /// Number of lights.
    pub light_count: u32,
    /// Number of lights, the last ones, that carry the sky's light from a single direction and are only scattered: then
    /// there is no ambient light.
    pub sky_light_count: u32,
}

impl ShadeScene {
    /// Stands for a missing attribute or plane.
    pub const NO_WORD: u32 = u32::MAX;
}

impl Default for ShadeScene {
    /// Black, with no attributes and no lights.
    fn default() -> Self {
        Self {
            material_word: Self::NO_WORD,
            normal_word: Self::NO_WORD,
            tangent_word: Self::NO_WORD,
            color_word: Self::NO_WORD,
            tex_coord_words: [Self::NO_WORD; 2],
            ..Self::zeroed()
        }
    }
}

/// A light: 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeLight {
    /// World position; unused for a directional light.
    pub position: [f32; 3],
    /// [`ShadeLight::POINT`], [`ShadeLight::SPOT`], [`ShadeLight::DIRECTIONAL`] or [`ShadeLight::FLAT`].
    pub kind: u32,
    /// Direction of travel, of unit length; unused for a point light.
    pub direction: [f32; 3],
    /// Distance at which it has faded to zero, in world units; 0 for never.
    pub range: f32,
    /// Colour times intensity: candela, or lux for a directional light.
    pub emitted: [f32; 3],
    /// Cosine of a spot light's outer half-angle.
    pub outer_cosine: f32,
    /// Cosine of the inner half-angle minus that of the outer; above zero.
    pub cosine_span: f32,
    #[doc(hidden)]
    pub padding: [u32; 3],
}

impl ShadeLight {
    /// `kind` of a light in every direction from one point.
    pub const POINT: u32 = 0;
    /// `kind` of a light from one point inside a cone.
    pub const SPOT: u32 = 1;
    /// `kind` of parallel light.
    pub const DIRECTIONAL: u32 = 2;
    /// `kind` of a point of a flat light, whose radiance falls off with the cosine to the side.
    pub const FLAT: u32 = 3;
    /// Maximum number of lights.
    pub const MOST: usize = 1024;

    /// A light of intensity `emitted` that fades to zero at `range`; `None` for never. A flat light is a spot as well.
    #[must_use]
    pub fn new(source: &LightSource, is_flat: bool, emitted: Vec3, range: Option<f32>) -> Self {
        let light = Self { emitted: emitted.to_array(), range: range.unwrap_or(0.0), ..Self::default() };
        match *source {
            LightSource::Point { position } => Self { position: position.to_array(), kind: Self::POINT, ..light },
            LightSource::Spot { position, direction, inner_radians, outer_radians } => Self {
                position: position.to_array(),
                kind: if is_flat { Self::FLAT } else { Self::SPOT },
                direction: direction.to_array(),
                outer_cosine: outer_radians.cos(),
                cosine_span: (inner_radians.cos() - outer_radians.cos()).max(1e-4),
                ..light
            },
            LightSource::Directional { direction } => {
                Self { direction: direction.to_array(), kind: Self::DIRECTIONAL, ..light }
            }
        }
    }
}

/// A metallic-roughness material: 1184 bytes. Colours are linear; a texture multiplies its factor.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeMaterial {
    /// Colour and opacity.
    pub base_color: [f32; 4],
    /// Emitted radiance.
    pub emissive: [f32; 3],
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// Perceptual roughness, 0 for a mirror.
    pub roughness: f32,
    /// Index of refraction.
    pub ior: f32,
    /// Fraction of light that is transmitted instead of being scattered, 0 to 1.
    pub transmission: f32,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// Strength of the occlusion texture, 0 to 1.
    pub occlusion_strength: f32,
    /// 1 if opacity blends it with the surfaces behind, else 0.
    pub is_blended: u32,
    /// 1 if the base colour is shown without light, else 0.
    pub is_unlit: u32,
    /// 1 for a shadow catcher, else 0.
    pub catches_shadows: u32,
    /// 1 if it bounds a volume of glass, else 0.
    pub bounds_volume: u32,
    /// Dispersion: `KHR_materials_dispersion`.
    pub dispersion: f32,
    /// Distance after which white light has the attenuation colour, in world units; 0 for never.
    pub attenuation_distance: f32,
    /// Minimum opacity of a masked material's points; 0 without a mask.
    pub mask_cutoff: f32,
    /// Colour that is left of white light after that distance.
    pub attenuation_color: [f32; 3],
    /// Bits of its layers: a sum of [`ShadeLayers::SPECULAR`] …
    pub layer_bits: u32,
    /// Layers on its surface and in it.
    pub layers: ShadeLayers,
    /// By use: [`ShadeMaterial::BASE_COLOR`] …
    pub textures: [ShadeTexture; 16],
}

/// Layers that few materials have: 80 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeLayers {
    /// Factor of the reflectance at normal incidence.
    pub specular_color: [f32; 3],
    /// Strength of dielectric reflection, 0 to 1.
    pub specular: f32,
    /// Reflectance of the fibres, 0 to 1.
    pub sheen_color: [f32; 3],
    /// Roughness of the fibres, 0 to 1.
    pub sheen_roughness: f32,
    /// Fraction of the surface with a clear coat, 0 to 1.
    pub coat: f32,
    /// Perceptual roughness of the coat.
    pub coat_roughness: f32,
    /// Scale of its normal texture's x and y.
    pub coat_normal_scale: f32,
    /// Strength of anisotropy, 0 to 1.
    pub stretch: f32,
    /// Cosine and sine of the rotation of the anisotropy's direction.
    pub stretch_turn: [f32; 2],
    /// Fraction of specular reflection that a thin film colours, 0 to 1.
    pub film: f32,
    /// The film's index of refraction, at least 1.
    pub film_ior: f32,
    /// Its thickness in nanometres where its texture is 0 and 1.
    pub film_nanometers: [f32; 2],
    #[doc(hidden)]
    pub padding: [u32; 2],
}

impl ShadeLayers {
    /// Bit of a specular strength or colour.
    pub const SPECULAR: u32 = 1;
    /// Bit of a clear coat.
    pub const COAT: u32 = 2;
    /// Bit of sheen.
    pub const SHEEN: u32 = 4;
    /// Bit of anisotropy.
    pub const GROOVES: u32 = 8;
    /// Bit of a thin film.
    pub const FILM: u32 = 16;
}

impl ShadeMaterial {
    /// Index in `textures` of colour (sRGB) and opacity.
    pub const BASE_COLOR: usize = 0;
    /// Index in `textures` of roughness in green and metallic in blue.
    pub const METALLIC_ROUGHNESS: usize = 1;
    /// Index in `textures` of tangent-space normals.
    pub const NORMAL: usize = 2;
    /// Index in `textures` of ambient occlusion in red.
    pub const OCCLUSION: usize = 3;
    /// Index in `textures` of emitted colour (sRGB).
    pub const EMISSIVE: usize = 4;
    /// Index in `textures` of transmission in red.
    pub const TRANSMISSION: usize = 5;
    /// Index in `textures` of specular strength in alpha.
    pub const SPECULAR: usize = 6;
    /// Index in `textures` of specular colour (sRGB).
    pub const SPECULAR_COLOR: usize = 7;
    /// Index in `textures` of lacquer in red.
    pub const COAT: usize = 8;
    /// Index in `textures` of the lacquer's roughness in green.
    pub const COAT_ROUGHNESS: usize = 9;
    /// Index in `textures` of the lacquer's normals.
    pub const COAT_NORMAL: usize = 10;
    /// Index in `textures` of the fibres' colour (sRGB).
    pub const SHEEN_COLOR: usize = 11;
    /// Index in `textures` of the fibres' roughness in alpha.
    pub const SHEEN_ROUGHNESS: usize = 12;
    /// Index in `textures` of the stretch: its direction in red and green, its strength in blue.
    pub const GROOVES: usize = 13;
    /// Index in `textures` of the film in red.
    pub const FILM: usize = 14;
    /// Index in `textures` of the film's thickness in green.
    pub const FILM_THICKNESS: usize = 15;
}

/// A texture as a material uses it: 64 bytes. All zero if there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeTexture {
    /// Matrix from the mesh's texture coordinates to the image's, (0, 0) being its upper left corner: two columns.
    pub matrix: [f32; 4],
    /// Translation after the matrix.
    pub translation: [f32; 2],
    /// Width and height of the full image.
    pub size: [u32; 2],
    /// Wrapping beyond the image's edges in x and in y: [`ShadeTexture::REPEAT`], [`ShadeTexture::MIRRORED_REPEAT`] or
    /// [`ShadeTexture::CLAMP_TO_EDGE`].
    pub wrap: [u32; 2],
    /// Number of levels: the full image and its smaller copies; 0 if there is no texture.
    pub levels: u32,
    /// Index of its list of levels in the [`Texels`](super::Texels).
    pub levels_word: u32,
    /// The set of texture coordinates: 0 or 1.
    pub tex_coord_set: u32,
    /// 1 to read the nearest texel, 0 to mix the four nearest.
    pub is_nearest: u32,
    /// 1 for colours encoded by the sRGB transfer function, 0 for quantities.
    pub is_srgb: u32,
    #[doc(hidden)]
    pub padding: u32,
}

impl ShadeTexture {
    /// `wrap`: the image repeats.
    pub const REPEAT: u32 = 0;
    /// `wrap`: the image mirrored, then the image again.
    pub const MIRRORED_REPEAT: u32 = 1;
    /// `wrap`: the edge's texels.
    pub const CLAMP_TO_EDGE: u32 = 2;
}

/// Parameters of developing a film: 28 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct DevelopSettings {
    /// One over the number of samples, which turns the film's sums into means.
    pub(crate) weight: f32,
    /// Factor of the means.
    pub(crate) exposure: f32,
    /// [`DevelopSettings::NEUTRAL`] or [`DevelopSettings::CLIP`].
    pub(crate) tone_map: u32,
    /// Width of the image in pixels.
    pub(crate) width: u32,
    /// Height of the image in pixels.
    pub(crate) height: u32,
    /// Distance between rows of the image, in pixels.
    pub(crate) row_pixels: u32,
    /// First pixel of the film's plane of colour without tone mapping; [`DevelopSettings::NO_PLANE`] for none.
    pub(crate) flat_plane: u32,
}

impl DevelopSettings {
    /// `tone_map`: Khronos PBR Neutral.
    pub(crate) const NEUTRAL: u32 = 0;
    /// `tone_map`: values above one are clamped.
    pub(crate) const CLIP: u32 = 1;
    /// `flat_plane`: all colours are tone mapped.
    pub(crate) const NO_PLANE: u32 = u32::MAX;
}
