use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::DVec2;

use super::TileOrder;
use crate::simd::lanes::{LANES, splat};

/// Shift of each pixel's ray from [`Shot::offset_pixels`](super::Shot::offset_pixels), by even and odd columns and rows.
///
/// So four samples of a pixel, one in each of its quarters, are four pixels of an image with twice as many columns and rows,
/// and structures are built once for all of them: see [`Shifts::of_quarters`].
///
/// With s the largest magnitude of a shift, a ray is at most s from its pixel's point along each axis. So a filter with
/// bounds of a triangle tests pixels up to s outside of them, whose rays are at most 2 s outside. A bound on the points of a
/// tile or block includes points s farther from its middle than its pixels. Sums of pixels and shifts are exact, so no error
/// grows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shifts {
    /// In even columns and rows, in odd columns, in odd rows, and where both are odd.
    x: [f32; 4],
    y: [f32; 4],
    /// The largest magnitude of all shifts.
    reach: f32,
}

impl Shifts {
    /// No shifts: all rays go through the same point of their pixels.
    pub const NONE: Self = Self { x: [0.0; 4], y: [0.0; 4], reach: 0.0 };

    /// Shifts are multiples of this part of a pixel: so f32 holds them, and their positions in a tile, exactly.
    pub const STEP_PIXELS: f64 = 1.0 / (1 << 12) as f64;

    /// The largest magnitude of a shift along each axis.
    pub const LARGEST_PIXELS: f64 = 0.5;

    /// Shifts of pixels in even columns and rows, in odd columns, in odd rows, and where both are odd; `None` where one
    /// is larger than [`LARGEST_PIXELS`](Self::LARGEST_PIXELS) or no multiple of [`STEP_PIXELS`](Self::STEP_PIXELS).
    #[must_use]
    pub fn new(shifts_pixels: [DVec2; 4]) -> Option<Self> {
        let is_possible =
            |shift: f64| shift.abs() <= Self::LARGEST_PIXELS && (shift / Self::STEP_PIXELS).fract() == 0.0;
        let all_are = shifts_pixels.iter().all(|shift| is_possible(shift.x) && is_possible(shift.y));
        let reach = shifts_pixels.iter().fold(0.0, |reach: f64, shift| reach.max(shift.abs().max_element()));
        all_are.then(|| Self {
            x: shifts_pixels.map(|shift| shift.x as f32),
            y: shifts_pixels.map(|shift| shift.y as f32),
            reach: reach as f32,
        })
    }

    /// The [`offset_pixels`](super::Shot::offset_pixels) and shifts that make four samples of a pixel, given by their
    /// positions in it, the pixels of an image with twice as many columns and rows. Its pixel in column 2 x + i and row 2
    /// y + j has sample i + 2 j of the pixel in column x and row y. `None` where sample i + 2 j isn't in the quarter in
    /// column i and row j, or where [`new`](Self::new) refuses the shifts.
    #[must_use]
    pub fn of_quarters(offsets_pixels: [DVec2; 4]) -> Option<(DVec2, Self)> {
        let mut offsets = offsets_pixels;
        for (quarter, offset) in offsets.iter_mut().enumerate() {
            *offset = *offset * 2.0 - DVec2::new((quarter % 2) as f64, (quarter / 2) as f64);
        }
        let (mut low, mut high) = (offsets[0], offsets[0]);
        for &offset in &offsets {
            (low, high) = (low.min(offset), high.max(offset));
        }
        let middle = (low + high) * 0.5;
        let are_quarters = low.min_element() >= 0.0 && high.max_element() <= 1.0;
        Self::new(offsets.map(|offset| offset - middle)).filter(|_| are_quarters).map(|shifts| (middle, shifts))
    }

