use glam::Vec3;

use crate::ToneMap;

impl ToneMap {
    /// From linear radiance to linear display light; results lie in [0, 1] for radiance of zero or more.
    pub(crate) fn apply(self, radiance: Vec3) -> Vec3 {
        match self {
            Self::PbrNeutral => pbr_neutral(radiance),
            Self::Clip => radiance.clamp(Vec3::ZERO, Vec3::ONE),
        }
    }
}

/// The Khronos PBR Neutral tone mapper (Khronos Group, 2024).
fn pbr_neutral(radiance: Vec3) -> Vec3 {
    /// Reflectance at normal incidence that base colours are corrected for.
    const F0: f32 = 0.04;
    const START_COMPRESSION: f32 = 0.8 - F0;
    const DESATURATION: f32 = 0.15;

    let radiance = radiance.max(Vec3::ZERO);
    let least = radiance.min_element();
    let toe = if least < 2.0 * F0 { least - least * least / (4.0 * F0) } else { F0 };
    let color = radiance - toe;
    let peak = color.max_element();
    if peak < START_COMPRESSION {
        return color;
    }
    const RANGE: f32 = 1.0 - START_COMPRESSION;
    let new_peak = 1.0 - RANGE * RANGE / (peak + RANGE - START_COMPRESSION);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middle_colours_lose_only_the_reflectance_of_plastic() {
        let color = Vec3::new(0.5, 0.3, 0.2);
        assert!(pbr_neutral(color).distance(color - 0.04) < 1e-6);
    }

    #[test]
    fn brightness_rises_without_end_but_never_passes_one() {
        let shown: Vec<f32> = (0..200).map(|step| pbr_neutral(Vec3::splat(0.05 * 1.1_f32.powi(step))).x).collect();
        assert!(shown.is_sorted());
        assert!(shown.iter().all(|&value| value <= 1.0));
        assert!(shown[199] > 0.99);
    }

    #[test]
    fn very_bright_colours_turn_white() {
        let shown = pbr_neutral(Vec3::new(1000.0, 10.0, 10.0));
        assert!(shown.min_element() > 0.9, "{shown}");
    }
}
