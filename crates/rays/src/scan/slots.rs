use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask64x8};

use super::cull::Frustum;
use super::lines::{Face, Lines};
use super::spread::TILE_LINES;
use crate::simd::lanes::{LANES, load, load_positions, quads, splat};
use crate::simd::vectors::widen;

/// Half of the lines of a block: as many f64 as a vector has.
const HALF: usize = LANES / 2;

/// The largest slope of a tile's lines. Those that are alone have at most one.
const STEEPEST: f64 = 2.0;

/// The lines of a tile: sixteen consecutive ones are a block. Lines that go nowhere and empty slots have NaN slopes.
#[derive(Debug)]
pub(super) struct Slots {
    pub(super) len: usize,
    /// Slopes, relative to the middle ones.
    pub(super) u: [f32; TILE_LINES],
    pub(super) v: [f32; TILE_LINES],
    /// Depths of the lines' start and end.
    pub(super) near: [f32; TILE_LINES],
    pub(super) end: [f32; TILE_LINES],
    /// Hits behind this depth don't matter any more.
    pub(super) far: [f32; TILE_LINES],
    /// `u`, `v`, `near` and `end` of each line.
    pub(super) quads: [[f32; 4]; TILE_LINES],
    pub(super) blocks: Blocks,
    /// The H of [`LineTests`](super::test::LineTests).
    pub(super) wide: f32,
    /// The slopes in the middle.
    pub(super) slope: [f64; 2],
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
    /// The number of lines that go nowhere.
    pub(super) nowhere: usize,
    slopes: [[[f64; HALF]; TILE_LINES / HALF]; 2],
}

/// Bounds of the slopes of each block's lines, and the largest of their `far`.
#[derive(Debug)]
pub(super) struct Blocks {
    pub(super) low: [[f32; LANES]; 2],
    pub(super) high: [[f32; LANES]; 2],
    pub(super) far: [f32; LANES],
}

impl Blocks {
    /// NaN is between no two numbers.
    const NONE: Self =
        Self { low: [[f32::NAN; LANES]; 2], high: [[f32::NAN; LANES]; 2], far: [f32::NEG_INFINITY; LANES] };
}

impl Default for Slots {
    fn default() -> Self {
        Self {
            len: 0,
            u: [0.0; TILE_LINES],
            v: [0.0; TILE_LINES],
            near: [0.0; TILE_LINES],
            end: [0.0; TILE_LINES],
            far: [0.0; TILE_LINES],
            quads: [[0.0; 4]; TILE_LINES],
            blocks: Blocks::NONE,
            wide: 0.0,
            slope: [0.0; 2],
            low: [0.0; 2],
            high: [0.0; 2],
            nowhere: 0,
            slopes: [[[0.0; HALF]; TILE_LINES / HALF]; 2],
        }
    }
}

/// The outcome of taking lines as a tile.
pub(super) enum Taken {
    /// They are on this face, in this frustum.
    On(Face, Frustum),
    /// All of them go nowhere.
    Nowhere,
    /// They are too far apart for one face.
    Apart,
}

/// Lowest and highest values, eight at a time.
struct Ends<S: Simd> {
    low: f64x8<S>,
    high: f64x8<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self { low: f64x8::splat(simd, f64::INFINITY), high: f64x8::splat(simd, f64::NEG_INFINITY) }
    }

    /// Adds the values of some lanes.
    #[inline(always)]
    fn add(&mut self, simd: S, lanes: mask64x8<S>, low: f64x8<S>, high: f64x8<S>) {
        self.low = self.low.min(lanes.select(low, f64x8::splat(simd, f64::INFINITY)));
        self.high = self.high.max(lanes.select(high, f64x8::splat(simd, f64::NEG_INFINITY)));
    }

    #[inline(always)]
    fn both(&self) -> [f64; 2] {
        let (low, high): ([f64; HALF], [f64; HALF]) = (self.low.into(), self.high.into());
        [low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    }
}

impl Slots {
    /// Replaces the lines by some of a sweep, at most [`TILE_LINES`], given by their indices.
    #[inline(always)]
    pub(super) fn take<S: Simd>(&mut self, simd: S, lines: &Lines<'_>, order: &[u32]) -> Taken {
        self.len = order.len();
        let (before, after) = order.split_at(order.len() / 2);
        let mut from_middle = after.iter().chain(before);
        let Some(face) = from_middle.find_map(|&line| Face::of(lines.get(line as usize))) else {
            self.nowhere = order.len();
            return Taken::Nowhere;
        };
        let (mut u, mut v, mut depths) = (Ends::new(simd), Ends::new(simd), Ends::new(simd));
        let (mut apart, mut going) = (0, 0);
        for (block, of_block) in order.chunks(LANES).enumerate() {
            let found = self.find_slopes(simd, lines, &face, (block, of_block), [&mut u, &mut v, &mut depths]);
            apart |= found.apart;
            going += found.going.count_ones() as usize;
        }
        if apart != 0 {
            return Taken::Apart;
        }
        self.nowhere = order.len() - going;
        let (u, v) = (u.both(), v.both());
        self.relate(simd, [u, v], order.len().div_ceil(LANES));
        Taken::On(face, Frustum::new(&face, lines.origin, [u, v], depths.both()))
    }

