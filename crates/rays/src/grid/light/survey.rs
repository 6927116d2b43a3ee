use std::time::Instant;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};
use glam::DVec3;
use rayon::prelude::*;

use super::lanes::{LANES, splat};
use super::{LightGrid, SeenImage};
use crate::grid::{SeenPixels, TileOrder};
use crate::{Camera, Projection};

/// What all lights want to know about an image.
#[derive(Default)]
pub(super) struct Survey {
    pub(super) tiles: Vec<Tile>,
    pub(super) rays: CameraRays,
    /// How many places of the image the grid was last asked about.
    pub(super) places: usize,
    /// Places that show a triangle at a depth that isn't known: they are outliers of every light.
    pub(super) unknown: Vec<u32>,
}

impl Survey {
    pub(super) fn bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<Tile>() + self.unknown.capacity() * size_of::<u32>()
    }
}

/// What a tile of pixels shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tile {
    /// How many of its places show a point at a known depth.
    pub(super) points: u32,
    /// Whether some place shows a point at an unknown depth.
    pub(super) has_unknown: bool,
    /// The corners of a frustum that all points of known depth are in.
    pub(super) corners: [DVec3; 8],
}

impl LightGrid {
    /// Finds out how far away each tile's points are; call it before [`LightGrid::shadow`], once for all lights.
    ///
    /// # Panics
    /// If `image.seen` isn't of the size of `image.view`.
    pub fn survey(&mut self, image: &SeenImage<'_>) {
        let start = Instant::now();
        let (size, seen) = ((image.view.width, image.view.height), image.seen.order().size());
        assert!(seen == size, "an image of {seen:?} pixels seen through a view of {size:?}");
        let Survey { tiles, rays, places, unknown } = &mut self.survey;
        *rays = CameraRays::new(image);
        *places = image.seen.triangle.len();
        tiles.resize(*places / TileOrder::TILE_PLACES, Tile::default());
        let (level, rays) = (self.level.0, &*rays);
        tiles.par_iter_mut().enumerate().with_min_len(4).for_each(|(place, tile)| {
            *tile = dispatch!(level, simd => survey(simd, image, rays, place));
        });
        unknown.clear();
        for (place, _) in tiles.iter().enumerate().filter(|(_, tile)| tile.has_unknown) {
            let places = place * TileOrder::TILE_PLACES..(place + 1) * TileOrder::TILE_PLACES;
            unknown.extend(places.filter(|&place| is_unknown(image.seen, place)).map(|place| place as u32));
        }
        self.seconds.survey = start.elapsed().as_secs_f64();
    }
}

fn is_unknown(seen: &SeenPixels, place: usize) -> bool {
    seen.triangle[place] != SeenPixels::NONE && seen.inverse_depth[place].is_nan()
}

#[inline(always)]
fn survey<S: Simd>(simd: S, image: &SeenImage<'_>, rays: &CameraRays, tile: usize) -> Tile {
    let first = tile * TileOrder::TILE_PLACES;
    let (mut lowest, mut highest) = (splat(simd, f32::INFINITY), splat(simd, 0.0));
    let (mut points, mut has_unknown) = (0, false);
    let places = first..first + TileOrder::TILE_PLACES;
    for (block, depths) in image.seen.inverse_depth[places].chunks_exact(LANES).enumerate() {
        let depths = f32x16::from_slice(simd, depths);
        let known = depths.simd_eq(depths);
        lowest = known.select(lowest.min(depths), lowest);
        highest = known.select(highest.max(depths), highest);
        let known = known.to_bitmask();
        points += known.count_ones();
        if known != u64::from(u16::MAX) {
            let block = first + block * LANES;
            has_unknown |= (block..block + LANES).any(|place| is_unknown(image.seen, place));
        }
    }
    let depths = [lowest.reduce_min(), highest.reduce_max()];
    let corners = if points > 0 { rays.frustum(first, depths) } else { [DVec3::ZERO; 8] };
    Tile { points, has_unknown, corners }
}

