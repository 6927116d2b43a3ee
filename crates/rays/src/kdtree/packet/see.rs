use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::predicate::{self, HitPoint, ShadowRay};
use crate::shot::{Mask, SeenImage, SeenPixels, ShadowMask, TileOrder};
use crate::{Hit, KdTree, LightSource, Ray, Triangles, View};

/// Blocks along an edge of a tile, and of a square of pixels whose rays are traced together.
const TILE_BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;
const SQUARE_BLOCKS: usize = 4;

/// Places of a square.
const SQUARE_PLACES: usize = SQUARE_BLOCKS * SQUARE_BLOCKS * TileOrder::BLOCK_PLACES;

/// Instead of a ray where there is none.
const NO_RAY: Ray = Ray { origin: DVec3::ZERO, direction: DVec3::X, t_min: 0.0, t_max: 0.0 };

impl KdTree {
    /// Finds what each pixel sees by tracing packets of neighbouring pixels' rays: bit for bit the same on any number of threads
    /// and with all options. Pixels that hit nothing see [`SeenPixels::NONE`].
    ///
    /// `triangles` are those of the last [`build`](Self::build); rays go through each pixel at `offset_pixels`, from (0, 0)
    /// for its upper left corner to (1, 1). Triangles for which `is_opaque` is false are hit where `mask` says that they
    /// are solid.
    #[expect(clippy::needless_pass_by_value, reason = "masks are small and written where they are passed")]
    pub fn see(
        &self,
        triangles: Triangles<'_>,
        view: &View,
        offset_pixels: DVec2,
        is_opaque: impl Fn(u32) -> bool + Sync,
        mask: impl Mask,
        seen: &mut SeenPixels,
    ) {
        seen.resize(view.width, view.height);
        let order = seen.order();
        let tiles = seen.triangle.par_chunks_mut(TileOrder::TILE_PLACES);
        let tiles = tiles.zip(seen.inverse_depth.par_chunks_mut(TileOrder::TILE_PLACES));
        tiles.enumerate().with_max_len(1).for_each(|(tile, (triangle, inverse_depth))| {
            triangle.fill(SeenPixels::NONE);
            inverse_depth.fill(f32::NAN);
            for square in squares() {
                let mut pixels = Places::default();
                let mut rays = [NO_RAY; SQUARE_PLACES];
                for place in places_of(square) {
                    if let Some((x, y)) = order.pixel(tile * TileOrder::TILE_PLACES + place) {
                        rays[pixels.count] = ray(view, offset_pixels, (x, y));
                        pixels.push(place);
                    }
                }
                let mut hits = [None; SQUARE_PLACES];
                let hits = &mut hits[..pixels.count];
                let counts = |hit: &Hit| is_opaque(hit.triangle) || mask.is_solid(hit);
                self.nearest_of_packet(triangles, &rays[..pixels.count], counts, hits);
                for (&place, hit) in pixels.places.iter().zip(hits) {
                    if let Some(hit) = hit {
                        triangle[usize::from(place)] = hit.triangle;
                        inverse_depth[usize::from(place)] = SeenPixels::inverse_of(hit.t);
                    }
                }
            }
        });
    }

