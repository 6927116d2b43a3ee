use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

use super::face::HALF_ULP;
use super::filter::{Verdicts, decide_eight};
use super::{LightGrid, SimdLevel};
use crate::LightSource;
use crate::predicate::settle;
use crate::shot::{CameraRays, MaskPoints, SeenImage, SeenPixels, TileOrder};

/// Decides what the fast test couldn't: in f64, and what that can't either by asking the predicate.
///
/// Callbacks are called through references, so that the tests are compiled once and not wherever they are used.
pub(crate) struct Judge<'a> {
    pub(crate) image: SeenImage<'a>,
    pub(crate) rays: CameraRays,
    pub(crate) light: &'a LightSource,
    pub(crate) level: SimdLevel,
}

impl Judge<'_> {
    /// What the mask says about the point of a triangle in `lane`; `None` if that depends on roundings.
    fn casts(&self, id: u32, verdicts: &Verdicts, lane: usize) -> Option<bool> {
        if self.image.shot.shadow_opacity.is_opaque(id) {
            return Some(true);
        }
        let [mut second, mut third, mut error] = [[0.0; 16]; 3];
        let weights = verdicts.barycentric.map(|weights| weights[lane]);
        (second[0], third[0]) = (weights[0] as f32, weights[1] as f32);
        // Both are rounded to f32, here and by the predicate.
        error[0] = verdicts.weight_error[lane] as f32 + 4.0 * HALF_ULP as f32;
        let answers = self
            .image
            .shot
            .shadow_opacity
            .which_stop(id, &MaskPoints { barycentric: [second, third], error, lanes: 1 });
        if answers.opaque | answers.cut == 0 { None } else { Some(answers.opaque != 0) }
    }

    /// Decides pairs of a place and a triangle, and notes in `shadowed`, which has a word for each block, which points
    /// are in shadow; how many pairs the predicate was asked about.
    pub(crate) fn settle(&self, pairs: &[[u32; 2]], shadowed: &mut [u16]) -> u64 {
        dispatch!(self.level.0, simd => self.settle_with(simd, pairs, shadowed))
    }

    #[inline(always)]
    fn settle_with<S: Simd>(&self, simd: S, pairs: &[[u32; 2]], shadowed: &mut [u16]) -> u64 {
        let mut settled = 0;
        let mut shadows = settle::Shadows::new(self.image, self.light);
        for eight in pairs.chunks(8) {
            let mut padded = [[u32::MAX; 2]; 8];
            padded[..eight.len()].copy_from_slice(eight);
            let (places, ids) = (padded.map(|[place, _]| place), padded.map(|[_, id]| id));
            let verdicts = decide_eight(simd, &self.image, &self.rays, self.light, places, ids);
            for (lane, &[place, id]) in eight.iter().enumerate() {
                let (word, bit) = (place as usize / TileOrder::BLOCK_PIXELS, place as usize % TileOrder::BLOCK_PIXELS);
                if shadowed[word] >> bit & 1 == 1 {
                    continue;
                }
                let verdict = if verdicts.shadowed >> lane & 1 == 1 {
                    self.casts(id, &verdicts, lane)
                } else {
                    (verdicts.unknown >> lane & 1 == 0).then_some(false)
                };
                let is_shadowed = verdict.unwrap_or_else(|| {
                    settled += 1;
                    shadows.is_shadowed_by(place as usize, id)
                });
                shadowed[word] |= u16::from(is_shadowed) << bit;
            }
        }
        settled
    }
}

impl LightGrid {
    /// Decides what the threads couldn't, in equal parts.
    pub(crate) fn settle(&mut self, judge: &Judge<'_>) {
        let Self { workers, undecided, counts, .. } = self;
        undecided.clear();
        workers.iter_mut().for_each(|worker| undecided.append(&mut worker.undecided));
        let share = undecided.len().div_ceil(workers.len()).max(8);
        let shares = workers.par_iter_mut().zip(undecided.par_chunks(share));
        counts.settled += shares.map(|(worker, pairs)| judge.settle(pairs, &mut worker.shadowed)).sum::<u64>();
    }

    /// Tests the points that no face could map against every triangle.
    pub(crate) fn settle_outliers(&mut self, judge: &Judge<'_>) {
        let Self { outliers, survey, shadowed, counts, .. } = self;
        outliers.extend_from_slice(&survey.unknown);
        outliers.sort_unstable();
        outliers.dedup();
        counts.outliers = outliers.len() as u64;
        let SeenImage { shot, seen } = judge.image;
        let count = shot.triangles.len() as u32;
        for &place in &*outliers {
            let Some(ray) = shot.shadow_ray(seen, place as usize, judge.light) else { continue };
            let own = seen.triangle[place as usize];
            let triangles = (0..count).into_par_iter().with_min_len(1024);
            if triangles.filter(|&id| id != own).any(|id| settle::is_blocked(shot, &ray, id)) {
                shadowed[place as usize / TileOrder::BLOCK_PIXELS] |= 1 << (place as usize % TileOrder::BLOCK_PIXELS);
            }
        }
    }

    /// Brings together which points the threads found in shadow on a face.
    pub(crate) fn merge_shadows(&mut self) {
        let Self { workers, shadowed, members, .. } = self;
        const CHUNK: usize = 4096;
        let chunks = shadowed.par_chunks_mut(CHUNK).zip(members.par_chunks(CHUNK)).enumerate();
        chunks.for_each(|(chunk, (shadowed, members))| {
            for worker in workers.iter() {
                let found = &worker.shadowed[chunk * CHUNK..][..shadowed.len()];
                shadowed.iter_mut().zip(found).zip(members).for_each(|((all, found), members)| *all |= found & members);
            }
        });
    }

    /// The bits of the pixels that show a lit point.
    pub(crate) fn light_the_rest(&self, seen: &SeenPixels, lit: &mut [u16]) {
        const CHUNK: usize = 1024;
        let words = lit.par_chunks_mut(CHUNK).zip(self.shadowed.par_chunks(CHUNK)).enumerate();
        words.for_each(|(chunk, (lit, shadowed))| {
            let pixels = &seen.triangle[chunk * CHUNK * TileOrder::BLOCK_PIXELS..];
            let blocks = pixels.chunks_exact(TileOrder::BLOCK_PIXELS);
            for ((lit, shadowed), block) in lit.iter_mut().zip(shadowed).zip(blocks) {
                let points = SeenPixels::shown_of(block);
                *lit = points & !shadowed;
            }
        });
    }
}
