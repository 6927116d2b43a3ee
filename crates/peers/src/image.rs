use std::array::from_fn;

use fearless_simd::Simd;
use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::{Bounds, LightSource, Shot};
use umbrage_rays::{SimdLevel, dispatch};

use crate::packet::{RayHitPacket, Valid, WIDTH};
use crate::posed::Posed;

/// Side of a packet in pixels.
const PACKET_SIDE: u32 = 4;
/// Side of a tile in packets.
const TILE_PACKETS: u32 = 16;
/// Packets of a tile.
const PACKETS: usize = (TILE_PACKETS * TILE_PACKETS) as usize;

/// Each pixel's nearest hit, and a bit for whether a light reaches its point.
///
/// In tiles of 64×64 pixels, row by row; each has packets of 4×4 pixels along a Z-shaped curve. 8 bytes a pixel, and
/// two for each packet and light.
#[derive(Clone, Debug, Default)]
pub struct Image {
    width: u32,
    height: u32,
    seen: Vec<Seen>,
    lit: Vec<u16>,
}

/// Nearest hits of a packet of camera rays.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Seen {
    t: [f32; WIDTH],
    triangle: [u32; WIDTH],
}

/// The camera's rays in f32: origin and direction are linear functions of the position in the image.
#[derive(Clone, Copy, Debug)]
pub struct PixelRays {
    width: u32,
    height: u32,
    /// Offsets of a packet's rays from its first pixel: columns and rows.
    lanes: [[f32; WIDTH]; 2],
    origin: Linear,
    direction: Linear,
    is_parallel: bool,
}

/// A vector for each ray: `first` + column · `right` + row · `down`.
#[derive(Clone, Copy, Debug)]
struct Linear {
    first: Vec3,
    right: Vec3,
    down: Vec3,
}

/// Origins and directions of shadow rays.
#[derive(Clone, Copy, Debug)]
enum Shadows {
    /// From a point light to the points.
    From(Vec3),
    /// To the points along a vector that is longer than the scene.
    Along(Vec3),
}

/// End of shadow rays, in units of the distance to the point: they must not hit the point's own surface, and Embree's
/// hits aren't exact.
const BEFORE_POINT: f32 = 1.0 - 1e-4;

impl PixelRays {
    /// The rays of the pixels of `shot`.
    #[must_use]
    pub fn new(shot: &Shot<'_>) -> Self {
        let &Shot { view, offset_pixels, shifts, .. } = shot;
        let [first, right, down] =
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| view.ray(offset_pixels.x + x, offset_pixels.y + y));
        let lane = |lane: usize| (lane as u32 % PACKET_SIDE, lane as u32 / PACKET_SIDE);
        let columns = from_fn(|index| lane(index).0 as f32 + shifts.at(lane(index).0, lane(index).1).x as f32);
        let rows = from_fn(|index| lane(index).1 as f32 + shifts.at(lane(index).0, lane(index).1).y as f32);
        let origin = Linear {
            first: first.origin.as_vec3(),
            right: (right.origin - first.origin).as_vec3(),
            down: (down.origin - first.origin).as_vec3(),
        };
        let direction = Linear {
            first: first.direction.as_vec3(),
            right: (right.direction - first.direction).as_vec3(),
            down: (down.direction - first.direction).as_vec3(),
        };
        let is_parallel = origin.right != Vec3::ZERO || origin.down != Vec3::ZERO;
        Self { width: view.width, height: view.height, lanes: [columns, rows], origin, direction, is_parallel }
    }

    /// Number of tiles in a row.
    fn columns(&self) -> u32 {
        self.width.div_ceil(PACKET_SIDE * TILE_PACKETS)
    }

    fn tiles(&self) -> usize {
        (self.columns() * self.height.div_ceil(PACKET_SIDE * TILE_PACKETS)) as usize
    }

    /// The first column and row of a packet of a tile.
    #[inline(always)]
    fn corner(&self, tile: usize, packet: usize) -> [u32; 2] {
        let (tile, packet) = (tile as u32, packet as u32);
        let columns = self.columns();
        let x = tile % columns * TILE_PACKETS + every_second_bit(packet);
        let y = tile / columns * TILE_PACKETS + every_second_bit(packet >> 1);
        [x * PACKET_SIDE, y * PACKET_SIDE]
    }

    /// Flags of the packet's pixels that are in the image.
    #[inline(always)]
    fn inside(&self, [x, y]: [u32; 2]) -> Valid {
        if x + PACKET_SIDE <= self.width && y + PACKET_SIDE <= self.height {
            return Valid::ALL;
        }
        let is_inside = |lane: u32| x + lane % PACKET_SIDE < self.width && y + lane / PACKET_SIDE < self.height;
        Valid(from_fn(|lane| -i32::from(is_inside(lane as u32))))
    }
}

