use std::sync::{Mutex, PoisonError};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, u32x16};
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::parallel::Parallel;

use super::UniformGrid;
use super::bundle::{Bundle, PacketWorker, Shape};
use crate::packet::{Common, Group, LANES, Nearest, NearestBlock, Range, Space, Undecided};
use umbrage_rays::Ray;
use umbrage_rays::predicate::{crossing, settle};
use umbrage_rays::shot::{CameraRays, Counts, Opacity, OpacityOfSides, SeenPixels, Shot, TileOrder};
use umbrage_rays::simd::lanes::bits_of;

/// Half the distance from one to the next f64.
pub(super) use umbrage_rays::predicate::ROUNDING;

impl UniformGrid {
    /// Finds the triangle that each pixel of `shot` sees by tracing packets of neighbouring pixels' rays (Wald et al. 2006,
    /// §2): bit for bit the same on any number of threads and at every SIMD level. Pixels without a hit get
    /// [`SeenPixels::NONE`].
    ///
    /// The shot's triangles are those of the last [`build`](Self::build).
    pub fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Counts {
        seen.resize(shot.view.width, shot.view.height);
        self.workers.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let grid = &*self;
        let (rays, order, unit) = (CameraRays::new(shot), seen.order(), grid.unit());
        CameraTrace { grid, shot, rays, order, unit, opacity: &OpacityOfSides::of_camera(shot) }.trace(seen)
    }

    /// Calls `work` with the current thread's memory.
    pub(super) fn with_worker<T>(&self, work: impl FnOnce(&mut PacketWorker) -> T) -> T {
        // No thread waits here, since each has its own memory.
        let thread = rayon::current_thread_index().unwrap_or(self.workers.len() - 1);
        let mut worker = self.workers[thread].lock().unwrap_or_else(PoisonError::into_inner);
        work(&mut worker)
    }

    /// The power of two that scales the edge of a cell to between a half and one; the exponent is limited to ±64.
    ///
    /// f32 then holds distances of about one in a scene that reaches to 10³⁸, and their inverses; in cells it wouldn't.
    pub(super) fn unit(&self) -> f64 {
        let side = self.lattice.map_or(1.0, |lattice| lattice.side);
        // Sides of cells are normal numbers far from the ends of f64's range.
        let exponent = ((side.to_bits() >> 52) as i64 - 1022).clamp(-64, 64);
        f64::from_bits(((1023 - exponent) as u64) << 52)
    }
}

/// The search of a camera's rays.
struct CameraTrace<'a> {
    grid: &'a UniformGrid,
    shot: &'a Shot<'a>,
    rays: CameraRays,
    order: TileOrder,
    unit: f64,
    opacity: &'a dyn Opacity,
}