/// The constants of [`View::ray`](crate::View::ray).
#[derive(Clone, Copy, Default)]
pub(in crate::grid) struct CameraRays {
    pub(in crate::grid) position: DVec3,
    /// What one pixel to the right adds to a perspective direction or an orthographic origin.
    pub(in crate::grid) step_x: DVec3,
    /// What one pixel downwards adds to it.
    pub(in crate::grid) step_y: DVec3,
    /// What it is at pixel (0, 0).
    pub(in crate::grid) corner: DVec3,
    pub(in crate::grid) forward: DVec3,
    pub(in crate::grid) is_perspective: bool,
    pub(in crate::grid) order: TileOrder,
    /// Largest component of any direction.
    pub(in crate::grid) largest_direction: f64,
    /// Largest coordinate of any origin.
    pub(in crate::grid) largest_origin: f64,
}

impl CameraRays {
    pub(in crate::grid) fn new(image: &SeenImage<'_>) -> Self {
        let Camera { position, right, up, forward, projection } = image.view.camera;
        let (width, height) = (f64::from(image.view.width), f64::from(image.view.height));
        let (is_perspective, half_height) = match projection {
            Projection::Perspective { tan_half_height } => (true, f64::from(tan_half_height)),
            Projection::Orthographic { half_height } => (false, f64::from(half_height)),
        };
        let step_x = right.as_dvec3() * (2.0 * half_height / height);
        let step_y = up.as_dvec3() * (-2.0 * half_height / height);
        let [offset_x, offset_y] = image.offset_pixels.to_array();
        let base = if is_perspective { forward.as_dvec3() } else { position.as_dvec3() };
        let corner = base + step_x * (offset_x - 0.5 * width) + step_y * (offset_y - 0.5 * height);
        // Twice the half width and height of the image and what its last tiles have beyond.
        let tile = f64::from(TileOrder::TILE);
        let (width, height) = (width + 2.0 * tile + offset_x.abs(), height + 2.0 * tile + offset_y.abs());
        let across = (step_x.abs() * width + step_y.abs() * height).max_element();
        let (position, forward) = (position.as_dvec3(), forward.as_dvec3());
        let (origin, direction) = (position.abs().max_element(), forward.abs().max_element());
        Self {
            position,
            step_x,
            step_y,
            corner,
            forward,
            is_perspective,
            order: image.seen.order(),
            largest_direction: if is_perspective { direction + across } else { direction },
            largest_origin: if is_perspective { origin } else { origin + across },
        }
    }

    /// The origin and the direction of the ray of the pixel in a column and row.
    ///
    /// Each component has four roundings: it is wrong by at most 4 half ulps of the largest one.
    pub(in crate::grid) fn ray(&self, column: f64, row: f64) -> (DVec3, DVec3) {
        let varying = self.step_x * column + (self.step_y * row + self.corner);
        if self.is_perspective { (self.position, varying) } else { (varying, self.forward) }
    }

    /// The corners of the part of the view in which the tile that begins at `first` shows points of these inverse
    /// depths.
    pub(super) fn frustum(&self, first: usize, depths: [f32; 2]) -> [DVec3; 8] {
        let (x, y) = self.order.column_and_row(first);
        let last = f64::from(TileOrder::TILE - 1);
        // The tile's own border, so that rounding can't lose a point, and depths as wrong as they may be.
        let columns = [f64::from(x) - 0.25, f64::from(x) + last + 0.25];
        let rows = [f64::from(y) - 0.25, f64::from(y) + last + 0.25];
        const ERROR: f64 = 2.0 * SeenPixels::RELATIVE_ERROR as f64;
        let t = [(1.0 - ERROR) / f64::from(depths[1]), (1.0 + ERROR) / f64::from(depths[0])];
        std::array::from_fn(|corner| {
            let (origin, direction) = self.ray(columns[corner & 1], rows[corner >> 1 & 1]);
            origin + direction * t[corner >> 2]
        })
    }
}
