//! Lists large triangles by coarse rasterization: the tiles in which large triangles may be hit, and their nearest depths there.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::bins::{Bins, Listed, Path};
use super::homogeneous::{HomogeneousTriangle, LinearTriangle, Square};
use super::lanes::{LANES, splat};
use super::pixel_space::PixelSpace;
use crate::simd::each;
use crate::simd::lanes::{bits_of, min3};

/// Distance of samples from the middle of their tile, along each axis, without their shifts.
const REACH: f32 = (Bins::TILE - 1) as f32 / 2.0;

/// The first columns of 16 tiles in a row.
const COLUMNS: [f32; LANES] =
    [0., 64., 128., 192., 256., 320., 384., 448., 512., 576., 640., 704., 768., 832., 896., 960.];

impl Bins {
    /// The distance from the middle of the image at which [`LinearTriangle`] triangles must hold for
    /// [`list_linear`](Self::list_linear): that of the middle of any tile.
    pub(crate) fn reach(space: &PixelSpace) -> f32 {
        let (width, height) = space.size();
        (width.max(height) / 2 + Self::TILE) as f32
    }

    /// Lists a triangle, given relative to the origin of pixel space, in those of `tiles` (columns, then rows) whose samples
    /// it doesn't certainly miss.
    ///
    /// At a sample that is hit, no edge function is below minus its bound. In the middle of the tile it is lower by at most
    /// the reach times its slopes. Three more bounds cover the roundings there and of the reach; likewise for the depth,
    /// whose error counts the roundings of one sum like this.
    #[inline(always)]
    pub(crate) fn list_linear<S: Simd>(
        &mut self,
        simd: S,
        space: &PixelSpace,
        path: Path,
        slot: u32,
        triangle: &LinearTriangle,
        [x0, x1, y0, y1]: [i32; 4],
    ) {
        let LinearTriangle { a, b, c, bound, gradient, .. } = triangle;
        let samples = REACH + space.shifts.reach();
        let reach = each!(edge in [0, 1, 2] => splat(simd, samples * (a[edge].abs() + b[edge].abs()) + 4.0 * bound));
        let rise = samples * (gradient[0].abs() + gradient[1].abs()) + 2.0 * triangle.depth_error;
        let (zero, nearest) = (splat(simd, 0.0), splat(simd, triangle.nearest));
        for first in (x0..=x1).step_by(LANES) {
            let count = (x1 - first + 1).min(LANES as i32);
            let origin = (first << Self::TILE_BITS) - space.middle.x;
            let x = f32x16::simd_from(simd, COLUMNS) + splat(simd, origin as f32 + REACH);
            let along_row = x * splat(simd, gradient[0]) + splat(simd, triangle.inverse_depth + rise);
            for row in y0..=y1 {
                let y = ((row << Self::TILE_BITS) - space.middle.y) as f32 + REACH;
                let edges = each!(edge in [0, 1, 2] => {
                    splat(simd, a[edge]) * x + splat(simd, b[edge] * y + c[edge]) + reach[edge]
                });
                let here = nearest.min(along_row + splat(simd, y * gradient[1]));
                let reached = min3(edges).simd_ge(zero) & here.simd_ge(zero);
                let here: [f32; LANES] = here.into();
                for lane in bits_of(reached.to_bitmask() & ((1 << count) - 1)) {
                    let listed = Listed { slot, nearest: here[lane % LANES] };
                    self.push(path, listed, first + lane as i32, row);
                }
            }
        }
    }

    /// Lists a triangle in all tiles whose samples it doesn't certainly miss.
    #[inline(always)]
    pub(crate) fn list_homogeneous<S: Simd>(
        &mut self,
        simd: S,
        space: &PixelSpace,
        path: Path,
        slot: u32,
        triangle: &HomogeneousTriangle,
    ) {
        let Some(tiles) = self.tiles_within(space, triangle.limits()) else { return };
        match triangle.linear([0.0; 2], f64::from(Self::reach(space))) {
            Some(linear) => self.list_linear(simd, space, path, slot, &linear, tiles),
            None => {
                let listed = Listed { slot, nearest: f32::INFINITY };
                self.list_square(space, path, listed, triangle, Square::around_image(space));
            }
        }
    }

    /// The tiles with samples within limits of x and y: columns, then rows; `None` where there are none.
    fn tiles_within(&self, space: &PixelSpace, [x, y]: [[f64; 2]; 2]) -> Option<[i32; 4]> {
        let range = |[low, high]: [f64; 2], middle: i32, side: u32| {
            let last = f64::from(side) - 1.0;
            let (low, high) = ((low + f64::from(middle)).max(0.0), (high + f64::from(middle)).min(last));
            (low <= high).then_some([low as i32 >> Self::TILE_BITS, high as i32 >> Self::TILE_BITS])
        };
        let (width, height) = space.size();
        let ([x0, x1], [y0, y1]) = (range(x, space.middle.x, width)?, range(y, space.middle.y, height)?);
        Some([x0, x1, y0, y1])
    }

    fn list_square(
        &mut self,
        space: &PixelSpace,
        path: Path,
        listed: Listed,
        triangle: &HomogeneousTriangle,
        square: Square,
    ) {
        let (x, y) = ((square.x + space.middle.x) >> Self::TILE_BITS, (square.y + space.middle.y) >> Self::TILE_BITS);
        if x >= self.columns || y >= self.rows || triangle.misses(square) {
            return;
        }
        if square.side == Self::TILE as i32 {
            self.push(path, listed, x, y);
        } else {
            for quarter in square.quarters() {
                self.list_square(space, path, listed, triangle, quarter);
            }
        }
    }
}
