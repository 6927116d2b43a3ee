//! Light at smooth surfaces between two media, and inside of the media.

use glam::{DVec3, Vec3};
use umbrage_scene::Material;

/// The reflectance, 0 to 1, of a smooth surface for unpolarised light with this `cosine` to its normal, from a medium whose
/// index of refraction is `ratio` times that of the medium behind it: Fresnel's equations. It is 1 beyond the critical
/// angle.
pub(crate) fn reflected_part(cosine: f64, ratio: f64) -> f64 {
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    // An infinite index gives NaN.
    if behind.is_nan() || behind <= 0.0 {
        return 1.0;
    }
    let behind = behind.sqrt();
    let across = (ratio * cosine - behind) / (ratio * cosine + behind);
    let along = (cosine - ratio * behind) / (cosine + ratio * behind);
    (0.5 * (across * across + along * along)).clamp(0.0, 1.0)
}

/// The unit direction of light behind such a surface, by Snell's law, for a unit `direction` that meets it. The unit
/// `normal` is on the side that the light comes from. `None` beyond the critical angle.
pub(crate) fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let refracted = direction * ratio + normal * (ratio * cosine - behind.max(0.0).sqrt());
    (behind > 0.0).then(|| refracted.normalize())
}

/// The materials that a ray is inside of, the last entered last. Beyond `MOST`, the first is forgotten.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Media {
    materials: [u32; Media::MOST],
    count: u8,
}

impl Media {
    const MOST: usize = 4;

    /// Whether the ray is in the open.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The material around the ray; `None` in the open.
    pub(crate) fn innermost(&self) -> Option<u32> {
        self.materials[..usize::from(self.count)].last().copied()
    }

    /// The media after the ray crosses a surface of this material, from its front to its back or the other way.
    pub(crate) fn across(mut self, material: u32, from_front: bool) -> Self {
        let all = &mut self.materials[..usize::from(self.count)];
        if from_front {
            if all.len() == Self::MOST {
                all.copy_within(1.., 0);
                self.count -= 1;
            }
            self.materials[usize::from(self.count)] = material;
            self.count += 1;
        } else if let Some(entered) = all.iter().rposition(|&entered| entered == material) {
            all.copy_within(entered + 1.., entered);
            self.count -= 1;
        }
        self
    }

    /// Whether a surface of this material separates colours.
    pub(crate) fn disperse(&self, material: u32, materials: &[Material]) -> bool {
        let disperses = |material: u32| materials[material as usize].dispersion != 0.0;
        disperses(material) || self.innermost().is_some_and(disperses)
    }

    /// The ratio of the indices of refraction before and behind a surface of this material, for a ray in these media and
    /// red, green or blue light, as −1, 0 and 1. glTF has 0 for an infinite index: then nothing is refracted.
    pub(crate) fn ratio(&self, material: u32, from_front: bool, materials: &[Material], color: f64) -> f64 {
        let index_of = |material: u32| index_of(&materials[material as usize], color);
        let index = |media: &Self| media.innermost().map_or(1.0, index_of);
        let own = index_of(material);
        let [before, behind] =
            if from_front { [index(self), own] } else { [own, index(&self.across(material, false))] };
        if before > 0.0 && behind > 0.0 { before / behind } else { f64::INFINITY }
    }
}

/// The index of refraction of red, green or blue light, as −1, 0 and 1, as `KHR_materials_dispersion` has it.
fn index_of(material: &Material, color: f64) -> f64 {
    let ior = f64::from(material.ior);
    ior + (ior - 1.0) * 0.025 * f64::from(material.dispersion) * color
}

