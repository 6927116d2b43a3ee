//! The numbers of a material that an animation changes.

use glam::{Affine2, Mat2, Vec2, Vec3};
use gltf::json;
use umbrage_scene::{Alpha, Material, TextureUse};

use super::super::material::turn;
use super::{Moved, Target};

/// A number of a material, or a part of the transform of one of its textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum MaterialNumber {
    /// An index in [`NUMBERS`].
    Own(usize),
    /// An index in [`TEXTURES`].
    Texture(usize, Transform),
}

/// A part of `KHR_texture_transform`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum Transform {
    Offset,
    Rotation,
    Scale,
}

/// Sets a number from the components of a keyframe's value.
type Set = fn(&mut Material, &mut Emission, [f32; 4]);

/// Numbers that can be animated: their paths in a material of the JSON, and how many components they have.
const NUMBERS: &[(&str, usize, Set)] = &[
    ("pbrMetallicRoughness/baseColorFactor", 4, |to, _, color| to.base_color = color.into()),
    ("pbrMetallicRoughness/metallicFactor", 1, |to, _, [x, ..]| to.metallic = x),
    ("pbrMetallicRoughness/roughnessFactor", 1, |to, _, [x, ..]| to.roughness = x),
    ("emissiveFactor", 3, |to, emission, [r, g, b, _]| {
        emission.factor = Vec3::new(r, g, b);
        to.emissive = emission.product();
    }),
    ("extensions/KHR_materials_emissive_strength/emissiveStrength", 1, |to, emission, [x, ..]| {
        emission.strength = x;
        to.emissive = emission.product();
    }),
    ("alphaCutoff", 1, |to, _, [x, ..]| {
        if let Alpha::Mask { cutoff } = &mut to.alpha {
            *cutoff = x;
        }
    }),
    ("normalTexture/scale", 1, |to, _, [x, ..]| to.normal_scale = x),
    ("occlusionTexture/strength", 1, |to, _, [x, ..]| to.occlusion_strength = x),
    ("extensions/KHR_materials_ior/ior", 1, |to, _, [x, ..]| to.ior = x),
    ("extensions/KHR_materials_dispersion/dispersion", 1, |to, _, [x, ..]| to.dispersion = x),
    ("extensions/KHR_materials_transmission/transmissionFactor", 1, |to, _, [x, ..]| to.transmission = x),
    ("extensions/KHR_materials_volume/thicknessFactor", 1, |to, _, [x, ..]| to.volume.thickness = x),
    ("extensions/KHR_materials_volume/attenuationDistance", 1, |to, _, [x, ..]| {
        // As at rest: zero would take all light away.
        to.volume.attenuation_distance = if x > 0.0 { x } else { f32::INFINITY };
    }),
    ("extensions/KHR_materials_volume/attenuationColor", 3, |to, _, [r, g, b, _]| {
        to.volume.attenuation_color = Vec3::new(r, g, b);
    }),
];

/// Finds one of a material's textures.
type Find = fn(&mut Material) -> &mut Option<TextureUse>;

/// Textures whose transforms can be animated, by their paths in a material of the JSON.
const TEXTURES: &[(&str, Find)] = &[
    ("pbrMetallicRoughness/baseColorTexture", |of| &mut of.base_color_texture),
    ("pbrMetallicRoughness/metallicRoughnessTexture", |of| &mut of.metallic_roughness_texture),
    ("normalTexture", |of| &mut of.normal_texture),
    ("occlusionTexture", |of| &mut of.occlusion_texture),
    ("emissiveTexture", |of| &mut of.emissive_texture),
];

impl MaterialNumber {
    /// The number at a path in a material of the JSON; `None` for paths that can't be animated.
    pub(super) fn of(path: &str) -> Option<Self> {
        if let Some(number) = NUMBERS.iter().position(|(known, ..)| *known == path) {
            return Some(Self::Own(number));
        }
        let (texture, name) = path.split_once("/extensions/KHR_texture_transform/")?;
        let texture = TEXTURES.iter().position(|(known, _)| *known == texture)?;
        let transform = match name {
            "offset" => Transform::Offset,
            "rotation" => Transform::Rotation,
            "scale" => Transform::Scale,
            _ => return None,
        };
        Some(Self::Texture(texture, transform))
    }

    /// Number of components.
    pub(super) fn components(self) -> usize {
        match self {
            Self::Own(number) => NUMBERS[number].1,
            Self::Texture(_, Transform::Offset | Transform::Scale) => 2,
            Self::Texture(_, Transform::Rotation) => 1,
        }
    }
}

/// A material's emission: the two factors of [`Material::emissive`].
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

    fn product(self) -> Vec3 {
        (self.factor * self.strength).min(Vec3::MAX)
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
    let mut value = [0.0; 4];
    for moved in all {
        let Target::Material(of, what) = moved.target else { continue };
        if of != number {
            continue;
        }
        moved.curve.sample(seconds, &mut value[..moved.curve.width]);
        match what {
            MaterialNumber::Own(number) => NUMBERS[number].2(material, &mut emission, value),
            MaterialNumber::Texture(texture, transform) => {
                if let Some(used) = TEXTURES[texture].1(material) {
                    used.image_from_mesh = transform.changed(used.image_from_mesh, Vec2::new(value[0], value[1]));
                }
            }
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
    use umbrage_scene::Volume;

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
    fn each_path_changes_its_own_number() {
        let rest = || Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..Material::default() };
        let in_volume = |volume: Volume| Material { volume, ..rest() };
        let value @ [x, r, g, _] = [0.125, 0.25, 0.75, 0.625];
        let color = Vec3::new(x, r, g);
        let expected = [
            Material { base_color: value.into(), ..rest() },
            Material { metallic: x, ..rest() },
            Material { roughness: x, ..rest() },
            Material { emissive: 2.0 * color, ..rest() },
            Material { emissive: Vec3::splat(3.0 * x), ..rest() },
            Material { alpha: Alpha::Mask { cutoff: x }, ..rest() },
            Material { normal_scale: x, ..rest() },
            Material { occlusion_strength: x, ..rest() },
            Material { ior: x, ..rest() },
            Material { dispersion: x, ..rest() },
            Material { transmission: x, ..rest() },
            in_volume(Volume { thickness: x, ..Volume::default() }),
            in_volume(Volume { attenuation_distance: x, ..Volume::default() }),
            in_volume(Volume { attenuation_color: color, ..Volume::default() }),
        ];
        assert_eq!(expected.len(), NUMBERS.len());
        for ((path, _, set), expected) in NUMBERS.iter().zip(expected) {
            let (mut material, mut emission) = (rest(), Emission { factor: Vec3::splat(3.0), strength: 2.0 });
            set(&mut material, &mut emission, value);
            assert_eq!(material, expected, "{path}");
        }
    }

    #[test]
    fn paths_are_understood() {
        for (number, &(path, components, _)) in NUMBERS.iter().enumerate() {
            assert_eq!(MaterialNumber::of(path), Some(MaterialNumber::Own(number)));
            assert_eq!(MaterialNumber::Own(number).components(), components);
        }
        let offset =
            MaterialNumber::of("pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset");
        assert_eq!(offset, Some(MaterialNumber::Texture(0, Transform::Offset)));
        assert_eq!(offset.map(MaterialNumber::components), Some(2));
        assert_eq!(MaterialNumber::of("extensions/KHR_materials_sheen/sheenColorFactor"), None);
    }
}