/// Bits 0, 2, 4 and 6 as bits 0 to 3.
#[inline(always)]
fn every_second_bit(bits: u32) -> u32 {
    bits & 1 | bits >> 1 & 2 | bits >> 2 & 4 | bits >> 3 & 8
}

impl Linear {
    /// One component of the vectors of the packet whose first pixel is (x, y).
    #[inline(always)]
    fn fill(&self, axis: usize, [x, y]: [u32; 2], [columns, rows]: &[[f32; WIDTH]; 2], into: &mut [f32; WIDTH]) {
        let first = self.first[axis] + self.right[axis] * x as f32 + self.down[axis] * y as f32;
        *into = from_fn(|lane| first + (self.right[axis] * columns[lane] + self.down[axis] * rows[lane]));
    }
}

impl Shadows {
    fn new(light: &LightSource, bounds: Bounds, rays: &PixelRays) -> Self {
        match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => Self::From(position),
            LightSource::Directional { direction } => {
                let reach = bounds.size().length() + (bounds.center() - rays.origin.first).length();
                Self::Along(direction * reach)
            }
        }
    }
}

impl Image {
    /// Triangle name of a miss.
    pub const NOTHING: u32 = u32::MAX;

    /// Finds each pixel's nearest hit. `nearest` gets the rays with their flags, and writes their hits.
    pub fn see(&mut self, rays: &PixelRays, nearest: impl Fn(&Valid, &mut RayHitPacket) + Sync) {
        (self.width, self.height) = (rays.width, rays.height);
        self.seen.resize(rays.tiles() * PACKETS, Seen { t: [0.0; WIDTH], triangle: [Self::NOTHING; WIDTH] });
        let level = SimdLevel::default();
        self.seen.par_chunks_mut(PACKETS).enumerate().with_max_len(1).for_each(|(tile, seen)| {
            dispatch!(level, simd => see_tile(simd, rays, tile, seen, &nearest));
        });
    }

    /// Finds the pixels' points that `light` reaches, by rays from the light. `bounds` are those of the scene.
    /// `occluded` gets the rays with their flags, and sets `t_far` of blocked rays below zero.
    ///
    /// # Panics
    /// If `rays` are not those of the last [`Image::see`].
    pub fn shadow(
        &mut self,
        rays: &PixelRays,
        (light, bounds): (&LightSource, Bounds),
        occluded: impl Fn(&Valid, &mut RayHitPacket) + Sync,
    ) {
        assert!((self.width, self.height) == (rays.width, rays.height), "the rays of another image");
        self.lit.resize(self.seen.len(), 0);
        let shadows = Shadows::new(light, bounds, rays);
        let level = SimdLevel::default();
        let tiles = self.lit.par_chunks_mut(PACKETS).zip(self.seen.par_chunks(PACKETS)).enumerate();
        tiles.with_max_len(1).for_each(|(tile, (lit, seen))| {
            dispatch!(level, simd => shadow_tile(simd, rays, tile, &shadows, seen, lit, &occluded));
        });
    }

    /// Copies the nearest hits of `other`.
    pub fn clone_hits_from(&mut self, other: &Self) {
        (self.width, self.height) = (other.width, other.height);
        self.seen.clone_from(&other.seen);
    }

    /// Name of a pixel's triangle, for [`Posed::triangle`], and its distance in lengths of the camera ray's direction;
    /// `None` for a miss.
    #[must_use]
    pub fn seen(&self, x: u32, y: u32) -> Option<(u32, f32)> {
        let (packet, lane) = self.packet_and_lane(x, y);
        let Seen { t, triangle } = &self.seen[packet];
        (triangle[lane] != Self::NOTHING).then_some((triangle[lane], t[lane]))
    }

