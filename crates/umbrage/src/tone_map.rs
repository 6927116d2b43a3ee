use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

use crate::ToneMap;
use crate::shade::lanes::{BRIGHTEST, Vectors};
use crate::shade::transcendental::power;

impl ToneMap {
    /// Maps linear radiance to linear display light, in [0, 1]; NaN becomes zero.
    #[inline(always)]
    pub(crate) fn apply<S: Simd>(self, simd: S, Vectors { x, y, z }: Vectors<S>) -> Vectors<S> {
        let bounded = |radiance: f32x16<S>| radiance.max_precise(0.0).min_precise(BRIGHTEST);
        let radiance = Vectors { x: bounded(x), y: bounded(y), z: bounded(z) };
        match self {
            Self::PbrNeutral => pbr_neutral(simd, radiance).at_most_one(),
            Self::Clip => radiance.at_most_one(),
        }
    }
}

/// The Khronos PBR Neutral tone mapper (Khronos Group, 2024), of radiance of zero or more.
#[inline(always)]
fn pbr_neutral<S: Simd>(simd: S, radiance: Vectors<S>) -> Vectors<S> {
    /// Reflectance at normal incidence that base colours are corrected for.
    const F0: f32 = 0.04;
    const START_COMPRESSION: f32 = 0.8 - F0;
    const DESATURATION: f32 = 0.15;
    const RANGE: f32 = 1.0 - START_COMPRESSION;

    let least = radiance.x.min(radiance.y).min(radiance.z).min(2.0 * F0);
    let toe = least - least * least / (4.0 * F0);
    let color = radiance.raised(-toe);
    let peak = color.largest();
    let is_compressed = peak.simd_ge(START_COMPRESSION);
    if !is_compressed.any_true() {
        return color;
    }
    let new_peak = 1.0 - RANGE * RANGE / (peak + (RANGE - START_COMPRESSION));
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    let one = Vectors::splat(simd, Vec3::ONE);
    let compressed = color.scaled(new_peak / peak).lerp(one.scaled(new_peak), white);
    Vectors::select(is_compressed, compressed, color)
}

/// The sRGB transfer function (IEC 61966-2-1), from [0, 1] to [0, 1], with an error of about 2⁻²¹.
#[inline(always)]
pub(crate) fn encoded_srgb<S: Simd>(simd: S, linear: f32x16<S>) -> f32x16<S> {
    let curved = 1.055 * power(linear, f32x16::splat(simd, 1.0 / 2.4)) - 0.055;
    linear.simd_le(0.003_130_8).select(12.92 * linear, curved).min(1.0)
}

#[cfg(test)]
mod tests {
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;
    use crate::shade::lanes::{Each, vector_of};

    fn pbr_neutral(radiance: Vec3) -> Vec3 {
        let shown: [Each<f32>; 3] = dispatch!(SimdLevel::default(), simd => {
            ToneMap::PbrNeutral.apply(simd, Vectors::splat(simd, radiance)).store()
        });
        vector_of(0, &shown)
    }

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
        for bright in [1000.0, f32::MAX, f32::INFINITY] {
            let shown = pbr_neutral(Vec3::new(bright, 10.0, 10.0));
            assert!(shown.min_element() > 0.9, "{shown}");
        }
    }
}
