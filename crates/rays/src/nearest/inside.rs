//! Crossings of the ray from a point along x, and triangles.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::Job;
use super::block::{Around, BLOCK, BlockWorker};
use super::exact::crosses;
use super::filter::FARTHEST;
use crate::patches::SixteenBoxes;
use crate::simd::lanes::{LANES, bits_of, load, load_local_corner, splat};
use crate::vectorized;

/// More than the rounding errors of an edge function, of the sum of its terms' magnitudes.
const ERROR: f32 = 16.0 / (1 << 24) as f32;

/// More than an edge function loses to underflow, for numbers below [`FARTHEST`].
const SMALLEST: f32 = 1e-30;

/// Sixteen triangles, and the signs of how a ray crosses them.
struct Crossings {
    /// Certainly crossed.
    crossed: u16,
    /// Neither that, nor certainly missed.
    undecided: u16,
}

impl BlockWorker {
    /// Tells which points, given by the lower halves of `order`, are inside of closed meshes: at most [`BLOCK`].
    pub(super) fn find_inside<S: Simd>(&mut self, simd: S, job: &Job<'_>, order: &[u64], inside: &mut [bool]) {
        let (around, _) = self.fill(job, order, None);
        let mut odd = 0;
        if self.filled != 0 {
            self.count(simd, job, &around, (job.boxes.top(), 0), &mut odd);
        }
        for (slot, inside) in inside.iter_mut().enumerate() {
            *inside = odd >> slot & 1 == 1;
        }
    }

    /// Counts the crossings with triangles below a node of the tree, modulo two.
    fn count<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        around: &Around,
        (level, number): (usize, usize),
        odd: &mut u64,
    ) {
        let (boxes, count) = job.boxes.node(job.patches, level, number);
        let ahead = vectorized!(simd => around.ahead(simd, job.scale, boxes));
        for lane in bits_of(ahead & (u16::MAX >> (LANES - count))) {
            let below = number * LANES + lane;
            if level == 0 {
                vectorized!(simd => self.cross(simd, job, below, odd));
            } else {
                self.count(simd, job, around, (level - 1, below), odd);
            }
        }
    }

    /// Counts the crossings with a patch's triangles.
    #[inline(always)]
    fn cross<S: Simd>(&mut self, simd: S, job: &Job<'_>, number: usize, odd: &mut u64) {
        let [low, high] = job.patches.bounds.sixteens[number / LANES].get(number);
        let scale = job.scale;
        let low = [low[0] * scale, low[1] * scale, low[2] * scale];
        let behind = self.behind(simd, [low, [high[0] * scale, high[1] * scale, high[2] * scale]]);
        if behind == 0 {
            return;
        }
        self.scale_vertices(simd, job, number);
        let patch = job.patches.get(number);
        for (sixteen, corners) in patch.corners.chunks_exact(LANES).enumerate() {
            let first = sixteen * LANES;
            let corners = [
                load_local_corner(simd, &self.vertices, corners, 0),
                load_local_corner(simd, &self.vertices, corners, 1),
                load_local_corner(simd, &self.vertices, corners, 2),
            ];
            let filled = u16::MAX >> (LANES - (patch.count - first).min(LANES));
            for slot in bits_of(behind) {
                let point = [self.points[0][slot], self.points[1][slot], self.points[2][slot]];
                let Crossings { crossed, undecided } = test(simd, &corners, point);
                let mut count = (crossed & filled).count_ones();
                for lane in bits_of(undecided & filled) {
                    let corners = job.triangles.corners(patch.ids[first + lane]);
                    let is_finite = corners.iter().all(|corner| corner.is_finite());
                    count += u32::from(is_finite && crosses(self.positions[slot], corners));
                }
                *odd ^= u64::from(count & 1) << slot;
            }
        }
    }

    /// The slots of points from which a ray along x may meet a box, which includes its sides; a box of NaN is met by all.
    #[inline(always)]
    fn behind<S: Simd>(&self, simd: S, [low, high]: [[f32; 3]; 2]) -> u64 {
        let mut behind = 0;
        for start in (0..BLOCK).step_by(LANES) {
            let [x, y, z] = self.load_points(simd, start);
            let beside = x.simd_gt(splat(simd, high[0]))
                | y.simd_gt(splat(simd, high[1]))
                | z.simd_gt(splat(simd, high[2]))
                | y.simd_lt(splat(simd, low[1]))
                | z.simd_lt(splat(simd, low[2]));
            behind |= (!beside.to_bitmask() & 0xffff) << start;
        }
        behind & self.filled
    }
}

