//! The numbers of a material that an animation changes.

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use gltf::json;
use umbrage_scene::{Alpha, Material, TextureUse};

use super::super::material::turn;
use super::{Moved, Target};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum MaterialNumber {
    BaseColor,
    Metallic,
    Roughness,
    EmissiveFactor,
    EmissiveStrength,
    AlphaCutoff,
    NormalScale,
    OcclusionStrength,
    Ior,
    Dispersion,
    Transmission,
    Thickness,
    AttenuationDistance,
    AttenuationColor,
    Texture(TextureSlot, Transform),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum TextureSlot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Occlusion,
    Emissive,
}

/// A part of `KHR_texture_transform`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum Transform {
    Offset,
    Rotation,
    Scale,
}

/// Numbers that can be animated, by their paths in a material of the JSON.
const NUMBERS: &[(&str, MaterialNumber)] = &[
    ("pbrMetallicRoughness/baseColorFactor", MaterialNumber::BaseColor),
    ("pbrMetallicRoughness/metallicFactor", MaterialNumber::Metallic),
    ("pbrMetallicRoughness/roughnessFactor", MaterialNumber::Roughness),
    ("emissiveFactor", MaterialNumber::EmissiveFactor),
    ("extensions/KHR_materials_emissive_strength/emissiveStrength", MaterialNumber::EmissiveStrength),
    ("alphaCutoff", MaterialNumber::AlphaCutoff),
    ("normalTexture/scale", MaterialNumber::NormalScale),
    ("occlusionTexture/strength", MaterialNumber::OcclusionStrength),
    ("extensions/KHR_materials_ior/ior", MaterialNumber::Ior),
    ("extensions/KHR_materials_dispersion/dispersion", MaterialNumber::Dispersion),
    ("extensions/KHR_materials_transmission/transmissionFactor", MaterialNumber::Transmission),
    ("extensions/KHR_materials_volume/thicknessFactor", MaterialNumber::Thickness),
    ("extensions/KHR_materials_volume/attenuationDistance", MaterialNumber::AttenuationDistance),
    ("extensions/KHR_materials_volume/attenuationColor", MaterialNumber::AttenuationColor),
];

const TEXTURES: &[(&str, TextureSlot)] = &[
    ("pbrMetallicRoughness/baseColorTexture", TextureSlot::BaseColor),
    ("pbrMetallicRoughness/metallicRoughnessTexture", TextureSlot::MetallicRoughness),
    ("normalTexture", TextureSlot::Normal),
    ("occlusionTexture", TextureSlot::Occlusion),
    ("emissiveTexture", TextureSlot::Emissive),
];

impl MaterialNumber {
    /// The number at a path in a material of the JSON; `None` for paths that can't be animated.
    pub(super) fn of(path: &str) -> Option<Self> {
        if let Some((_, number)) = NUMBERS.iter().find(|(known, _)| *known == path) {
            return Some(*number);
        }
        let (texture, name) = path.split_once("/extensions/KHR_texture_transform/")?;
        let (_, slot) = TEXTURES.iter().find(|(known, _)| *known == texture)?;
        let transform = match name {
            "offset" => Transform::Offset,
            "rotation" => Transform::Rotation,
            "scale" => Transform::Scale,
            _ => return None,
        };
        Some(Self::Texture(*slot, transform))
    }

    /// Number of components.
    pub(super) fn components(self) -> usize {
        match self {
            Self::BaseColor => 4,
            Self::EmissiveFactor | Self::AttenuationColor => 3,
            Self::Texture(_, Transform::Offset | Transform::Scale) => 2,
            _ => 1,
        }
    }
}

/// A material's emission at rest: the two factors of [`Material::emissive`].
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Emission {
    factor: Vec3,
    strength: f32,
}

impl Emission {
    pub(in super::super) fn of(json: &json::Material) -> Self {
        let extensions = json.extensions.as_ref();
        let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
        Self {
            factor: json.emissive_factor.0.into(),
            strength: strength.map_or(1.0, |strength| strength.emissive_strength.0),
        }
    }
}

