use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::block::Block;
use super::{LightGrid, SeenImage};
use crate::grid::TileOrder;
use crate::predicate::{HitPoint, ShadowRay, crossing};
use crate::{LightSource, Ray};

impl SeenImage<'_> {
    /// The ray through the pixel at a place.
    pub(super) fn camera_ray(&self, pixel: usize) -> Ray {
        let (x, y) = self.seen.order().column_and_row(pixel);
        let (x, y) = (f64::from(x), f64::from(y));
        self.view.ray(x + self.offset_pixels.x, y + self.offset_pixels.y)
    }
}

/// Asks the predicate.
pub(super) struct Judge<'a, O, C> {
    pub(super) image: &'a SeenImage<'a>,
    pub(super) light: &'a LightSource,
    pub(super) is_opaque: O,
    pub(super) casts: C,
}

impl<O: Fn(u32) -> bool + Sync, C: Fn(u32, [f32; 2]) -> bool + Sync> Judge<'_, O, C> {
    /// The segment between the light and a pixel's point.
    fn shadow_ray(&self, pixel: u32) -> Option<ShadowRay> {
        let own = self.image.seen.triangle[pixel as usize];
        let ray = self.image.camera_ray(pixel as usize);
        let crossing = crossing(&ray, self.image.triangles.usable_corners(own).ok()?)?;
        Some(ShadowRay::new(self.light, HitPoint::new(&ray, crossing.t)))
    }

    fn is_blocked(&self, ray: &ShadowRay, id: u32) -> bool {
        let Ok(corners) = self.image.triangles.usable_corners(id) else { return false };
        let barycentric = ray.blocked_by(corners);
        barycentric.is_some_and(|barycentric| (self.is_opaque)(id) || (self.casts)(id, barycentric))
    }

    /// Decides pairs of a pixel and a triangle, and forgets them.
    #[inline(never)]
    pub(super) fn decide(&self, pairs: &mut Vec<[u32; 2]>, shadowed: &[AtomicU8]) {
        self.decide_all(pairs, shadowed);
        pairs.clear();
    }

    fn decide_all(&self, pairs: &[[u32; 2]], shadowed: &[AtomicU8]) {
        let mut last: Option<(u32, Option<ShadowRay>)> = None;
        for &[pixel, id] in pairs {
            if shadowed[pixel as usize].load(Ordering::Relaxed) != 0 {
                continue;
            }
            let ray = match last {
                Some((known, ray)) if known == pixel => ray,
                _ => self.shadow_ray(pixel),
            };
            last = Some((pixel, ray));
            if ray.is_some_and(|ray| self.is_blocked(&ray, id)) {
                shadowed[pixel as usize].store(1, Ordering::Relaxed);
            }
        }
    }
}

impl LightGrid {
    pub(super) fn clear_shadows(&mut self, pixels: usize) {
        self.shadowed.resize_with(pixels, AtomicU8::default);
        self.shadowed.par_chunks_mut(1 << 14).for_each(|chunk| {
            chunk.iter_mut().for_each(|shadowed| *shadowed.get_mut() = 0);
        });
    }

    /// Brings what the threads found from blocks to pixels.
    pub(super) fn merge_shadows(&mut self) {
        let Self { blocks, workers, shadowed, .. } = self;
        blocks.par_iter().enumerate().with_min_len(256).for_each(|(place, block)| {
            let mut found = workers.iter().fold(0, |found, worker| found | worker.shadowed[place]);
            while found != 0 {
                let lane = found.trailing_zeros() as usize;
                found &= found - 1;
                let pixel = block.pixel[lane];
                if pixel != Block::PADDING {
                    shadowed[pixel as usize].store(1, Ordering::Relaxed);
                }
            }
        });
    }

    /// Asks the predicate about what the threads couldn't decide.
    pub(super) fn decide<O, C>(&mut self, judge: &Judge<'_, O, C>)
    where
        O: Fn(u32) -> bool + Sync,
        C: Fn(u32, [f32; 2]) -> bool + Sync,
    {
        let shadowed = &self.shadowed;
        self.workers.par_iter_mut().for_each(|worker| {
            worker.undecided.par_chunks(256).for_each(|pairs| judge.decide_all(pairs, shadowed));
            worker.undecided.clear();
        });
    }

    /// Tests the points that no class holds against every triangle.
    pub(super) fn decide_outliers<O, C>(&mut self, judge: &Judge<'_, O, C>)
    where
        O: Fn(u32) -> bool + Sync,
        C: Fn(u32, [f32; 2]) -> bool + Sync,
    {
        self.counts.outliers = self.outliers.len() as u64;
        let count = judge.image.triangles.len() as u32;
        for &pixel in &self.outliers {
            let Some(ray) = judge.shadow_ray(pixel) else { continue };
            let own = judge.image.seen.triangle[pixel as usize];
            let blocked = (0..count).into_par_iter().with_min_len(1024);
            if blocked.filter(|&id| id != own).any(|id| judge.is_blocked(&ray, id)) {
                *self.shadowed[pixel as usize].get_mut() = 1;
            }
        }
    }

    /// The bits of the pixels that show a lit point.
    pub(super) fn gather_bits(&mut self, lit: &mut [u16]) {
        let Self { points, shadowed, .. } = self;
        let pixels = shadowed.par_chunks_mut(TileOrder::BLOCK_PLACES).zip(points.t.par_chunks(TileOrder::BLOCK_PLACES));
        lit.par_iter_mut().zip(pixels).with_min_len(256).for_each(|(word, (shadowed, t))| {
            let mut bits = 0;
            for (place, (shadowed, t)) in shadowed.iter_mut().zip(t).enumerate() {
                bits |= u16::from(*shadowed.get_mut() == 0 && !t.is_nan()) << place;
            }
            *word = bits;
        });
    }
}