    /// The shift of the pixel in column `x` and row `y`.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> DVec2 {
        let which = (x % 2 + y % 2 * 2) as usize;
        DVec2::new(f64::from(self.x[which]), f64::from(self.y[which]))
    }

    /// The largest distance along an axis between a ray and its position without shifts.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// The shifts of sixteen pixels, given which of their columns and of their rows are odd.
    #[inline(always)]
    pub fn of_sixteen<S: Simd>(&self, simd: S, odd_columns: mask32x16<S>, odd_rows: mask32x16<S>) -> [f32x16<S>; 2] {
        let [x, y] = [&self.x, &self.y];
        [
            odd_rows.select(
                odd_columns.select(splat(simd, x[3]), splat(simd, x[2])),
                odd_columns.select(splat(simd, x[1]), splat(simd, x[0])),
            ),
            odd_rows.select(
                odd_columns.select(splat(simd, y[3]), splat(simd, y[2])),
                odd_columns.select(splat(simd, y[1]), splat(simd, y[0])),
            ),
        ]
    }

    /// The positions of a block's rays in it.
    pub fn block(&self) -> BlockSamples {
        let mut block = BlockSamples { columns: [0.0; LANES], rows: [0.0; LANES] };
        for lane in 0..LANES {
            let (x, y) = (lane % TileOrder::BLOCK as usize, lane / TileOrder::BLOCK as usize);
            let which = x % 2 + y % 2 * 2;
            block.columns[lane] = x as f32 + self.x[which];
            block.rows[lane] = y as f32 + self.y[which];
        }
        block
    }
}

/// The samples of a block of 4×4 pixels, relative to the unshifted sample of its first pixel.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct BlockSamples {
    pub columns: [f32; LANES],
    pub rows: [f32; LANES],
}

impl Default for BlockSamples {
    fn default() -> Self {
        Shifts::NONE.block()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_are_small_multiples_of_a_step() {
        let of = |shift: DVec2| Shifts::new([DVec2::ZERO, shift, DVec2::ZERO, -shift]);
        assert_eq!(of(DVec2::ZERO), Some(Shifts::NONE));
        let known = of(DVec2::new(0.5, -Shifts::STEP_PIXELS)).expect("possible shifts");
        assert_eq!(known.at(7, 4), DVec2::new(0.5, -Shifts::STEP_PIXELS));
        assert_eq!(known.at(2, 9), DVec2::ZERO);
        assert_eq!((known.at(3, 3), known.reach()), (DVec2::new(-0.5, Shifts::STEP_PIXELS), 0.5));
        for shift in [0.5 + Shifts::STEP_PIXELS, 0.1, f64::NAN, f64::INFINITY] {
            assert_eq!(of(DVec2::new(0.0, shift)), None);
            assert_eq!(of(DVec2::new(shift, 0.0)), None);
        }
    }

    #[test]
    fn quarters_of_a_pixel_are_pixels() {
        let offsets = [(0.125, 0.375), (0.625, 0.125), (0.375, 0.875), (0.875, 0.625)].map(DVec2::from);
        let (offset, shifts) = Shifts::of_quarters(offsets).expect("one in each quarter");
        for (quarter, expected) in offsets.into_iter().enumerate() {
            let (x, y) = (2 * 5 + quarter as u32 % 2, 2 * 9 + quarter as u32 / 2);
            let at = DVec2::new(f64::from(x), f64::from(y)) + offset + shifts.at(x, y);
            assert_eq!(at * 0.5, DVec2::new(5.0, 9.0) + expected);
        }
        let [a, b, c, d] = offsets;
        assert_eq!(Shifts::of_quarters([b, a, c, d]), None);
        assert_eq!(Shifts::of_quarters([a, b, d, c]), None);
    }

    #[test]
    fn blocks_have_the_shifts_of_their_pixels() {
        let shifts = [(0.25, -0.25), (-0.5, 0.125), (0.0, 0.5), (0.375, 0.0)].map(DVec2::from);
        let shifts = Shifts::new(shifts).expect("possible shifts");
        let block = shifts.block();
        for lane in 0..LANES {
            let (x, y) = (lane as u32 % 4, lane as u32 / 4);
            let expected = DVec2::new(f64::from(x), f64::from(y)) + shifts.at(x, y);
            assert_eq!(DVec2::new(f64::from(block.columns[lane]), f64::from(block.rows[lane])), expected);
        }
    }
}
