//! What shading reads, as `tables.wgsl` and `develop.wgsl` declare it; a test compares the layouts.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec3};
use umbrage_rays::{LightSource, Projection};

use crate::Band;

/// The camera rays of one sample, and which layer of surfaces they meet: 176 bytes.
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
    /// Where in the pixel the sample is, from (0, 0) at its upper left to (1, 1).
    pub offset_pixels: [f32; 2],
    /// Width and height of the rows that are shaded at once.
    pub size_pixels: [u32; 2],
    /// The depth of a pixel that shows nothing.
    pub miss_depth: f32,
    /// Words from one light's mask to the next one's.
    pub words_per_light: u32,
    /// 1 for the sample that starts the film, else 0.
    pub is_first_sample: u32,
    /// 1 for the layer nearest to the camera, else 0.
    pub is_first_layer: u32,
    /// 1 for the layer behind which the surroundings are seen, else 0.
    pub is_last_layer: u32,
    /// Where the film's plane of normals and depths starts, in pixels; [`ShadeScene::NO_WORD`] for none.
    pub first_plane: u32,
    /// Where the film's plane of what layers let through starts, in pixels; [`ShadeScene::NO_WORD`] for none.
    pub through_plane: u32,
    /// Where the film's plane of what is shown as it is starts, in pixels; [`ShadeScene::NO_WORD`] for none.
    pub flat_plane: u32,
    /// The first of the rows that are shaded at once.
    pub first_row: u32,
    /// How many rows the whole image has.
    pub image_height: u32,
    /// How many mirrors and surfaces of glass in a row are followed.
    pub bounces: u32,
    /// Less of what they show isn't followed.
    pub least_contribution: f32,
    /// Where the planes of where light comes from start, in pixels; [`ShadeScene::NO_WORD`] for none.
    pub ways_plane: u32,
    /// How many these are.
    pub ways_count: u32,
    /// Where it is in the lights' masks what of each comes through what is before surfaces; [`ShadeScene::NO_WORD`] where all of
    /// it does.
    pub tints_word: u32,
    /// The number of the first of these pixels among all of the image, row by row: what is drawn for a pixel depends on it …
    pub first_pixel: u32,
    /// … and on the number of the sample.
    pub number: u32,
    /// How many points lights are asked about before they are shaded.
    pub points: u32,
    /// 1 where masks say behind those of all lights whether light from all around arrives, else 0.
    pub looks_around: u32,
    #[doc(hidden)]
    pub padding: u32,
}

impl ShadeSample {
    /// `projection` of rays from one point.
    pub const PERSPECTIVE: u32 = 0;
    /// `projection` of parallel rays.
    pub const ORTHOGRAPHIC: u32 = 1;

    /// The rays of some rows of a view through one point in each pixel. What belongs to the film and its layers is set by
    /// [`Shade::prepare`](super::Shade::prepare), the cone's width by the caller.
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

/// What is around the scene: 176 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeSurroundings {
    /// Irradiance by direction: coefficients of the real spherical harmonics of bands 0 to 2, convolved with the cosine
    /// lobe; the fourth number is nothing.
    pub irradiance: [[f32; 4]; 9],
    /// Radiance of [`ShadeSurroundings::COLOR`].
    pub color: [f32; 3],
    /// [`ShadeSurroundings::COLOR`], [`ShadeSurroundings::SKY`], [`ShadeSurroundings::IMAGE`] or
    /// [`ShadeSurroundings::TRANSPARENT`].
    pub kind: u32,
    /// Width and height of the panorama's full image.
    pub panorama_size: [u32; 2],
    /// How many levels it has.
    pub panorama_levels: u32,
    /// Where its list of levels is among the [`Texels`](super::Texels).
    pub panorama_word: u32,
}