/// The transmittance of a `distance` in a material: Beer and Lambert's law, for the material's transmittance over its
/// attenuation distance.
pub(crate) fn attenuation(material: &Material, distance: f32) -> Vec3 {
    let volume = &material.volume;
    if volume.attenuation_color == Vec3::ONE || !volume.attenuation_distance.is_finite() {
        return Vec3::ONE;
    }
    let part = distance.max(0.0) / volume.attenuation_distance;
    // The same on all machines.
    volume.attenuation_color.max(Vec3::ZERO).map(|left| libm::powf(left, part)).min(Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use umbrage_scene::Volume;

    use super::*;

    #[test]
    fn glass_reflects_a_twenty_fifth_and_all_beyond_its_critical_angle() {
        assert!((reflected_part(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-12);
        assert!((reflected_part(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert_eq!(reflected_part(0.0, 1.0 / 1.5), 1.0);
        let critical = (1.0_f64 / 1.5).asin();
        assert!((critical.to_degrees() - 41.81).abs() < 0.01);
        for (degrees, is_total) in [(41.7_f64, false), (41.9, true)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            assert_eq!(reflected_part(cos, 1.5) == 1.0, is_total, "{degrees}");
            assert_eq!(refracted(DVec3::new(sin, 0.0, -cos), DVec3::Z, 1.5).is_none(), is_total, "{degrees}");
        }
    }

    #[test]
    fn what_is_polarised_along_the_surface_is_not_reflected_at_brewsters_angle() {
        let brewster = 1.5_f64.atan();
        let behind = (brewster.sin() / 1.5).asin();
        let across = (brewster - behind).sin() / (brewster + behind).sin();
        assert!((reflected_part(brewster.cos(), 1.0 / 1.5) - 0.5 * across * across).abs() < 1e-12);
    }

    #[test]
    fn sines_are_in_the_ratio_of_the_indices() {
        for degrees in [0.0_f64, 10.0, 45.0, 89.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let behind = refracted(DVec3::new(sin, 0.0, -cos), DVec3::Z, 1.0 / 1.33).expect("into the denser medium");
            assert!((behind.x * 1.33 - sin).abs() < 1e-12 && behind.z < 0.0 && behind.is_normalized(), "{behind}");
            let back = refracted(-behind, DVec3::NEG_Z, 1.33).expect("the way back");
            assert!(back.abs_diff_eq(DVec3::new(-sin, 0.0, cos), 1e-9), "{back}");
        }
    }

    #[test]
    fn media_are_left_in_any_order() {
        let inside = Media::default().across(7, true).across(3, true);
        assert_eq!(inside.innermost(), Some(3));
        assert_eq!(inside.across(7, false).innermost(), Some(3));
        assert_eq!(inside.across(3, false).innermost(), Some(7));
        assert!(inside.across(3, false).across(7, false).is_empty() && Media::default().across(9, false).is_empty());
        let deep = (0..9).fold(Media::default(), |media, material| media.across(material, true));
        let out = (6..9).rev().fold(deep, |media, material| media.across(material, false));
        assert_eq!((deep.innermost(), out.innermost()), (Some(8), Some(5)));
    }

    #[test]
    fn indices_are_those_on_both_sides() {
        let of_index = |ior: f32| Material { ior, ..Material::default() };
        let materials = [of_index(1.5), of_index(1.25), of_index(0.0)];
        let open = Media::default();
        let inside = open.across(0, true);
        assert_eq!(open.ratio(0, true, &materials, 0.0), 1.0 / 1.5);
        assert_eq!(inside.ratio(0, false, &materials, 0.0), 1.5);
        assert_eq!(inside.ratio(1, true, &materials, 0.0), 1.5 / 1.25);
        assert_eq!(inside.across(1, true).ratio(1, false, &materials, 0.0), 1.25 / 1.5);
        assert_eq!(reflected_part(0.7, open.ratio(2, true, &materials, 0.0)), 1.0);
    }

    #[test]
    fn blue_is_refracted_more_than_red() {
        // Abbe's number 40: the lines F and C, somewhat beyond visible blue and red, are 0.5 / 40 apart.
        let flint = Material { ior: 1.5, dispersion: 0.5, ..Material::default() };
        assert!((index_of(&flint, 1.0) - index_of(&flint, -1.0) - 0.0125).abs() < 1e-12);
        assert_eq!(index_of(&flint, 0.0), 1.5);
        let materials = [flint, Material::default()];
        assert!(Media::default().disperse(0, &materials) && !Media::default().disperse(1, &materials));
        assert!(Media::default().across(0, true).disperse(1, &materials));
    }

    #[test]
    fn colours_are_left_as_the_material_says() {
        let volume = Volume {
            thickness: 1.0,
            attenuation_distance: 2.0,
            attenuation_color: Vec3::new(0.25, 1.0, 0.0),
            ..Volume::default()
        };
        let stained = Material { volume, ..Material::default() };
        for (distance, left) in [(0.0, Vec3::ONE), (1.0, Vec3::new(0.5, 1.0, 0.0)), (4.0, Vec3::new(0.0625, 1.0, 0.0))]
        {
            assert!(attenuation(&stained, distance).abs_diff_eq(left, 1e-6), "{distance}");
        }
        assert_eq!(attenuation(&Material::default(), 1e9), Vec3::ONE);
    }
}