    /// Finds the slopes of a block's lines on a face, and their ends.
    #[inline(always)]
    fn find_slopes<S: Simd>(
        &mut self,
        simd: S,
        lines: &Lines<'_>,
        face: &Face,
        (block, order): (usize, &[u32]),
        [u_ends, v_ends, depths]: [&mut Ends<S>; 3],
    ) -> Found {
        let mut directions = [[f32::NAN; LANES]; 3];
        for (lane, &line) in order.iter().enumerate() {
            let direction = lines.directions[line as usize];
            (directions[0][lane], directions[1][lane], directions[2][lane]) = (direction.x, direction.y, direction.z);
        }
        let [i, j, k] = face.axes;
        let halves = widen(load_positions(simd, &[directions[i], directions[j], directions[k]]));
        let (infinity, steepest) = (f64x8::splat(simd, f64::INFINITY), f64x8::splat(simd, STEEPEST));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let mut found = Found { apart: 0, going: 0 };
        let mut ends = [[zero; 2]; 2];
        for (half, [x, y, z]) in halves.into_iter().enumerate() {
            let unit = z * face.sign;
            let size = x.abs() + y.abs() + unit.abs();
            let going = size.simd_gt(zero) & size.simd_lt(infinity);
            let inverse = one / unit;
            let (u, v) = (x * inverse, y * inverse);
            let fits = unit.simd_gt(zero) & u.abs().simd_le(steepest) & v.abs().simd_le(steepest);
            found.apart |= (going & !fits).to_bitmask();
            found.going |= going.to_bitmask() << (half * HALF);
            let (start, end) = (unit * lines.t_min, unit * lines.t_max);
            u_ends.add(simd, going, u, u);
            v_ends.add(simd, going, v, v);
            depths.add(simd, going, start, end);
            let nan = f64x8::splat(simd, f64::NAN);
            self.slopes[0][2 * block + half] = going.select(u, nan).into();
            self.slopes[1][2 * block + half] = going.select(v, nan).into();
            ends[0][half] = start * lines.scale;
            ends[1][half] = end * lines.scale;
        }
        let (near, end) = (ends[0][0].narrow(ends[0][1]), ends[1][0].narrow(ends[1][1]));
        let (least, most) = (splat(simd, f32::MIN), splat(simd, f32::MAX));
        let slots = block * LANES..(block + 1) * LANES;
        near.max(least).min(most).store_slice(&mut self.near[slots.clone()]);
        end.max(least).min(most).store_slice(&mut self.end[slots]);
        found
    }

    /// Relates slopes to the middle of their bounds.
    #[inline(always)]
    fn relate<S: Simd>(&mut self, simd: S, bounds: [[f64; 2]; 2], blocks: usize) {
        self.slope = bounds.map(|[low, high]| 0.5 * (low + high));
        let half = bounds.map(|[low, high]| 0.5 * (high - low));
        self.wide = (half[0].max(half[1]) * 1.001 + 1.0 / f64::from(1 << 20)) as f32;
        // Rounding keeps their order.
        self.low = [0, 1].map(|axis| (bounds[axis][0] - self.slope[axis]) as f32);
        self.high = [0, 1].map(|axis| (bounds[axis][1] - self.slope[axis]) as f32);
        self.blocks = Blocks::NONE;
        for block in 0..blocks {
            let (u, v) = (self.related(simd, 0, block), self.related(simd, 1, block));
            let is_line = u.simd_eq(u);
            let slots = block * LANES..(block + 1) * LANES;
            u.store_slice(&mut self.u[slots.clone()]);
            v.store_slice(&mut self.v[slots.clone()]);
            let (lowest, highest) = (splat(simd, f32::NEG_INFINITY), splat(simd, f32::INFINITY));
            is_line.select(highest, lowest).store_slice(&mut self.far[slots.clone()]);
            self.blocks.low[0][block] = is_line.select(u, highest).reduce_min();
            self.blocks.low[1][block] = is_line.select(v, highest).reduce_min();
            self.blocks.high[0][block] = is_line.select(u, lowest).reduce_max();
            self.blocks.high[1][block] = is_line.select(v, lowest).reduce_max();
            self.blocks.far[block] = f32::INFINITY;
            let near = f32x16::from_slice(simd, &self.near[slots.clone()]);
            let end = f32x16::from_slice(simd, &self.end[slots.clone()]);
            let to = self.quads[slots].as_flattened_mut().chunks_exact_mut(LANES);
            for (quad, to) in quads([u, v, near, end]).into_iter().zip(to) {
                quad.store_slice(to);
            }
        }
    }

    /// The slopes of a block along an axis, relative to the middle.
    #[inline(always)]
    fn related<S: Simd>(&self, simd: S, axis: usize, block: usize) -> f32x16<S> {
        let middle = f64x8::splat(simd, self.slope[axis]);
        let low = f64x8::simd_from(simd, self.slopes[axis][2 * block]) - middle;
        let high = f64x8::simd_from(simd, self.slopes[axis][2 * block + 1]) - middle;
        low.narrow(high)
    }

    /// The depth behind which hits don't matter to any line.
    #[inline(always)]
    pub(super) fn farthest<S: Simd>(&self, simd: S) -> f32 {
        load(simd, &self.blocks.far).reduce_max()
    }

    /// Notes that lines of a block may have been hit.
    #[inline(always)]
    pub(super) fn find_far<S: Simd>(&mut self, simd: S, block: usize) {
        let far = f32x16::from_slice(simd, &self.far[block * LANES..(block + 1) * LANES]);
        self.blocks.far[block] = far.reduce_max();
    }
}

/// Lines of a block, a bit each.
struct Found {
    /// Some of those that don't fit on the face.
    apart: u64,
    /// Those with a direction.
    going: u64,
}
