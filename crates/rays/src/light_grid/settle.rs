use crate::dispatch;
use fearless_simd::Simd;
use rayon::prelude::*;

use super::face::HALF_ULP;
use super::point_set::PointSet;
use super::settle_eight::{Settled, settle_eight};
use crate::LightSource;
use crate::predicate::settle;
use crate::shot::{CameraRays, MaskPoints, Opacity, OpacityOfSides, SeenImage, TileOrder};
use crate::simd::SimdLevel;

/// Settles the filter's undecided pairs: in f64, and by the predicate where f64 can't tell either.
pub struct Settler<'a> {
    pub points: PointSet<'a>,
    pub light: &'a LightSource,
    /// The triangles' opacity for this light.
    pub opacity: OpacityOfSides<'a>,
    pub(crate) level: SimdLevel,
}

impl<'a> Settler<'a> {
    /// A settler for the points that an image's pixels show.
    pub fn of_image(image: SeenImage<'a>, rays: CameraRays, light: &'a LightSource, level: SimdLevel) -> Self {
        let opacity = OpacityOfSides::of_light(image.shot, light);
        Self { points: PointSet::Seen(image, rays), light, opacity, level }
    }

    /// Whether the triangle stops the ray of the point in `lane`; `None` if that depends on roundings.
    fn stops(&self, id: u32, eight: &Settled, lane: usize) -> Option<bool> {
        let opacity = &self.opacity;
        if opacity.is_opaque(id) {
            return Some(true);
        }
        let [mut second, mut third, mut error] = [[0.0; 16]; 3];
        let weights = eight.barycentric.map(|weights| weights[lane]);
        (second[0], third[0]) = (weights[0] as f32, weights[1] as f32);
        // Here and in the predicate, rounding a weight of at most one to f32 adds half of this, and the f64 before it the
        // rest.
        error[0] = eight.weight_error[lane] as f32 + 1.01 * HALF_ULP as f32;
        let answers = opacity.which_stop(id, &MaskPoints { barycentric: [second, third], error, lanes: 1 });
        if answers.opaque | answers.cut == 0 { None } else { Some(answers.opaque != 0) }
    }

    /// Settles pairs of a point's index and a triangle, and sets the bits of shadowed points in `shadowed`, which has a word
    /// for each block from that of pixel `first` on; returns how many pairs the predicate was asked about.
    pub fn settle(&self, pairs: &[[u32; 2]], first: usize, shadowed: &mut [u16]) -> u64 {
        dispatch!(self.level, simd => self.settle_with(simd, pairs, first, shadowed))
    }

    #[inline(always)]
    fn settle_with<S: Simd>(&self, simd: S, pairs: &[[u32; 2]], first: usize, shadowed: &mut [u16]) -> u64 {
        let mut settled = 0;
        let mut shadows = settle::Shadows::new(&self.opacity);
        for pairs in pairs.chunks(8) {
            let mut padded = [[u32::MAX; 2]; 8];
            padded[..pairs.len()].copy_from_slice(pairs);
            let (indices, ids) = (padded.map(|[index, _]| index), padded.map(|[_, id]| id));
            let eight = settle_eight(simd, self.opacity.triangles, &self.points, self.light, indices, ids);
            for (lane, &[index, id]) in pairs.iter().enumerate() {
                let slot = index as usize - first;
                let (word, bit) = (slot / TileOrder::BLOCK_PIXELS, slot % TileOrder::BLOCK_PIXELS);
                if shadowed[word] >> bit & 1 == 1 {
                    continue;
                }
                let certain = if eight.shadowed >> lane & 1 == 1 {
                    self.stops(id, &eight, lane)
                } else {
                    (eight.undecided >> lane & 1 == 0).then_some(false)
                };
                let is_shadowed = certain.unwrap_or_else(|| {
                    settled += 1;
                    shadows.is_shadowed_by(index as usize, id, || self.points.shadow_ray(index as usize, self.light))
                });
                shadowed[word] |= u16::from(is_shadowed) << bit;
            }
        }
        settled
    }

    /// Tests the points that no face could map against every triangle; returns how many there are.
    pub fn settle_outliers(&self, outliers: &mut Vec<u32>, shadowed: &mut [u16]) -> u64 {
        let Self { points, light, opacity, .. } = self;
        outliers.sort_unstable();
        outliers.dedup();
        let count = opacity.triangles.len() as u32;
        for index in outliers.iter().map(|&index| index as usize) {
            let Some(ray) = points.shadow_ray(index, light) else { continue };
            let own = points.own()[index];
            let triangles = (0..count).into_par_iter().with_min_len(1024);
            if triangles.filter(|&id| id != own).any(|id| settle::is_blocked(opacity, &ray, id)) {
                shadowed[index / TileOrder::BLOCK_PIXELS] |= 1 << (index % TileOrder::BLOCK_PIXELS);
            }
        }
        outliers.len() as u64
    }
}

#[cfg(test)]
mod tests;
