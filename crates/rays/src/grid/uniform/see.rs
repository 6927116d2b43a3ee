use std::sync::{Mutex, PoisonError};

use fearless_simd::{Simd, dispatch};
use glam::DVec2;
use rayon::prelude::*;

use super::UniformGrid;
use super::bundle::{Bundle, Worker};
use super::statistics::UniformCounts;
use crate::grid::light::survey::CameraRays;
use crate::grid::{Mask, SeenImage, SeenPixels, TileOrder};
use crate::packet::{Common, Doubt, Group, LANES, Nearest, NearestBlock, Range, RayBlock, Space};
use crate::predicate::{crossing, hit};
use crate::{Hit, Ray, Triangles, View};

/// Half the distance from one to the next f64.
pub(super) const ROUNDING: f64 = f64::EPSILON / 2.0;

impl UniformGrid {
    /// Finds what each pixel sees by tracing packets of neighbouring pixels' rays (Wald et al. 2006, §2): bit for bit the
    /// same on any number of threads and at every SIMD level. Pixels that hit nothing see [`SeenPixels::NONE`].
    ///
    /// `triangles` are those of the last [`build`](Self::build); rays go through each pixel at `offset_pixels`, from (0, 0)
    /// for its upper left corner to (1, 1). Triangles for which `is_opaque` is false are hit where `mask` says that they
    /// are solid.
    #[expect(clippy::needless_pass_by_value, reason = "masks are small and written where they are passed")]
    pub fn see(
        &mut self,
        triangles: Triangles<'_>,
        view: &View,
        offset_pixels: DVec2,
        is_opaque: impl Fn(u32) -> bool + Sync,
        mask: impl Mask,
        seen: &mut SeenPixels,
    ) -> UniformCounts {
        seen.resize(view.width, view.height);
        let rays = CameraRays::new(&SeenImage { triangles, view: *view, offset_pixels, seen });
        self.workers.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let grid = &*self;
        let order = seen.order();
        let camera = CameraTrace {
            grid,
            triangles,
            view,
            offset_pixels,
            rays,
            order,
            unit: grid.unit(),
            is_opaque: &is_opaque,
            mask: &mask,
        };
        camera.trace(seen)
    }

    /// Calls `work` with the current thread's memory.
    pub(super) fn with_worker<T>(&self, work: impl FnOnce(&mut Worker) -> T) -> T {
        // A thread waits for nobody here, since each has its own.
        let thread = rayon::current_thread_index().unwrap_or(self.workers.len() - 1);
        let mut worker = self.workers[thread].lock().unwrap_or_else(PoisonError::into_inner);
        work(&mut worker)
    }

    /// The power of two that brings the edge of a cell to between a half and one.
    pub(super) fn unit(&self) -> f64 {
        let side = self.lattice.map_or(1.0, |lattice| lattice.side);
        // Sides of cells are normal numbers far from the ends of f64's range.
        let exponent = (side.to_bits() >> 52) as i64 - 1022;
        f64::from_bits(((1023 - exponent) as u64) << 52)
    }
}

/// The search of a camera's rays.
struct CameraTrace<'a> {
    grid: &'a UniformGrid,
    triangles: Triangles<'a>,
    view: &'a View,
    offset_pixels: DVec2,
    rays: CameraRays,
    order: TileOrder,
    unit: f64,
    is_opaque: &'a (dyn Fn(u32) -> bool + Sync),
    mask: &'a dyn Mask,
}

