use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::{DVec3, Vec3};

use umbrage_rays::Ray;

use crate::packet::{Group, HALF_ULP, LANES};

/// Sixteen lines as linear functions of the position w along the major axis: (u, v) = position + slope · w. 256 bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct LineBlock {
    position: [[f32; LANES]; 2],
    slope: [[f32; LANES]; 2],
}

/// Finds in f32 lines that certainly miss a triangle; the lines need have nothing in common.
pub(super) struct LineFilter {
    group: Group,
    origin: DVec3,
    unit: f64,
    /// The largest position, including its terms, and the largest slope.
    farthest: f64,
    steepest: f64,
}

impl LineFilter {
    /// A filter for lines of a group, in coordinates relative to `origin` and times `unit`.
    pub(super) fn new(group: Group, origin: DVec3, unit: f64) -> Self {
        Self { group, origin, unit, farthest: 0.0, steepest: 0.0 }
    }

    /// Adds a ray's line to a block.
    pub(super) fn add(&mut self, block: &mut LineBlock, lane: usize, ray: &Ray) {
        let [u, v, w] = self.group.turned((ray.origin - self.origin) * self.unit);
        let [along_u, along_v, along_w] = self.group.turned(ray.direction);
        let slopes = [along_u / along_w, along_v / along_w];
        for (axis, at) in [u, v].into_iter().enumerate() {
            block.slope[axis][lane] = slopes[axis] as f32;
            block.position[axis][lane] = (at - slopes[axis] * w) as f32;
            self.farthest = self.farthest.max(at.abs() + (slopes[axis] * w).abs());
            self.steepest = self.steepest.max(slopes[axis].abs());
        }
    }

    /// Prepares a triangle.
    ///
    /// With (f, g) a corner's offset from a line along u and v, at the corner's w, the edge function of two corners is
    /// f g' − g f'. Each of the terms of f has five roundings at most, relative to r = |u| + |position| + |slope · w|,
    /// and so has g; their products and the difference add two: 12 ε r r' for each of two products, taken as 32 in all.
    /// Offsets in f64 lose far less. The sum guards against products that are too small for an f32.
    pub(super) fn triangle(&self, corners: [Vec3; 3]) -> LineTriangle {
        let corners = corners.map(|corner| self.group.turned((corner.as_dvec3() - self.origin) * self.unit));
        let reach = corners.map(|[u, v, w]| u.abs().max(v.abs()) + self.farthest + self.steepest * w.abs() + 1e-12);
        let bound = |p: usize, q: usize| (32.0 * HALF_ULP * reach[p] * reach[q]) as f32;
        LineTriangle {
            corners: corners.map(|corner| corner.map(|coordinate| coordinate as f32)),
            bounds: [bound(1, 2), bound(2, 0), bound(0, 1)],
        }
    }
}

/// A triangle, to be tested against lines.
pub(super) struct LineTriangle {
    corners: [[f32; 3]; 3],
    /// Error bound of each edge function.
    bounds: [f32; 3],
}

impl LineTriangle {
    /// A mask of a block's lines that certainly miss the triangle.
    #[inline(always)]
    pub(super) fn missed<S: Simd>(&self, simd: S, lines: &LineBlock) -> u16 {
        let f = self.offsets(simd, lines, 0);
        let g = self.offsets(simd, lines, 1);
        let edges = [f[1] * g[2] - g[1] * f[2], f[2] * g[0] - g[2] * f[0], f[0] * g[1] - g[0] * f[1]];
        let [a, b, c] = self.bounds;
        let (a, b, c) = (f32x16::splat(simd, a), f32x16::splat(simd, b), f32x16::splat(simd, c));
        let positive = edges[0].simd_gt(a) | edges[1].simd_gt(b) | edges[2].simd_gt(c);
        let negative = edges[0].simd_lt(-a) | edges[1].simd_lt(-b) | edges[2].simd_lt(-c);
        (positive & negative).to_bitmask() as u16
    }

    /// Offset of each corner from each line along u or v.
    #[inline(always)]
    fn offsets<S: Simd>(&self, simd: S, lines: &LineBlock, axis: usize) -> [f32x16<S>; 3] {
        let position = f32x16::from_slice(simd, &lines.position[axis]);
        let slope = f32x16::from_slice(simd, &lines.slope[axis]);
        let [a, b, c] = &self.corners;
        [
            f32x16::splat(simd, a[axis]) - (position + slope * f32x16::splat(simd, a[2])),
            f32x16::splat(simd, b[axis]) - (position + slope * f32x16::splat(simd, b[2])),
            f32x16::splat(simd, c[axis]) - (position + slope * f32x16::splat(simd, c[2])),
        ]
    }
}
