use crate::dispatch;
use crate::parallel::Parallel;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::DVec3;
use rayon::prelude::*;
use web_time::Instant;

use crate::shot::{CameraRays, SeenImage, SeenPixels, Shot, TileOrder};
use crate::simd::SimdLevel;
use crate::simd::vectors::{LANES, splat};

/// The distances of an image's points, for all lights.
#[derive(Default)]
pub struct Survey {
    pub tiles: Vec<SurveyedTile>,
    pub rays: CameraRays,
    /// Number of slots of the surveyed image in [`TileOrder`].
    pub slots: usize,
    /// The indices of pixels that show a triangle at an unknown depth: they are outliers of every light.
    pub unknown: Vec<u32>,
    /// Seconds that the survey took.
    pub seconds: f64,
}

impl Survey {
    pub fn bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<SurveyedTile>() + self.unknown.capacity() * size_of::<u32>()
    }
}

/// The points of a tile of pixels.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurveyedTile {
    /// Number of its pixels that show a point at a known depth.
    pub points: u32,
    /// Whether some pixel shows a point at an unknown depth.
    pub(crate) has_unknown: bool,
    /// The corners of a frustum around all points of known depth.
    pub corners: [DVec3; 8],
}

impl Survey {
    /// Finds the distances of each tile's points, once for all lights.
    ///
    /// # Panics
    /// If `seen` isn't of the size of the shot's view.
    pub fn find(&mut self, shot: &Shot<'_>, seen: &SeenPixels, level: SimdLevel) {
        let start = Instant::now();
        shot.expect_size(seen);
        let image = &SeenImage { shot, seen };
        let Self { tiles, rays, slots, unknown, seconds } = self;
        *rays = CameraRays::new(shot);
        *slots = image.seen.triangle.len();
        tiles.resize(*slots / TileOrder::TILE_PIXELS, SurveyedTile::default());
        let rays = &*rays;
        tiles.par_iter_mut().enumerate().with_min_len(4).each(|(index, tile)| {
            *tile = dispatch!(level, simd => survey(simd, image, rays, index));
        });
        unknown.clear();
        for (tile, _) in tiles.iter().enumerate().filter(|(_, tile)| tile.has_unknown) {
            let indices = tile * TileOrder::TILE_PIXELS..(tile + 1) * TileOrder::TILE_PIXELS;
            unknown.extend(indices.filter(|&index| is_unknown(image.seen, index)).map(|index| index as u32));
        }
        *seconds = start.elapsed().as_secs_f64();
    }
}

fn is_unknown(seen: &SeenPixels, index: usize) -> bool {
    seen.triangle[index] != SeenPixels::NONE && seen.inverse_depth[index].is_nan()
}

#[inline(always)]
fn survey<S: Simd>(simd: S, image: &SeenImage<'_>, rays: &CameraRays, tile: usize) -> SurveyedTile {
    let first = tile * TileOrder::TILE_PIXELS;
    let (mut lowest, mut highest) = (splat(simd, f32::INFINITY), splat(simd, 0.0));
    let (mut points, mut unknown) = (0, 0);
    let none = u32x16::splat(simd, SeenPixels::NONE);
    let (depths, ids) = (&image.seen.inverse_depth[first..], &image.seen.triangle[first..]);
    let blocks = depths.chunks_exact(LANES).zip(ids.chunks_exact(LANES)).take(TileOrder::TILE_PIXELS / LANES);
    for (depths, ids) in blocks {
        let depths = f32x16::from_slice(simd, depths);
        let known = depths.simd_eq(depths);
        lowest = known.select(lowest.min(depths), lowest);
        highest = known.select(highest.max(depths), highest);
        points += known.to_bitmask().count_ones();
        unknown |= (u32x16::from_slice(simd, ids).simd_ne(none) & !known).to_bitmask();
    }
    let depths = [lowest.reduce_min(), highest.reduce_max()];
    let corners = if points > 0 { rays.frustum(first, depths) } else { [DVec3::ZERO; 8] };
    SurveyedTile { points, has_unknown: unknown != 0, corners }
}

#[cfg(test)]
mod tests;