/// Changes `material`, which is number `number` of the file and whose emission at rest is `emission`.
pub(in super::super) fn change(
    all: &[Moved],
    number: usize,
    seconds: f64,
    mut emission: Emission,
    material: &mut Material,
) {
    let (mut value, mut glows) = ([0.0; 4], false);
    for moved in all {
        let Target::Material(of, what) = moved.target else { continue };
        if of != number {
            continue;
        }
        moved.curve.sample(seconds, &mut value[..moved.curve.width]);
        let color = Vec4::from_array(value).truncate();
        let [first, second, ..] = value;
        match what {
            MaterialNumber::EmissiveFactor => (emission.factor, glows) = (color, true),
            MaterialNumber::EmissiveStrength => (emission.strength, glows) = (first, true),
            MaterialNumber::BaseColor => material.base_color = value.into(),
            MaterialNumber::Metallic => material.metallic = first,
            MaterialNumber::Roughness => material.roughness = first,
            MaterialNumber::AlphaCutoff => {
                if let Alpha::Mask { cutoff } = &mut material.alpha {
                    *cutoff = first;
                }
            }
            MaterialNumber::NormalScale => material.normal_scale = first,
            MaterialNumber::OcclusionStrength => material.occlusion_strength = first,
            MaterialNumber::Ior => material.ior = first,
            MaterialNumber::Dispersion => material.dispersion = first,
            MaterialNumber::Transmission => material.transmission = first,
            MaterialNumber::Thickness => material.volume.thickness = first,
            MaterialNumber::AttenuationDistance => {
                // As at rest: zero would take all light away.
                material.volume.attenuation_distance = if first > 0.0 { first } else { f32::INFINITY };
            }
            MaterialNumber::AttenuationColor => material.volume.attenuation_color = color,
            MaterialNumber::Texture(slot, transform) => {
                if let Some(used) = slot.of(material) {
                    used.image_from_mesh = transform.changed(used.image_from_mesh, Vec2::new(first, second));
                }
            }
        }
    }
    if glows {
        material.emissive = (emission.factor * emission.strength).min(Vec3::MAX);
    }
}

impl TextureSlot {
    fn of(self, material: &mut Material) -> Option<&mut TextureUse> {
        match self {
            Self::BaseColor => material.base_color_texture.as_mut(),
            Self::MetallicRoughness => material.metallic_roughness_texture.as_mut(),
            Self::Normal => material.normal_texture.as_mut(),
            Self::Occlusion => material.occlusion_texture.as_mut(),
            Self::Emissive => material.emissive_texture.as_mut(),
        }
    }
}

impl Transform {
    /// Replaces one part of the transform. A rotation is `value.x`, counter-clockwise on an image whose y goes down.
    fn changed(self, from: Affine2, value: Vec2) -> Affine2 {
        let (x_axis, y_axis) = (from.matrix2.x_axis, from.matrix2.y_axis);
        let (mut angle, mut scale) = (libm::atan2f(x_axis.y, x_axis.x), Vec2::new(x_axis.length(), y_axis.length()));
        // A mirrored image keeps its first axis.
        scale.y = scale.y.copysign(x_axis.perp_dot(y_axis));
        let mut offset = from.translation;
        match self {
            Self::Offset => offset = value,
            Self::Rotation => angle = -value.x,
            Self::Scale => scale = value,
        }
        Affine2::from_mat2_translation(turn(angle) * Mat2::from_diagonal(scale), offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_transform_are_changed_alone() {
        let affine = |offset: Vec2, rotation: f32, scale: Vec2| {
            let linear = Mat2::from_angle(-rotation) * Mat2::from_diagonal(scale);
            Affine2::from_mat2_translation(linear, offset)
        };
        let (offset, scale) = (Vec2::new(0.25, -3.0), Vec2::new(2.0, -0.5));
        let from = affine(offset, 0.7, scale);
        let new = Vec2::new(0.5, 1.5);
        for (transform, expected) in [
            (Transform::Offset, affine(new, 0.7, scale)),
            (Transform::Rotation, affine(offset, 0.5, scale)),
            (Transform::Scale, affine(offset, 0.7, new)),
        ] {
            assert!(transform.changed(from, new).abs_diff_eq(expected, 1e-6), "{transform:?}");
        }
    }

    #[test]
    fn paths_are_understood() {
        assert_eq!(MaterialNumber::of("emissiveFactor"), Some(MaterialNumber::EmissiveFactor));
        let offset =
            MaterialNumber::of("pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset");
        assert_eq!(offset, Some(MaterialNumber::Texture(TextureSlot::BaseColor, Transform::Offset)));
        assert_eq!(offset.map(MaterialNumber::components), Some(2));
        assert_eq!(MaterialNumber::of("extensions/KHR_materials_sheen/sheenColorFactor"), None);
    }
}
