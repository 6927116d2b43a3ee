use std::sync::Mutex;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16};
use glam::DVec3;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::parallel::Parallel;

use super::UniformGrid;
use super::bundle::{Bundle, PacketWorker, Shape, eight, members_of};
use super::see::ROUNDING;
use crate::packet::{AnyHit, AnyHitBlock, Common, Group, LANES, Points, Range, Space};
use umbrage_rays::LightSource;
use umbrage_rays::SingleRays;
use umbrage_rays::predicate::settle;
use umbrage_rays::shot::{
    CameraRays, Counts, EightPoints, LightMask, Opacity, OpacityOfSides, SeenImage, SeenPixels, Shot, TileOrder,
};
use umbrage_rays::simd::lanes::bits_of;

/// Words of a tile: one for each block.
const TILE_BLOCKS: usize = TileOrder::TILE_PIXELS / TileOrder::BLOCK_PIXELS;

impl UniformGrid {
    /// Finds the points seen by the pixels of `shot` that are lit by `light`.
    ///
    /// A point is lit unless a triangle other than its own blocks the light there, by
    /// [`ShadowRay::blocked_by`](umbrage_rays::predicate::ShadowRay::blocked_by) and by the shot's `shadow_opacity`.
    ///
    /// Packets are those of the pixels, with rays from the light (Wald et al. 2006, §4.6). They are split where distances to
    /// the camera, or directions from the light, spread too far.
    ///
    /// # Panics
    /// If `seen` isn't of the size of the shot's view.
    pub fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) -> Counts {
        shot.expect_size(seen);
        mask.resize(seen.order());
        self.workers.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let grid = &*self;
        let origin = match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3(),
            LightSource::Directional { .. } => self.bounds.center().as_dvec3(),
        };
        let (image, rays, unit) = (SeenImage { shot, seen }, CameraRays::new(shot), grid.unit());
        let opacity = OpacityOfSides::of_light(shot, light);
        LightTrace { grid, image, light, opacity, origin, rays, unit }.trace(mask.blocks_mut())
    }
}

/// The search of a light's rays.
struct LightTrace<'a> {
    grid: &'a UniformGrid,
    image: SeenImage<'a>,
    light: &'a LightSource,
    opacity: OpacityOfSides<'a>,
    /// The light's position, or for a light infinitely far away any origin for points.
    origin: DVec3,
    rays: CameraRays,
    unit: f64,
}