impl Around {
    /// A mask of the boxes, of sixteen, that rays along x from the points may meet.
    #[inline(always)]
    fn ahead<S: Simd>(&self, simd: S, scale: f32, boxes: &SixteenBoxes) -> u16 {
        let scale = splat(simd, scale);
        let [_, low_y, low_z] = &boxes.low;
        let [high_x, high_y, high_z] = &boxes.high;
        let beside = (load(simd, high_x) * scale).simd_lt(splat(simd, self.low[0]))
            | (load(simd, high_y) * scale).simd_lt(splat(simd, self.low[1]))
            | (load(simd, high_z) * scale).simd_lt(splat(simd, self.low[2]))
            | (load(simd, low_y) * scale).simd_gt(splat(simd, self.high[1]))
            | (load(simd, low_z) * scale).simd_gt(splat(simd, self.high[2]));
        !(beside.to_bitmask() as u16)
    }
}

/// Tests the ray from a point along x with sixteen triangles.
///
/// Let ε = 2⁻²⁴. Corners relative to the point are wrong by ε of themselves, products of two of them by 3 ε, and a
/// difference of products, an edge function, by 4 ε of the sum of their magnitudes; its bound takes 16.
#[inline(always)]
fn test<S: Simd>(simd: S, corners: &[[f32x16<S>; 3]; 3], [x, y, z]: [f32; 3]) -> Crossings {
    let (x, y, z, zero) = (splat(simd, x), splat(simd, y), splat(simd, z), splat(simd, 0.0));
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
    let (x0, x1, x2) = (x0 - x, x1 - x, x2 - x);
    let (y0, y1, y2) = (y0 - y, y1 - y, y2 - y);
    let (z0, z1, z2) = (z0 - z, z1 - z, z2 - z);
    let (below0, above0) = edge(simd, [y0, z0], [y1, z1]);
    let (below1, above1) = edge(simd, [y1, z1], [y2, z2]);
    let (below2, above2) = edge(simd, [y2, z2], [y0, z0]);
    let (highest_x, highest_y, highest_z) = (x0.max(x1).max(x2), y0.max(y1).max(y2), z0.max(z1).max(z2));
    let (lowest_x, lowest_y, lowest_z) = (x0.min(x1).min(x2), y0.min(y1).min(y2), z0.min(z1).min(z2));
    let size = (x0.abs() + y0.abs() + z0.abs()) + (x1.abs() + y1.abs() + z1.abs()) + (x2.abs() + y2.abs() + z2.abs());
    let in_range = size.simd_lt(splat(simd, FARTHEST));
    let beside = highest_x.simd_lt(zero)
        | highest_y.simd_lt(zero)
        | highest_z.simd_lt(zero)
        | lowest_y.simd_gt(zero)
        | lowest_z.simd_gt(zero);
    let any_below = below0 | below1 | below2;
    let any_above = above0 | above1 | above2;
    // Signs of differences are exact. NaN isn't equal to itself, and so undecided.
    let missed = (size.simd_eq(size) & beside) | (in_range & any_below & any_above);
    let met = (below0 & below1 & below2) | (above0 & above1 & above2);
    let crossed = in_range & met & lowest_x.simd_gt(zero);
    let crossed = crossed.to_bitmask() as u16;
    Crossings { crossed, undecided: !(missed.to_bitmask() as u16) & !crossed }
}

/// Where an edge function is certainly below and above zero.
#[inline(always)]
fn edge<S: Simd>(simd: S, [y0, z0]: [f32x16<S>; 2], [y1, z1]: [f32x16<S>; 2]) -> (mask32x16<S>, mask32x16<S>) {
    let (first, second) = (y0 * z1, z0 * y1);
    let value = first - second;
    let error = (first.abs() + second.abs()).mul_add(splat(simd, ERROR), splat(simd, SMALLEST));
    (value.simd_lt(-error), value.simd_gt(error))
}