impl CameraTrace<'_> {
    /// Traces all tiles. Knows callbacks by reference, so that this is compiled once.
    fn trace(&self, seen: &mut SeenPixels) -> UniformCounts {
        let tiles = seen.triangle.par_chunks_mut(TileOrder::TILE_PLACES);
        let tiles = tiles.zip(seen.inverse_depth.par_chunks_mut(TileOrder::TILE_PLACES));
        let counts = tiles.enumerate().with_max_len(1).map(|(tile, (triangle, inverse_depth))| {
            self.grid.with_worker(|worker| {
                let level = self.grid.level.into();
                dispatch!(level, simd => self.trace_tile(simd, worker, tile, triangle, inverse_depth));
                worker.scratch.statistics.take()
            })
        });
        counts.reduce(UniformCounts::default, UniformCounts::plus)
    }

    #[inline(always)]
    fn trace_tile<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        tile: usize,
        triangle: &mut [u32],
        inverse_depth: &mut [f32],
    ) {
        triangle.fill(SeenPixels::NONE);
        inverse_depth.fill(f32::NAN);
        let first = tile * TileOrder::TILE_PLACES;
        Bundle::packets_of_tile(
            self.grid.options.packet,
            #[inline(always)]
            |blocks, part| {
                self.load(&mut worker.bundle, first, blocks, part);
                worker.nearest[..blocks.len()].fill(NearestBlock::EMPTY);
                while let Some((block, lane)) = worker.bundle.first_remaining() {
                    self.trace_group(simd, worker, first, (block, lane));
                    self.write(worker, first, triangle, inverse_depth);
                }
            },
        );
    }

    /// Brings the rays of a packet's blocks to `bundle`.
    #[inline(always)]
    fn load(&self, bundle: &mut Bundle, first: usize, blocks: &[u16], part: u16) {
        bundle.count = blocks.len();
        bundle.blocks[..blocks.len()].copy_from_slice(blocks);
        let (width, height) = self.order.size();
        for (place, &block) in blocks.iter().enumerate() {
            let (column, row) = self.order.column_and_row(first + usize::from(block) * LANES);
            let [xs, ys, zs] = &mut bundle.vectors[place];
            let mut inside = 0;
            for lane in 0..LANES {
                let (x, y) = (column + lane as u32 % TileOrder::BLOCK, row + lane as u32 / TileOrder::BLOCK);
                inside |= u16::from(x < width && y < height) << lane;
                let (origin, direction) = self.rays.ray(f64::from(x), f64::from(y));
                let vector = if self.rays.is_perspective { direction } else { origin - self.rays.position };
                (xs[lane], ys[lane], zs[lane]) = (vector.x, vector.y, vector.z);
            }
            bundle.remaining[place] = inside & part;
        }
    }

    /// Traces the rays that can be traced with the first that is left.
    #[inline(always)]
    fn trace_group<S: Simd>(&self, simd: S, worker: &mut Worker, first: usize, ray: (usize, usize)) {
        let Worker { bundle, rays, nearest, doubts, scratch, .. } = worker;
        let is_perspective = self.rays.is_perspective;
        let group = Group::of(if is_perspective { bundle.vector(ray.0, ray.1) } else { self.rays.forward });
        bundle.start_group(group, ray, |bundle, block, lane| !is_perspective || group.has(bundle.vector(block, lane)));
        let (space, ways) = if is_perspective { self.fan(bundle, group) } else { self.column(bundle, group) };
        place_rays(bundle, &space, rays);
        let count = bundle.count;
        scratch.statistics.rays(bundle.len());
        let (starts, within) = if is_perspective {
            ([f32::INFINITY; 2], [0.0, f64::INFINITY])
        } else {
            let error = 64.0 * ROUNDING * self.rays.largest_origin * self.unit;
            let starts = [-ways.high - error, error - ways.low].map(|nearness| nearness as f32);
            ([starts[0].next_down(), starts[1].next_up()], [ways.low - error, f64::INFINITY])
        };
        let is_opaque = self.is_opaque;
        let mut query =
            Nearest { rays: &rays[..count], found: &mut nearest[..count], doubts, starts, is_opaque, least: 0.0 };
        query.start();
        self.grid.visit_slices(simd, self.triangles, &space, within, scratch, &mut query);
        self.settle(worker, &space, first);
    }

    /// The space of rays from the camera, and how far their directions go along the major axis. A direction differs from the predicate's by 14 roundings of the largest one.
    #[inline(always)]
    fn fan(&self, bundle: &Bundle, group: Group) -> (Space, Range) {
        let [u, v, ways] = bundle.ranges(|[u, v, w]| [u / w, v / w, w]);
        let slopes = [u, v];
        // Slopes are four at most, so that numerator, denominator and quotient make five of them and a half.
        let error = 96.0 * ROUNDING * self.rays.largest_direction / ways.low;
        (Space::of_origin(group, self.rays.position, self.unit, slopes, error), ways)
    }

    /// The space of rays along the camera's direction, and from where to where along it they start.
    #[inline(always)]
    fn column(&self, bundle: &Bundle, group: Group) -> (Space, Range) {
        let direction = self.rays.forward;
        let slope = Space::slope_of(group, direction);
        let [u, v, ways] = bundle.ranges(|vector| {
            let [u, v, w] = vector.map(|coordinate| coordinate * self.unit);
            [u - slope[0] * w, v - slope[1] * w, w]
        });
        let places = [u, v];
        let error = 64.0 * ROUNDING * self.rays.largest_origin * self.unit;
        (Space::of_direction(group, direction, self.rays.position, self.unit, places, error), ways)
    }

    fn ray(&self, place: usize) -> Ray {
        let (x, y) = self.order.column_and_row(place);
        self.view.ray(f64::from(x) + self.offset_pixels.x, f64::from(y) + self.offset_pixels.y)
    }

    /// Has the predicate decide what is in doubt.
    fn settle(&self, worker: &mut Worker, space: &Space, first: usize) {
        let Worker { bundle, nearest, doubts, scratch, .. } = worker;
        for &Doubt { block, lane, triangle, high } in &*doubts {
            let (block, lane) = (usize::from(block), usize::from(lane));
            let found = &mut nearest[block];
            let best = found.triangle[lane];
            if high < found.low[lane] || best == triangle {
                continue;
            }
            // A copy of the best with a higher id never wins.
            if best < triangle && self.triangles.corners(best) == self.triangles.corners(triangle) {
                continue;
            }
            scratch.statistics.asked();
            let ray = self.ray(first + usize::from(bundle.blocks[block]) * LANES + lane);
            let is_there = |hit: &Hit| (self.is_opaque)(triangle) || self.mask.is_solid(hit);
            let Some(new) = hit(&ray, self.triangles, triangle).filter(is_there) else { continue };
            let old = if best == SeenPixels::NONE { None } else { hit(&ray, self.triangles, best) };
            if old.is_none_or(|old| (new.t, new.triangle) < (old.t, old.triangle)) {
                let (low, high) = self.nearness(space, &ray, new.t);
                (found.low[lane], found.high[lane], found.triangle[lane]) = (low, high, triangle);
            }
        }
        doubts.clear();
    }

    /// Bounds of the nearness of a hit, whose t is right to its last bit.
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
        // The next number covers the rounding and what little the others leave.
        (((nearness - error) as f32).next_down(), ((nearness + error) as f32).next_up())
    }

    /// Writes what the group's rays see.
    #[inline(always)]
    fn write(&self, worker: &Worker, first: usize, triangle: &mut [u32], inverse_depth: &mut [f32]) {
        let Worker { bundle, nearest, .. } = worker;
        for (block, lane) in bundle.members() {
            let found = &nearest[block];
            if found.triangle[lane] != SeenPixels::NONE {
                let place = usize::from(bundle.blocks[block]) * LANES + lane;
                let way = bundle.vector(block, lane)[bundle.group.axes[2]] * bundle.group.sign;
                triangle[place] = found.triangle[lane];
                inverse_depth[place] = self.inverse_depth(found, lane, way, first + place);
            }
        }
    }

    /// About one over the t of what a ray sees, given how far its direction goes along the major axis.
    #[inline(always)]
    fn inverse_depth(&self, found: &NearestBlock, lane: usize, way: f64, place: usize) -> f32 {
        let (low, high) = (f64::from(found.low[lane]), f64::from(found.high[lane]));
        // Half of the difference is the error, to which one rounding to f32 comes.
        const EXACT_ENOUGH: f64 = SeenPixels::RELATIVE_ERROR as f64;
        if self.rays.is_perspective && high - low <= EXACT_ENOUGH * low {
            let inverse = 0.5 * (low + high) * self.unit * way;
            if (1e-29..=1e29).contains(&inverse) {
                return inverse as f32;
            }
        }
        let corners = self.triangles.corners(found.triangle[lane]);
        crossing(&self.ray(place), corners).map_or(f32::NAN, |crossing| SeenPixels::inverse_of(crossing.t))
    }
}

/// Writes where the members of a group are in the packet's space.
#[inline(always)]
pub(super) fn place_rays(bundle: &Bundle, space: &Space, rays: &mut [RayBlock]) {
    for (block, rays) in rays[..bundle.count].iter_mut().enumerate() {
        rays.members = bundle.members[block];
        let [u, v, w] = bundle.group.axes.map(|axis| &bundle.vectors[block][axis]);
        // All lanes, so that they are handled together.
        for lane in 0..LANES {
            let w = w[lane] * bundle.group.sign;
            let ray = match space.common {
                Common::Origin => [u[lane] / w, v[lane] / w],
                Common::Direction => {
                    let [u, v, w] = [u[lane], v[lane], w].map(|coordinate| coordinate * space.unit);
                    [u - space.slope[0] * w, v - space.slope[1] * w]
                }
            };
            let place = space.place(ray);
            let is_member = rays.members >> lane & 1 == 1;
            (rays.x[lane], rays.y[lane]) = if is_member { (place[0], place[1]) } else { (0.0, 0.0) };
        }
    }
}