    /// Whether the light of the last [`Image::shadow`] reaches a pixel's point; false for a miss.
    #[must_use]
    pub fn is_lit(&self, x: u32, y: u32) -> bool {
        let (packet, lane) = self.packet_and_lane(x, y);
        self.lit[packet] >> lane & 1 == 1
    }

    /// A pixel's packet, and its lane there.
    fn packet_and_lane(&self, x: u32, y: u32) -> (usize, usize) {
        let tile_side = PACKET_SIDE * TILE_PACKETS;
        let tile = y / tile_side * self.width.div_ceil(tile_side) + x / tile_side;
        let (column, row) = (x / PACKET_SIDE % TILE_PACKETS, y / PACKET_SIDE % TILE_PACKETS);
        let spread = |bits: u32| bits & 1 | (bits & 2) << 1 | (bits & 4) << 2 | (bits & 8) << 3;
        let packet = tile as usize * PACKETS + (spread(column) | spread(row) << 1) as usize;
        (packet, (y % PACKET_SIDE * PACKET_SIDE + x % PACKET_SIDE) as usize)
    }
}

#[inline(always)]
fn see_tile<S: Simd>(
    _: S,
    rays: &PixelRays,
    tile: usize,
    seen: &mut [Seen],
    nearest: &impl Fn(&Valid, &mut RayHitPacket),
) {
    let mut packet = RayHitPacket::default();
    for axis in 0..3 {
        rays.origin.fill(axis, [0, 0], &rays.lanes, &mut packet.ray.origin[axis]);
    }
    for (index, seen) in seen.iter_mut().enumerate() {
        let corner = rays.corner(tile, index);
        for axis in 0..3 {
            rays.direction.fill(axis, corner, &rays.lanes, &mut packet.ray.direction[axis]);
            if rays.is_parallel {
                rays.origin.fill(axis, corner, &rays.lanes, &mut packet.ray.origin[axis]);
            }
        }
        packet.forget_hits();
        nearest(&rays.inside(corner), &mut packet);
        seen.t = packet.ray.t_far;
        seen.triangle = Posed::names(&packet.hit.primitive, &packet.hit.geometry);
    }
}

#[inline(always)]
fn shadow_tile<S: Simd>(
    _: S,
    rays: &PixelRays,
    tile: usize,
    shadows: &Shadows,
    seen: &[Seen],
    lit: &mut [u16],
    occluded: &impl Fn(&Valid, &mut RayHitPacket),
) {
    let mut packet = RayHitPacket::default();
    for axis in 0..3 {
        match shadows {
            Shadows::From(light) => packet.ray.origin[axis] = [light[axis]; WIDTH],
            Shadows::Along(along) => packet.ray.direction[axis] = [along[axis]; WIDTH],
        }
    }
    let mut point = [0.0; WIDTH];
    let mut start = rays.origin.first.to_array().map(|at| [at; WIDTH]);
    for (index, (seen, lit)) in seen.iter().zip(lit).enumerate() {
        let valid = Valid(seen.triangle.map(|triangle| if triangle == Image::NOTHING { 0 } else { -1 }));
        *lit = 0;
        if valid == Valid::NONE {
            continue;
        }
        let corner = rays.corner(tile, index);
        for axis in 0..3 {
            rays.direction.fill(axis, corner, &rays.lanes, &mut point);
            if rays.is_parallel {
                rays.origin.fill(axis, corner, &rays.lanes, &mut start[axis]);
            }
            let point = from_fn(|lane| start[axis][lane] + point[lane] * seen.t[lane]);
            match shadows {
                Shadows::From(light) => packet.ray.direction[axis] = point.map(|point| point - light[axis]),
                Shadows::Along(along) => packet.ray.origin[axis] = point.map(|point| point - along[axis]),
            }
        }
        packet.ray.t_far = [BEFORE_POINT; WIDTH];
        occluded(&valid, &mut packet);
        let is_lit = |lane: usize| valid.0[lane] != 0 && packet.ray.t_far[lane] >= 0.0;
        *lit = (0..WIDTH).fold(0, |lit, lane| lit | u16::from(is_lit(lane)) << lane);
    }
}