impl LightTrace<'_> {
    /// Traces all tiles.
    fn trace(&self, blocks: &mut [u16]) -> Counts {
        let counts = blocks.par_chunks_mut(TILE_BLOCKS).enumerate().with_max_len(1).map(|(tile, lit)| {
            self.grid.with_worker(|worker| {
                dispatch!(self.grid.level, simd => self.trace_tile(simd, worker, tile, lit));
                worker.scratch.statistics.take()
            })
        });
        counts.merge(Counts::plus).unwrap_or_default()
    }

    #[inline(always)]
    fn trace_tile<S: Simd>(&self, simd: S, worker: &mut PacketWorker, tile: usize, lit: &mut [u16]) {
        lit.fill(0);
        let first = tile * TileOrder::TILE_PIXELS;
        Bundle::packets_of_tile(
            self.grid.options.packet,
            #[inline(always)]
            |blocks, part| {
                self.load(simd, worker, first, blocks, part);
                let points = worker.bundle.members;
                while let Some((block, lane)) = worker.bundle.first_remaining() {
                    self.trace_group(simd, worker, first, (block, lane));
                }
                for (index, &block) in blocks.iter().enumerate() {
                    lit[usize::from(block)] |= points[index] & !worker.any_hit[index].shadowed;
                }
            },
        );
    }

    /// Loads the points of a packet's blocks into the worker's bundle, as remaining rays and members. Points with an
    /// uncertain position are decided one by one.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, worker: &mut PacketWorker, first: usize, blocks: &[u16], part: u16) {
        let PacketWorker { bundle, any_hit, .. } = worker;
        bundle.count = blocks.len();
        bundle.blocks[..blocks.len()].copy_from_slice(blocks);
        let seen = self.image.seen;
        for (index, &block) in blocks.iter().enumerate() {
            let start = first + usize::from(block) * LANES;
            let found = &mut any_hit[index];
            *found = AnyHitBlock::EMPTY;
            found.own.copy_from_slice(&seen.triangle[start..start + LANES]);
            bundle.inverse_depths[index].copy_from_slice(&seen.inverse_depth[start..start + LANES]);
            let shown = SeenPixels::shown_of(&found.own) & part;
            let certain = if shown == 0 { 0 } else { self.locate(simd, bundle, index, start) };
            for lane in bits_of(shown & !certain) {
                found.shadowed |= u16::from(self.is_shadowed(start + lane)) << lane;
            }
            bundle.members[index] = shown;
            bundle.remaining[index] = shown & certain;
        }
    }

    /// Finds the positions of a block's points; returns the mask of certain ones.
    #[inline(always)]
    fn locate<S: Simd>(&self, simd: S, bundle: &mut Bundle, block: usize, start: usize) -> u16 {
        let mut certain = 0;
        for half in 0..2 {
            let indices = std::array::from_fn(|lane| (start + half * 8 + lane) as u32);
            let points = EightPoints::find(simd, &self.image, &self.rays, indices, self.origin);
            let lanes = half * 8..half * 8 + 8;
            for axis in 0..3 {
                points.offset[axis].store_slice(&mut bundle.vectors[block][axis][lanes.clone()]);
            }
            points.error.store_slice(&mut bundle.errors[block][lanes.clone()]);
            points.predicate_error.store_slice(&mut bundle.predicate_errors[block][lanes.clone()]);
            certain |= (points.certain.to_bitmask() as u16) << (half * 8);
        }
        certain
    }

    /// Whether a pixel's point is in shadow, by a single ray.
    #[cold]
    #[inline(never)]
    fn is_shadowed(&self, index: usize) -> bool {
        let SeenImage { shot, seen } = self.image;
        let opacity: &dyn Opacity = &self.opacity;
        let stops = |id: u32, barycentric: [f32; 2]| opacity.is_stopped_at(id, barycentric);
        let ray = shot.shadow_ray(seen, index, self.light);
        ray.is_some_and(|ray| self.grid.blocked(shot.triangles, &ray, seen.triangle[index], &stops))
    }

    /// Traces the first remaining ray and those that can be traced with it.
    #[inline(always)]
    fn trace_group<S: Simd>(&self, simd: S, worker: &mut PacketWorker, first: usize, (block, lane): (usize, usize)) {
        let bundle = &mut worker.bundle;
        let direction = match *self.light {
            LightSource::Directional { direction } => direction.as_dvec3(),
            LightSource::Point { .. } | LightSource::Spot { .. } => bundle.vector(block, lane),
        };
        let group = Group::of(direction);
        let is_parallel = matches!(self.light, LightSource::Directional { .. });
        bundle.start_group(simd, group, (block, lane), !is_parallel, Some(self.grid.options.shadow_spread));
        let packet = if group.has(direction) {
            Some(if is_parallel { self.column(simd, bundle, direction) } else { self.fan(simd, bundle) })
        } else {
            None
        };
        match packet.filter(Packet::is_usable) {
            Some(packet) => self.trace_packet(simd, worker, first, &packet),
            None => {
                for (block, lane) in bundle.members() {
                    let index = first + usize::from(bundle.blocks[block]) * LANES + lane;
                    worker.any_hit[block].shadowed |= u16::from(self.is_shadowed(index)) << lane;
                }
            }
        }
    }

    #[inline(always)]
    fn trace_packet<S: Simd>(&self, simd: S, worker: &mut PacketWorker, first: usize, packet: &Packet) {
        let PacketWorker { bundle, rays, any_hit, undecided_shadows, scratch, .. } = worker;
        let Packet { space, within, limit_error } = packet;
        bundle.place_rays(simd, space, rays);
        for (block, found) in any_hit[..bundle.count].iter_mut().enumerate() {
            let low = space.nearness_of_eight(bundle.turned(simd, block, 0)[2] * self.unit);
            let high = space.nearness_of_eight(bundle.turned(simd, block, 1)[2] * self.unit);
            let is_member = mask32x16::from_bitmask(simd, u64::from(bundle.members[block]));
            let limit = is_member.select(low.narrow(high), f32x16::from_slice(simd, &found.limit));
            limit.store_slice(&mut found.limit);
        }
        let count = bundle.count;
        scratch.statistics.note(|counts| counts.rays += u64::from(bundle.len()));
        let shot = self.image.shot;
        let mut query = AnyHit::new(simd, rays, &mut any_hit[..count], undecided_shadows, *limit_error, &self.opacity);
        self.grid.visit_slices(simd, shot.triangles, space, *within, scratch, &mut query);
        self.settle(worker, first);
    }

    /// The space of rays from a light to the group's points.
    #[inline(always)]
    fn fan<S: Simd>(&self, simd: S, bundle: &Bundle) -> Packet {
        let [u, v, ways] = bundle.ranges(simd, Shape::Fan);
        let (slopes, errors) = ([u, v], Errors::of(simd, bundle));
        // Slopes are four at most, so their error is five times that of points, relative to w, plus a few roundings.
        let relative = errors.of_points / ways.low;
        let space = Space::of_origin(bundle.group, self.origin, self.unit, slopes, 5.5 * relative + 32.0 * ROUNDING);
        let nearest = 1.0 / (ways.low * self.unit);
        // Three roundings to f32.
        let limit_error = nearest * (1.1 * relative + 4.0 * f64::from(f32::EPSILON));
        self.packet(space, &errors, ways, [0.0, ways.high], limit_error)
    }

    /// The space of rays along a light's direction to the group's points.
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, bundle: &Bundle, direction: DVec3) -> Packet {
        let slope = Space::slope_of(bundle.group, direction);
        let unit = self.unit;
        let [u, v, ways] = bundle.ranges(simd, Shape::Column { slope, unit });
        let (middle, errors) = ([u, v], Errors::of(simd, bundle));
        // Slopes are one at most.
        let error = (2.0 * errors.of_points + 8.0 * ROUNDING * errors.reach) * self.unit;
        let space = Space::of_direction(bundle.group, direction, self.origin, unit, middle, error);
        let farthest = ways.low.abs().max(ways.high.abs());
        let limit_error = (1.1 * errors.of_points + 4.0 * f64::from(f32::EPSILON) * farthest) * self.unit;
        self.packet(space, &errors, ways, [f64::NEG_INFINITY, ways.high], limit_error)
    }

    fn packet(&self, mut space: Space, errors: &Errors, ways: Range, within: [f64; 2], limit_error: f64) -> Packet {
        let Errors { of_points, of_predicate, reach } = *errors;
        space.points =
            Some(Points { error: of_predicate * self.unit, reach: reach * self.unit, nearest: ways.low * self.unit });
        if space.common == Common::Direction {
            space.start_reach = reach * self.unit;
        }
        // The farthest possible positions of the predicate's points, plus a little for roundings.
        let last = within[1] + 2.0 * of_points + within[1].abs() * 1e-12;
        let within = [within[0], last * self.unit];
        Packet { space, within, limit_error: (limit_error as f32).next_up() }
    }

    /// Settles the undecided cases.
    fn settle(&self, worker: &mut PacketWorker, first: usize) {
        let PacketWorker { bundle, any_hit, undecided_shadows, scratch, .. } = worker;
        // Sorted by pixel, so that each shadow ray is found once.
        undecided_shadows.sort_unstable();
        let mut shadows = settle::Shadows::new(&self.opacity);
        for &(block, lane, id) in &*undecided_shadows {
            let found = &mut any_hit[usize::from(block)];
            if found.shadowed >> lane & 1 == 1 {
                continue;
            }
            scratch.statistics.note(|counts| counts.settled += 1);
            let index = first + usize::from(bundle.blocks[usize::from(block)]) * LANES + usize::from(lane);
            let ray = || self.image.shot.shadow_ray(self.image.seen, index, self.light);
            found.shadowed |= u16::from(shadows.is_shadowed_by(index, id, ray)) << lane;
        }
        undecided_shadows.clear();
    }
}

