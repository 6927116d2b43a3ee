use glam::DVec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use crate::KdTree;
use umbrage_rays::predicate::{self, HitPoint, ShadowRay};
use umbrage_rays::shot::{LightMask, Opacity, OpacityOfSides, SeenPixels, Shot, TileOrder};
use umbrage_rays::{Hit, LightSource, Ray, SimdLevel, Triangles};

/// The numbers of blocks along an edge of a tile, and of a square of pixels whose rays are traced together.
const TILE_BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;
const SQUARE_BLOCKS: usize = 4;

/// The number of pixels in a square.
pub(crate) const SQUARE_PIXELS: usize = SQUARE_BLOCKS * SQUARE_BLOCKS * TileOrder::BLOCK_PIXELS;

/// Fills up packets of fewer rays.
pub(crate) const NO_RAY: Ray = Ray { origin: DVec3::ZERO, direction: DVec3::X, t_min: 0.0, t_max: 0.0 };

/// A structure that traces packets of rays, as [`KdTree::nearest_of_packet`] and [`KdTree::blocked_of_packet`] do.
pub(crate) trait PacketRays: Sync {
    /// The instructions that are used.
    fn level(&self) -> SimdLevel;

    /// Finds the hit of each ray, of at most 256.
    fn nearest(&self, triangles: Triangles<'_>, rays: &[Ray], stops: impl Fn(&Hit) -> bool, hits: &mut [Option<Hit>]);

    /// Finds whether each point is shadowed, of at most 256.
    fn blocked(
        &self,
        triangles: Triangles<'_>,
        rays: &[ShadowRay],
        own: &[u32],
        stops: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
    );

    /// Fills `seen` for each pixel of `shot` by tracing packets of neighbouring pixels' rays.
    fn see_packets(&self, shot: &Shot<'_>, seen: &mut SeenPixels) {
        let opacity: &dyn Opacity = &OpacityOfSides::of_camera(shot);
        seen.resize(shot.view.width, shot.view.height);
        let order = seen.order();
        let tiles = seen.triangle.par_chunks_mut(TileOrder::TILE_PIXELS);
        let tiles = tiles.zip(seen.inverse_depth.par_chunks_mut(TileOrder::TILE_PIXELS));
        tiles.enumerate().with_max_len(1).each(|(tile, (triangle, inverse_depth))| {
            triangle.fill(SeenPixels::NONE);
            inverse_depth.fill(f32::NAN);
            for square in squares() {
                let mut pixels = Places::default();
                let mut rays = [NO_RAY; SQUARE_PIXELS];
                for index in pixels_of(square) {
                    if let Some((x, y)) = order.pixel(tile * TileOrder::TILE_PIXELS + index) {
                        rays[pixels.count] = shot.ray(x, y);
                        pixels.push(index);
                    }
                }
                let mut hits = [None; SQUARE_PIXELS];
                let hits = &mut hits[..pixels.count];
                let stops = |hit: &Hit| opacity.is_stopped_at(hit.triangle, hit.barycentric);
                self.nearest(shot.triangles, &rays[..pixels.count], stops, hits);
                for (&index, hit) in pixels.indices.iter().zip(hits) {
                    if let Some(hit) = hit {
                        triangle[usize::from(index)] = hit.triangle;
                        inverse_depth[usize::from(index)] = SeenPixels::inverse_of(hit.t);
                    }
                }
            }
        });
    }

    /// As [`Structure::shadow`](umbrage_rays::Structure::shadow).
    fn shadow_all(&self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) {
        shot.expect_masks(seen, lights, masks);
        for (light, mask) in lights.iter().zip(masks) {
            self.shadow_packets(shot, seen, light, mask);
            mask.keep_in_cone(light, shot, seen, self.level());
        }
    }

    /// Sets in `mask` the pixels of `shot` whose `seen` points are lit by `light`. Packets are those of the pixels.
    fn shadow_packets(&self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) {
        shot.expect_size(seen);
        mask.resize(seen.order());
        let (triangles, order) = (shot.triangles, seen.order());
        let opacity: &dyn Opacity = &OpacityOfSides::of_light(shot, light);
        let stops = |id, barycentric| opacity.is_stopped_at(id, barycentric);
        mask.blocks_mut().par_chunks_mut(TILE_BLOCKS * TILE_BLOCKS).enumerate().with_max_len(1).each(|(tile, lit)| {
            lit.fill(0);
            for square in squares() {
                let mut points = Places::default();
                let mut rays = [NO_RAY; SQUARE_PIXELS];
                let mut pairs = [(0, 0); SQUARE_PIXELS];
                for index in pixels_of(square) {
                    let in_image = tile * TileOrder::TILE_PIXELS + index;
                    let own = seen.triangle[in_image];
                    if let Some((x, y)) = order.pixel(in_image).filter(|_| own != SeenPixels::NONE) {
                        rays[points.count] = shot.ray(x, y);
                        pairs[points.count] = (points.count as u32, own);
                        points.push(index);
                    }
                }
                if points.count == 0 {
                    continue;
                }
                let (pairs, mut hits) = (&pairs[..points.count], [None; SQUARE_PIXELS]);
                predicate::hits(self.level(), triangles, &rays, pairs, &mut hits);
                let mut own = [u32::MAX; SQUARE_PIXELS];
                let mut shadow_rays = [ShadowRay::new(light, HitPoint::new(&rays[0], 0.0)); SQUARE_PIXELS];
                // A camera's ray hits the triangle that it has seen.
                for (index, hit) in hits[..points.count].iter().enumerate() {
                    let t = hit.map_or(f64::NAN, |hit| hit.t);
                    shadow_rays[index] = ShadowRay::new(light, HitPoint::new(&rays[index], t));
                    own[index] = pairs[index].1;
                }
                let mut blocked = [false; SQUARE_PIXELS];
                let (count, blocked) = (points.count, &mut blocked[..points.count]);
                self.blocked(triangles, &shadow_rays[..count], &own[..count], stops, blocked);
                for (&index, &blocked) in points.indices.iter().zip(&*blocked) {
                    let (block, bit) = (usize::from(index) / 16, index % 16);
                    lit[block] |= u16::from(!blocked) << bit;
                }
            }
        });
    }
}

impl PacketRays for KdTree {
    fn level(&self) -> SimdLevel {
        self.level
    }