impl ShadeSurroundings {
    /// `kind` of one colour everywhere.
    pub const COLOR: u32 = 0;
    /// `kind` of the sky that is made by a formula.
    pub const SKY: u32 = 1;
    /// `kind` of a latitude–longitude image.
    pub const IMAGE: u32 = 2;
    /// `kind` of the sky that lights and is mirrored, but isn't seen.
    pub const TRANSPARENT: u32 = 3;
}

/// What is the same for all pixels of a frame: 208 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ShadeScene {
    /// What is around it.
    pub surroundings: ShadeSurroundings,
    /// Where the attributes have the triangles' materials.
    pub material_word: u32,
    /// Where they have the vertices' normals; this and the next are [`ShadeScene::NO_WORD`] for none.
    pub normal_word: u32,
    /// Where they have the vertices' tangents.
    pub tangent_word: u32,
    /// Where they have the vertices' colours.
    pub color_word: u32,
    /// Where they have both sets of the vertices' texture coordinates.
    pub tex_coord_words: [u32; 2],
    /// How many lights there are.
    pub light_count: u32,
    /// How many of these, which are the last ones, are light from all around in a single direction, which is only scattered:
    /// then there is none from everywhere.
    pub sky_light_count: u32,
}

impl ShadeScene {
    /// Stands for what isn't there.
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
    /// World position; nothing for a directional light.
    pub position: [f32; 3],
    /// [`ShadeLight::POINT`], [`ShadeLight::SPOT`], [`ShadeLight::DIRECTIONAL`] or [`ShadeLight::FLAT`].
    pub kind: u32,
    /// In which the light travels, of unit length; nothing for a point light.
    pub direction: [f32; 3],
    /// Distance at which it has faded to nothing, in world units; 0 for never.
    pub range: f32,
    /// Colour times intensity: candela, or lux for a directional light.
    pub emitted: [f32; 3],
    /// Cosine of a spot light's outer half-angle.
    pub outer_cosine: f32,
    /// How much greater the cosine of its inner half-angle is; above zero.
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
    /// `kind` of a point of a flat light, which sends as much as the cosine says to the side.
    pub const FLAT: u32 = 3;
    /// The most lights that are shaded at once.
    pub const MOST: usize = 1024;

    /// A light that sends `emitted` and fades to nothing at `range`; `None` for never. A flat one is a spot as well.
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
    /// How much light passes through instead of being scattered, 0 … 1.
    pub transmission: f32,
    /// Scale of the normal texture's x and y.
    pub normal_scale: f32,
    /// How much of the occlusion texture applies, 0 … 1.
    pub occlusion_strength: f32,
    /// 1 where opacity mixes with what is behind, else 0.
    pub is_blended: u32,
    /// 1 where the base colour is shown whatever the light, else 0.
    pub is_unlit: u32,
    /// 1 where only the shadows on it are seen, else 0.
    pub catches_shadows: u32,
    /// 1 where it is the surface of a body of glass, else 0.
    pub bounds_volume: u32,
    /// How far apart colours are refracted there: `KHR_materials_dispersion`.
    pub dispersion: f32,
    /// After how far in it light has its colour, in world units; 0 where it never does.
    pub attenuation_distance: f32,
    /// The least opacity that is there, where that depends on it; else 0.
    pub mask_cutoff: f32,
    /// The colour that is left of white light then.
    pub attenuation_color: [f32; 3],
    /// Which of the layers it has: a sum of [`ShadeLayers::SPECULAR`] …
    pub layer_bits: u32,
    /// What lies on its surface and in it.
    pub layers: ShadeLayers,
    /// By use: [`ShadeMaterial::BASE_COLOR`] …
    pub textures: [ShadeTexture; 16],
}

