//! Boxes of patches outside of the image are culled, and others bounded in pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use glam::IVec2;

use super::bins::Bins;
use super::pixel_space::{HALF_ULP, PixelSpace, Vertex};
use crate::simd::each;
use crate::simd::vectors::{Vectors, largest, splat_vector};

/// The position in the image of the vertices in a box.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BoxInImage {
    /// Outside of the image: no ray hits a triangle between the vertices.
    Outside,
    /// All vertices are ordinary.
    Within {
        /// The pixels whose rays may hit a triangle between the vertices.
        pixels: PixelBox,
        /// Upper bound of the inverse depth of all hits.
        nearest: f32,
    },
    /// Unknown.
    Anywhere,
}

/// Pixels of an image: first and last column, first and last row. 8 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelBox {
    x: [u16; 2],
    y: [u16; 2],
}

impl PixelBox {
    /// Whether it is in so few tiles that its contents may be tested in each of them.
    pub(super) fn is_small(self) -> bool {
        const MOST_TILES: i32 = 6;
        let [x0, x1, y0, y1] = self.tiles();
        (x1 - x0 + 1) * (y1 - y0 + 1) <= MOST_TILES
    }

    /// First and last column, then row, of its tiles.
    pub(super) fn tiles(self) -> [i32; 4] {
        [self.x[0], self.x[1], self.y[0], self.y[1]].map(|at| i32::from(at) >> Bins::TILE_BITS)
    }

    pub(super) fn contains(self, x: u32, y: u32) -> bool {
        let within = |[first, last]: [u16; 2], at: u32| (u32::from(first)..=u32::from(last)).contains(&at);
        within(self.x, x) && within(self.y, y)
    }

    /// First and last column, then row, of its blocks in a tile with this corner.
    #[inline(always)]
    pub(super) fn blocks(self, corner: IVec2) -> [usize; 4] {
        let block = |at: u16, first: i32| ((i32::from(at) - first).clamp(0, Bins::TILE as i32 - 1) / 4) as usize;
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        [block(x0, corner.x), block(x1, corner.x), block(y0, corner.y), block(y1, corner.y)]
    }
}