/// The largest errors of a group's points, and their largest distance from the origin on any axis.
#[derive(Clone, Copy)]
struct Errors {
    of_points: f64,
    of_predicate: f64,
    reach: f64,
}

impl Errors {
    #[inline(always)]
    fn of<S: Simd>(simd: S, bundle: &Bundle) -> Self {
        let zero = f64x8::splat(simd, 0.0);
        let [mut of_points, mut of_predicate, mut reach] = [zero; 3];
        for block in 0..bundle.count {
            for half in 0..2 {
                let is_member = members_of(simd, bundle.members[block], half);
                let [u, v, w] = bundle.turned(simd, block, half);
                let farthest = u.abs().max(v.abs()).max(w.abs());
                of_points = of_points.max(is_member.select(eight(simd, &bundle.errors[block], half), zero));
                of_predicate =
                    of_predicate.max(is_member.select(eight(simd, &bundle.predicate_errors[block], half), zero));
                reach = reach.max(is_member.select(farthest, zero));
            }
        }
        Self { of_points: of_points.reduce_max(), of_predicate: of_predicate.reduce_max(), reach: reach.reduce_max() }
    }
}

/// Shadow rays traced together.
struct Packet {
    space: Space,
    /// The first and the last w of the rays.
    within: [f64; 2],
    /// Error bound of the nearness of their end points.
    limit_error: f32,
}

impl Packet {
    /// Whether the points' errors are so small, relative to their distance, that the error bounds hold.
    fn is_usable(&self) -> bool {
        self.space.ray_error < 0.01 && self.limit_error.is_finite() && self.within[1].is_finite()
    }
}