/// What few materials have: 80 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeLayers {
    /// What mirroring straight ahead is multiplied by.
    pub specular_color: [f32; 3],
    /// How much of what isn't metal mirrors, 0 … 1.
    pub specular: f32,
    /// What fibres reflect, 0 … 1.
    pub sheen_color: [f32; 3],
    /// How far fibres lean, 0 … 1.
    pub sheen_roughness: f32,
    /// How much of the surface is lacquered, 0 … 1.
    pub coat: f32,
    /// Perceptual roughness of the lacquer.
    pub coat_roughness: f32,
    /// Scale of its normal texture's x and y.
    pub coat_normal_scale: f32,
    /// How strongly highlights are stretched, 0 … 1.
    pub stretch: f32,
    /// Cosine and sine of what the direction of the stretch is turned by.
    pub stretch_turn: [f32; 2],
    /// How much of what is mirrored a thin film colours, 0 … 1.
    pub film: f32,
    /// The film's index of refraction, at least 1.
    pub film_ior: f32,
    /// Its thickness where its texture has 0 and 1.
    pub film_nanometers: [f32; 2],
    #[doc(hidden)]
    pub padding: [u32; 2],
}

impl ShadeLayers {
    /// Bit of another strength or colour of mirroring.
    pub const SPECULAR: u32 = 1;
    /// Bit of lacquer.
    pub const COAT: u32 = 2;
    /// Bit of fibres.
    pub const SHEEN: u32 = 4;
    /// Bit of stretched highlights.
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

/// A texture as a material uses it: 64 bytes. All zero where there is none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadeTexture {
    /// From the mesh's texture coordinates to the image's, (0, 0) being its upper left corner: two columns.
    pub matrix: [f32; 4],
    /// What is added then.
    pub translation: [f32; 2],
    /// Width and height of the full image.
    pub size: [u32; 2],
    /// What lies beyond the image's edges in x and in y: [`ShadeTexture::REPEAT`], [`ShadeTexture::MIRRORED_REPEAT`] or
    /// [`ShadeTexture::CLAMP_TO_EDGE`].
    pub wrap: [u32; 2],
    /// How many levels it has: the full image and its smaller copies; 0 where there is no texture.
    pub levels: u32,
    /// Where its list of levels is among the [`Texels`](super::Texels).
    pub levels_word: u32,
    /// Which set of texture coordinates: 0 or 1.
    pub tex_coord_set: u32,
    /// 1 where the nearest texel is read, 0 where the four nearest are mixed.
    pub is_nearest: u32,
    /// 1 for colours encoded by the sRGB transfer function, 0 for quantities.
    pub is_srgb: u32,
    #[doc(hidden)]
    pub padding: u32,
}

impl ShadeTexture {
    /// `wrap`: the image again.
    pub const REPEAT: u32 = 0;
    /// `wrap`: the image mirrored, then the image again.
    pub const MIRRORED_REPEAT: u32 = 1;
    /// `wrap`: the edge's texels.
    pub const CLAMP_TO_EDGE: u32 = 2;
}

/// How a film is developed: 28 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct DevelopSettings {
    /// What makes means of the film's sums: one over the number of samples.
    pub(crate) weight: f32,
    /// What the means are multiplied by.
    pub(crate) exposure: f32,
    /// [`DevelopSettings::NEUTRAL`] or [`DevelopSettings::CLIP`].
    pub(crate) tone_map: u32,
    /// Of the image in pixels.
    pub(crate) width: u32,
    /// Of the image in pixels.
    pub(crate) height: u32,
    /// From one row of the image to the next.
    pub(crate) row_pixels: u32,
    /// Where the film's plane of what is shown as it is starts, in pixels; [`DevelopSettings::NO_PLANE`] for none.
    pub(crate) flat_plane: u32,
}

impl DevelopSettings {
    /// `tone_map`: Khronos PBR Neutral.
    pub(crate) const NEUTRAL: u32 = 0;
    /// `tone_map`: everything above one is cut off.
    pub(crate) const CLIP: u32 = 1;
    /// `flat_plane`: nothing is shown as it is.
    pub(crate) const NO_PLANE: u32 = u32::MAX;
}