    /// Finds which points that `image` shows are lit by `light`: a bit for each place of [`TileOrder`], a block of 4×4
    /// pixels to a word of `blocks`, the first in the lowest bit; zero where there is no point. Cones of spot lights don't
    /// count.
    ///
    /// A point is lit unless some triangle but its own shadows it as [`ShadowRay::blocked_by`] says. A triangle for which
    /// `is_opaque` is false only does where `mask` says that it casts a shadow. Packets are those of the pixels.
    ///
    /// # Panics
    /// If `blocks` hasn't a word for each block, or `image.seen` isn't of the size of `image.view`.
    pub fn shadow(
        &self,
        image: &SeenImage<'_>,
        light: &LightSource,
        is_opaque: impl Fn(u32) -> bool + Sync,
        mask: &impl ShadowMask,
        blocks: &mut [u16],
    ) {
        let SeenImage { triangles, view, offset_pixels, seen } = *image;
        let (size, order) = ((view.width, view.height), seen.order());
        assert!(order.size() == size, "an image of {:?} pixels seen through a view of {size:?}", order.size());
        let words = seen.triangle.len() / TileOrder::BLOCK_PLACES;
        assert!(blocks.len() == words, "{} words for {words} blocks of pixels", blocks.len());
        let counts = |id, barycentric| is_opaque(id) || mask.casts(id, barycentric);
        blocks.par_chunks_mut(TILE_BLOCKS * TILE_BLOCKS).enumerate().with_max_len(1).for_each(|(tile, lit)| {
            lit.fill(0);
            for square in squares() {
                let mut points = Places::default();
                let mut rays = [NO_RAY; SQUARE_PLACES];
                let mut pairs = [(0, 0); SQUARE_PLACES];
                for place in places_of(square) {
                    let in_image = tile * TileOrder::TILE_PLACES + place;
                    let own = seen.triangle[in_image];
                    if let Some(pixel) = order.pixel(in_image).filter(|_| own != SeenPixels::NONE) {
                        rays[points.count] = ray(&view, offset_pixels, pixel);
                        pairs[points.count] = (points.count as u32, own);
                        points.push(place);
                    }
                }
                if points.count == 0 {
                    continue;
                }
                let (pairs, mut hits) = (&pairs[..points.count], [None; SQUARE_PLACES]);
                predicate::hits(self.level.into(), triangles, &rays, pairs, &mut hits);
                let mut own = [u32::MAX; SQUARE_PLACES];
                let mut shadow_rays = [ShadowRay::new(light, HitPoint::new(&rays[0], 0.0)); SQUARE_PLACES];
                // A camera's ray meets what it has seen.
                for (place, hit) in hits[..points.count].iter().enumerate() {
                    let t = hit.map_or(f64::NAN, |hit| hit.t);
                    shadow_rays[place] = ShadowRay::new(light, HitPoint::new(&rays[place], t));
                    own[place] = pairs[place].1;
                }
                let mut blocked = [false; SQUARE_PLACES];
                let (count, blocked) = (points.count, &mut blocked[..points.count]);
                self.blocked_of_packet(triangles, &shadow_rays[..count], &own[..count], counts, blocked);
                for (&place, &blocked) in points.places.iter().zip(&*blocked) {
                    let (block, bit) = (usize::from(place) / 16, place % 16);
                    lit[block] |= u16::from(!blocked) << bit;
                }
            }
        });
    }
}

/// Some places of a square, in order.
struct Places {
    places: [u16; SQUARE_PLACES],
    count: usize,
}

impl Default for Places {
    fn default() -> Self {
        Self { places: [0; SQUARE_PLACES], count: 0 }
    }
}

impl Places {
    fn push(&mut self, place: usize) {
        self.places[self.count] = place as u16;
        self.count += 1;
    }
}

/// The first blocks of a tile's squares.
fn squares() -> impl Iterator<Item = usize> {
    let rows = (0..TILE_BLOCKS).step_by(SQUARE_BLOCKS);
    rows.flat_map(|row| (0..TILE_BLOCKS).step_by(SQUARE_BLOCKS).map(move |column| row * TILE_BLOCKS + column))
}

/// The places in its tile of a square that begins with a block.
fn places_of(first: usize) -> impl Iterator<Item = usize> {
    (0..SQUARE_PLACES).map(move |place| {
        let (block, in_block) = (place / TileOrder::BLOCK_PLACES, place % TileOrder::BLOCK_PLACES);
        let block = first + block / SQUARE_BLOCKS * TILE_BLOCKS + block % SQUARE_BLOCKS;
        block * TileOrder::BLOCK_PLACES + in_block
    })
}

fn ray(view: &View, offset_pixels: DVec2, (x, y): (u32, u32)) -> Ray {
    view.ray(f64::from(x) + offset_pixels.x, f64::from(y) + offset_pixels.y)
}