impl CameraTrace<'_> {
    /// Traces all tiles.
    fn trace(&self, seen: &mut SeenPixels) -> Counts {
        let tiles = seen.triangle.par_chunks_mut(TileOrder::TILE_PIXELS);
        let tiles = tiles.zip(seen.inverse_depth.par_chunks_mut(TileOrder::TILE_PIXELS));
        let counts = tiles.enumerate().with_max_len(1).map(|(tile, (triangle, inverse_depth))| {
            self.grid.with_worker(|worker| {
                dispatch!(self.grid.level, simd => self.trace_tile(simd, worker, tile, triangle, inverse_depth));
                worker.scratch.statistics.take()
            })
        });
        counts.merge(Counts::plus).unwrap_or_default()
    }

    #[inline(always)]
    fn trace_tile<S: Simd>(
        &self,
        simd: S,
        worker: &mut PacketWorker,
        tile: usize,
        triangle: &mut [u32],
        inverse_depth: &mut [f32],
    ) {
        triangle.fill(SeenPixels::NONE);
        inverse_depth.fill(f32::NAN);
        let first = tile * TileOrder::TILE_PIXELS;
        Bundle::packets_of_tile(
            self.grid.options.packet,
            #[inline(always)]
            |blocks, part| {
                self.load(simd, &mut worker.bundle, first, blocks, part);
                worker.nearest[..blocks.len()].fill(NearestBlock::EMPTY);
                while let Some((block, lane)) = worker.bundle.first_remaining() {
                    self.trace_group(simd, worker, first, (block, lane));
                    self.write(simd, worker, first, triangle, inverse_depth);
                }
            },
        );
    }

    /// Loads the rays of a packet's blocks into `bundle`.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, bundle: &mut Bundle, first: usize, blocks: &[u16], part: u16) {
        bundle.count = blocks.len();
        bundle.blocks[..blocks.len()].copy_from_slice(blocks);
        let samples = self.rays.shifts.block();
        let (all_columns, all_rows) = (samples.columns.map(f64::from), samples.rows.map(f64::from));
        for (index, &block) in blocks.iter().enumerate() {
            let (column, row) = self.order.column_and_row(first + usize::from(block) * LANES);
            for half in 0..2 {
                let lanes = half * 8..half * 8 + 8;
                let columns = f64x8::from_slice(simd, &all_columns[lanes.clone()]) + f64::from(column);
                let rows = f64x8::from_slice(simd, &all_rows[lanes.clone()]) + f64::from(row);
                for (axis, vectors) in bundle.vectors[index].iter_mut().enumerate() {
                    // The same as `CameraRays::ray`, to the last bit.
                    let CameraRays { step_x, step_y, corner, position, .. } = &self.rays;
                    let varying = columns * step_x[axis] + (rows * step_y[axis] + corner[axis]);
                    let vector = if self.rays.is_perspective { varying } else { varying - position[axis] };
                    vector.store_slice(&mut vectors[lanes.clone()]);
                }
            }
            bundle.remaining[index] = self.pixels_of_block(column, row) & part;
        }
    }

    /// The mask of the pixels in the image, for the block at a column and row.
    #[inline(always)]
    fn pixels_of_block(&self, column: u32, row: u32) -> u16 {
        let (width, height) = self.order.size();
        if column + TileOrder::BLOCK <= width && row + TileOrder::BLOCK <= height {
            return u16::MAX;
        }
        (0..LANES as u32).fold(0, |pixels, lane| {
            let (x, y) = (column + lane % TileOrder::BLOCK, row + lane / TileOrder::BLOCK);
            pixels | u16::from(x < width && y < height) << lane
        })
    }

    /// Traces the first remaining ray and those that can be traced with it.
    #[inline(always)]
    fn trace_group<S: Simd>(&self, simd: S, worker: &mut PacketWorker, first: usize, ray: (usize, usize)) {
        let PacketWorker { bundle, rays, nearest, undecided, scratch, .. } = worker;
        let is_perspective = self.rays.is_perspective;
        let group = Group::of(if is_perspective { bundle.vector(ray.0, ray.1) } else { self.rays.forward });
        bundle.start_group(simd, group, ray, is_perspective, None);
        let (space, ways) = if is_perspective { self.fan(simd, bundle) } else { self.column(simd, bundle) };
        bundle.place_rays(simd, &space, rays);
        let count = bundle.count;
        scratch.statistics.note(|counts| counts.rays += u64::from(bundle.len()));
        let (starts, within) = if is_perspective {
            ([f32::INFINITY; 2], [0.0, f64::INFINITY])
        } else {
            let error = 64.0 * ROUNDING * self.rays.largest_origin * self.unit;
            let starts = [-ways.high - error, error - ways.low].map(|nearness| nearness as f32);
            ([starts[0].next_down(), starts[1].next_up()], [ways.low - error, f64::INFINITY])
        };
        let mut query = Nearest::new(simd, rays, &mut nearest[..count], undecided, starts, self.opacity);
        self.grid.visit_slices(simd, self.shot.triangles, &space, within, scratch, &mut query);
        self.settle(worker, &space, first);
    }

    /// The space of rays from the camera, and the range of their directions along the major axis. A direction differs from
    /// the predicate's by 14 roundings of the largest one.
    #[inline(always)]
    fn fan<S: Simd>(&self, simd: S, bundle: &Bundle) -> (Space, Range) {
        let [u, v, ways] = bundle.ranges(simd, Shape::Fan);
        let slopes = [u, v];
        // Slopes are four at most, so numerator, denominator and quotient make five and a half of them.
        let error = 96.0 * ROUNDING * self.rays.largest_direction / ways.low;
        (Space::of_origin(bundle.group, self.rays.position, self.unit, slopes, error), ways)
    }

    /// The space of rays along the camera's direction, and the range of their starts along it.
    #[inline(always)]
    fn column<S: Simd>(&self, simd: S, bundle: &Bundle) -> (Space, Range) {
        let (group, direction, unit) = (bundle.group, self.rays.forward, self.unit);
        let slope = Space::slope_of(group, direction);
        let [u, v, ways] = bundle.ranges(simd, Shape::Column { slope, unit });
        let reach = self.rays.largest_origin * unit;
        let error = 64.0 * ROUNDING * reach;
        let mut space = Space::of_direction(group, direction, self.rays.position, unit, [u, v], error);
        space.start_reach = 2.0 * reach;
        (space, Range { low: ways.low * unit, high: ways.high * unit })
    }

    fn ray(&self, index: usize) -> Ray {
        let (x, y) = self.order.column_and_row(index);
        self.shot.ray(x, y)
    }

    /// Settles the undecided cases.
    fn settle(&self, worker: &mut PacketWorker, space: &Space, first: usize) {
        let PacketWorker { bundle, nearest, undecided, scratch, .. } = worker;
        for &Undecided { block, lane, triangle, high } in &*undecided {
            let (block, lane) = (usize::from(block), usize::from(lane));
            let found = &mut nearest[block];
            if high < found.low[lane] {
                continue;
            }
            let pixel = self.order.column_and_row(first + usize::from(bundle.blocks[block]) * LANES + lane);
            let best = found.triangle[lane];
            let mut settled = 0;
            if let Some(hit) = settle::nearest(self.shot, pixel, best, triangle, &mut settled) {
                let (low, high) = self.nearness(space, &self.shot.ray(pixel.0, pixel.1), hit.t);
                (found.low[lane], found.high[lane], found.triangle[lane]) = (low, high, hit.triangle);
            }
            scratch.statistics.note(|counts| counts.settled += settled);
        }
        undecided.clear();
    }

    /// Bounds of the nearness of a hit, whose t is correct to its last bit.
    fn nearness(&self, space: &Space, ray: &Ray, t: f64) -> (f32, f32) {
        let group = Group { axes: space.axes, sign: space.sign };
        let way = group.turned(ray.direction)[2] * t * self.unit;
        let (nearness, error) = match space.common {
            Common::Origin => (1.0 / way, 0.0),
            Common::Direction => {
                let start = group.turned(ray.origin - space.origin)[2] * self.unit;
                let reach = self.rays.largest_origin * self.unit + start.abs() + way.abs();
                (-(start + way), 16.0 * ROUNDING * reach)
            }
        };
        // The next f32 covers the rounding and the small errors of the rest.
        (((nearness - error) as f32).next_down(), ((nearness + error) as f32).next_up())
    }

    /// Writes the hits of the group's rays.
    #[inline(always)]
    fn write<S: Simd>(
        &self,
        simd: S,
        worker: &PacketWorker,
        first: usize,
        triangle: &mut [u32],
        inverse_depth: &mut [f32],
    ) {
        let PacketWorker { bundle, nearest, .. } = worker;
        for (block, found) in nearest[..bundle.count].iter().enumerate() {
            let start = usize::from(bundle.blocks[block]) * LANES;
            let (triangle, inverse_depth) =
                (&mut triangle[start..start + LANES], &mut inverse_depth[start..start + LANES]);
            let found_triangle = u32x16::from_slice(simd, &found.triangle);
            let none = found_triangle.simd_eq(u32x16::splat(simd, SeenPixels::NONE)).to_bitmask() as u16;
            let hit = bundle.members[block] & !none;
            if hit == 0 {
                continue;
            }
            let (inverse, exact) = self.inverse_depths(simd, bundle, block, found);
            let hits = mask32x16::from_bitmask(simd, u64::from(hit));
            hits.select(found_triangle, u32x16::from_slice(simd, triangle)).store_slice(triangle);
            hits.select(inverse, f32x16::from_slice(simd, inverse_depth)).store_slice(inverse_depth);
            for lane in bits_of(hit & !exact) {
                let corners = self.shot.triangles.corners(found.triangle[lane]);
                let crossing = crossing(&self.ray(first + start + lane), corners);
                inverse_depth[lane] = crossing.map_or(f32::NAN, |crossing| SeenPixels::inverse_of(crossing.t));
            }
        }
    }

    /// The approximate 1/t of a block's hits, and the mask of those that are exact enough.
    #[inline(always)]
    fn inverse_depths<S: Simd>(
        &self,
        simd: S,
        bundle: &Bundle,
        block: usize,
        found: &NearestBlock,
    ) -> (f32x16<S>, u16) {
        let (low, high) = (f32x16::from_slice(simd, &found.low).widen(), f32x16::from_slice(simd, &found.high).widen());
        let (first, first_exact) = self.inverse_depth(low.0, high.0, bundle.turned(simd, block, 0)[2]);
        let (second, second_exact) = self.inverse_depth(low.1, high.1, bundle.turned(simd, block, 1)[2]);
        let exact = first_exact | second_exact << 8;
        (first.narrow(second), if self.rays.is_perspective { exact as u16 } else { 0 })
    }

    /// The same for eight rays, whose directions have a component of `ways` along the major axis.
    #[inline(always)]
    fn inverse_depth<S: Simd>(&self, low: f64x8<S>, high: f64x8<S>, ways: f64x8<S>) -> (f64x8<S>, u64) {
        // The error is half of the difference, plus one rounding to f32.
        const EXACT_ENOUGH: f64 = SeenPixels::RELATIVE_ERROR as f64;
        let inverse = (low + high) * 0.5 * self.unit * ways;
        let exact = (high - low).simd_le(low * EXACT_ENOUGH) & inverse.simd_ge(1e-29) & inverse.simd_le(1e29);
        (inverse, exact.to_bitmask())
    }
}