impl PixelSpace {
    /// Finds the position in the image of triangles with vertices in a box.
    ///
    /// A box's corners are points like vertices: their coordinates have the same error bounds, and linear functions of
    /// points in the box are between those of the corners.
    ///
    /// A box is *outside* if all corners are behind the eye, as a vertex would be, or beyond one side of the image, by more
    /// than the error of homogeneous pixel coordinates ([`HomogeneousTriangle`](super::homogeneous::HomogeneousTriangle) has the same margin).
    ///
    /// A box is *within* if it is in front of the eye: there x/z, y/z and 1/z are between those of the corners as well. Each
    /// is wrong by 2⁻⁴⁵ r for a reach r below 1.01 z (1 + 2 g), with g the [guard](Self) of at most 2²⁰: relative to z by
    /// 2⁻²³, and so x/z by 2⁻²³ (1 + g), the distance that corners keep from the limits of ordinary vertices. Pixels of
    /// vertices are wrong by 2⁻²⁴ |x| + [`Vertex::ERROR_PIXELS`], for which [`PixelBounds`](super::lanes::PixelBounds) takes
    /// 2.1 · 2⁻²⁴ |x| + 1.1 `ERROR_PIXELS`, and those of corners by another `ERROR_PIXELS`: less than four of each. Pixels
    /// are as far outside as their samples may be from them.
    #[inline(always)]
    pub(crate) fn box_in_image<S: Simd>(&self, simd: S, [low, high]: [[f32; 3]; 2]) -> BoxInImage {
        const ROUNDED: f64 = 1.0 / (1 << 23) as f64;
        const LARGEST_GUARD: f64 = (1 << 20) as f64;
        let guard = self.guard - ROUNDED * (1.0 + self.guard);
        if !(0.0..LARGEST_GUARD).contains(&guard) {
            return BoxInImage::Anywhere;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| [f64::from(low[axis]), f64::from(high[axis])]);
        let corners = [
            f64x8::simd_from(simd, [x[0], x[1], x[0], x[1], x[0], x[1], x[0], x[1]]),
            f64x8::simd_from(simd, [y[0], y[0], y[1], y[1], y[0], y[0], y[1], y[1]]),
            f64x8::simd_from(simd, [z[0], z[0], z[0], z[0], z[1], z[1], z[1], z[1]]),
        ];
        let (at, reach) = self.camera_points(simd, corners);
        let constant = |value: f64| f64x8::splat(simd, value);
        let behind = at[2].simd_lt(reach * -Self::DOUBT);
        let [columns, rows] = self.beyond(simd, at);
        let error = reach * (2.0 * self.edge_error / self.extent);
        let is_outside = behind.all_true()
            || columns[0].simd_gt(error).all_true()
            || columns[1].simd_gt(error).all_true()
            || rows[0].simd_gt(error).all_true()
            || rows[1].simd_gt(error).all_true();
        if is_outside {
            return BoxInImage::Outside;
        }
        let inverse_depth = constant(1.0) / at[2];
        let (x, y) = (at[0] * inverse_depth, at[1] * inverse_depth);
        let (first, last) = (*Self::RANGE.start() * (1.0 + ROUNDED), *Self::RANGE.end() * (1.0 - ROUNDED));
        let is_ordinary = x.abs().max(y.abs()).simd_le(constant(guard))
            & inverse_depth.simd_ge(constant(first))
            & inverse_depth.simd_le(constant(last));
        if !is_ordinary.all_true() {
            return BoxInImage::Anywhere;
        }
        let [x, y, _] = self.pixels(simd, at);
        let (width, height) = self.size();
        let (x, y) = ([x.reduce_min(), x.reduce_max()], [y.reduce_min(), y.reduce_max()]);
        let pixels = |[low, high]: [f64; 2], middle: i32, side: u32| {
            let error = 4.0 * (f64::from(HALF_ULP) * low.abs().max(high.abs()) + f64::from(Vertex::ERROR_PIXELS));
            let error = error + f64::from(self.shifts.reach());
            let (middle, last) = (f64::from(middle), f64::from(side) - 1.0);
            [(low - error).ceil() + middle, (high + error).floor() + middle].map(|at| at.clamp(-1.0, last + 1.0))
        };
        let ([x0, x1], [y0, y1]) = (pixels(x, self.middle.x, width), pixels(y, self.middle.y, height));
        let (x0, y0) = (x0.max(0.0), y0.max(0.0));
        let (x1, y1) = (x1.min(f64::from(width) - 1.0), y1.min(f64::from(height) - 1.0));
        if x0 > x1 || y0 > y1 {
            return BoxInImage::Outside;
        }
        // Rounded to f32, with an own error of 2⁻²³.
        let nearest = inverse_depth.reduce_max() as f32 * (1.0 + 6.0 * HALF_ULP);
        let [x, y] = [[x0, x1], [y0, y1]].map(|ends| ends.map(|at| at as u16));
        BoxInImage::Within { pixels: PixelBox { x, y }, nearest }
    }

    /// The distances of points beyond the first and the last column, and the first and the last row of the image, times
    /// their depth: negative inside.
    #[inline(always)]
    fn beyond<S: Simd>(&self, simd: S, [x, y, z]: Vectors<S>) -> [[f64x8<S>; 2]; 2] {
        let (width, height) = self.size();
        let shift = f64::from(self.shifts.reach());
        let from_axis = |axis: f64, middle: i32, side: u32| {
            let first = -f64::from(middle) - axis;
            [f64x8::splat(simd, first - shift), f64x8::splat(simd, first + f64::from(side) - 1.0 + shift)]
        };
        let [left, right] = from_axis(self.axis_pixels.x, self.middle.x, width);
        let [top, bottom] = from_axis(self.axis_pixels.y, self.middle.y, height);
        let (x, y) = (x * self.scale, y * -self.scale);
        [[z * left - x, x - z * right], [z * top - y, y - z * bottom]]
    }

    /// As [`camera_point`](Self::camera_point), for eight points.
    #[inline(always)]
    pub(super) fn camera_points<S: Simd>(&self, simd: S, points: Vectors<S>) -> (Vectors<S>, f64x8<S>) {
        let [eye_x, eye_y, eye_z] = self.eye.to_array();
        let offset = [points[0] - eye_x, points[1] - eye_y, points[2] - eye_z];
        let along = each!(row in self.camera_from_world => {
            let [x, y, z] = splat_vector(simd, row);
            x * offset[0] + y * offset[1] + z * offset[2]
        });
        (along, largest(offset) * self.reach_per_unit)
    }
}