    fn nearest(&self, triangles: Triangles<'_>, rays: &[Ray], stops: impl Fn(&Hit) -> bool, hits: &mut [Option<Hit>]) {
        self.nearest_of_packet(triangles, rays, stops, hits);
    }

    fn blocked(
        &self,
        triangles: Triangles<'_>,
        rays: &[ShadowRay],
        own: &[u32],
        stops: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
    ) {
        self.blocked_of_packet(triangles, rays, own, stops, blocked);
    }
}

/// Some pixels of a square, in order.
struct Places {
    indices: [u16; SQUARE_PIXELS],
    count: usize,
}

impl Default for Places {
    fn default() -> Self {
        Self { indices: [0; SQUARE_PIXELS], count: 0 }
    }
}

impl Places {
    fn push(&mut self, index: usize) {
        self.indices[self.count] = index as u16;
        self.count += 1;
    }
}

/// The first blocks of a tile's squares.
fn squares() -> impl Iterator<Item = usize> {
    let rows = (0..TILE_BLOCKS).step_by(SQUARE_BLOCKS);
    rows.flat_map(|row| (0..TILE_BLOCKS).step_by(SQUARE_BLOCKS).map(move |column| row * TILE_BLOCKS + column))
}

/// The indices in its tile of the pixels of a square that begins with a block.
fn pixels_of(first: usize) -> impl Iterator<Item = usize> {
    (0..SQUARE_PIXELS).map(move |index| {
        let (block, in_block) = (index / TileOrder::BLOCK_PIXELS, index % TileOrder::BLOCK_PIXELS);
        let block = first + block / SQUARE_BLOCKS * TILE_BLOCKS + block % SQUARE_BLOCKS;
        block * TileOrder::BLOCK_PIXELS + in_block
    })
}
