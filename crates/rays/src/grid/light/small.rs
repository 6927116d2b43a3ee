use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};

use super::block::{Block, Cells, cells_at};
use super::face::Layer;
use super::lanes::{LANES, splat, transpose};
use super::project::UNUSABLE;
use crate::grid::extremes::{max3, min3};

/// Triangles set up before their points are tested.
pub(super) const BATCH: usize = 64;

/// A triangle is small when it covers at most this many columns and rows of cells.
const SMALL_COLUMNS: i32 = 24;
const SMALL_ROWS: i32 = 8;

/// What setting up 16 triangles makes of them.
pub(super) struct Survivors {
    /// Which are in the batch.
    pub(super) small: u64,
    /// Which must be tested in another way.
    pub(super) large: u64,
}

/// Triangles as the fast test wants them, by field. 76 bytes each.
///
/// With s the first corner and (x, y) a point in relation to it, the edge functions are E₁ = a₁ x + b₁ y and
/// E₂ = a₂ x + b₂ y, the barycentric weights of the second and third corner times `area`, and E₀ = a₀ x + b₀ y + area.
/// The triangle's nearness less the point's, times `area`, is G = E₁ d₁ + E₂ d₂ − area · (W − W₀).
pub(super) struct Batch {
    x: [f32; BATCH],
    y: [f32; BATCH],
    nearness: [f32; BATCH],
    a: [[f32; BATCH]; 3],
    b: [[f32; BATCH]; 3],
    area: [f32; BATCH],
    rises: [[f32; BATCH]; 2],
    /// Edge functions below minus this are outside.
    outside: [f32; BATCH],
    /// Edge functions above this are inside; infinite where the area is too uncertain.
    inside: [f32; BATCH],
    /// G is wrong by at most this; infinite where the area is too uncertain.
    depth_error: [f32; BATCH],
    /// Of the nearest corner, grown by its error.
    pub(super) nearest: [f32; BATCH],
    pub(super) first_column: [i32; BATCH],
    pub(super) last_column: [i32; BATCH],
    pub(super) first_row: [i32; BATCH],
    pub(super) last_row: [i32; BATCH],
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [0.0; BATCH];
        Self {
            x: zero,
            y: zero,
            nearness: zero,
            a: [zero; 3],
            b: [zero; 3],
            area: zero,
            rises: [zero; 2],
            outside: zero,
            inside: zero,
            depth_error: zero,
            nearest: zero,
            first_column: [0; BATCH],
            last_column: [0; BATCH],
            first_row: [0; BATCH],
            last_row: [0; BATCH],
        }
    }
}

impl Batch {
    /// Sets up up to 16 triangles at `place`, a multiple of 16.
    #[inline(always)]
    pub(super) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        layer: &Layer,
        cells: &Cells,
        vertices: &[[f32; 4]],
        triangles: &[[u32; 3]],
        place: usize,
    ) -> Survivors {
        let mut packed = [[UNUSABLE; LANES]; 3];
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, &vertex) in triangle.iter().enumerate() {
                packed[corner][lane] = vertices.get(vertex as usize).copied().unwrap_or(UNUSABLE);
            }
        }
        let [x0, y0, w0, code0] = transpose(simd, &packed[0]);
        let [x1, y1, w1, code1] = transpose(simd, &packed[1]);
        let [x2, y2, w2, code2] = transpose(simd, &packed[2]);
        let filled = mask32x16::from_bitmask(simd, (1_u64 << triangles.len()) - 1);
        let shared = code0.to_bits() & code1.to_bits() & code2.to_bits();
        let reaches = shared.simd_eq(u32x16::splat(simd, 0)) & filled;
        if !reaches.any_true() {
            return Survivors { small: 0, large: 0 };
        }
        let (x_min, x_max) = (min3([x0, x1, x2]), max3([x0, x1, x2]));
        let (y_min, y_max) = (min3([y0, y1, y2]), max3([y0, y1, y2]));
        let (farthest, nearest) = (min3([w0, w1, w2]), max3([w0, w1, w2]));
        // A sum is NaN where one is, whatever a minimum makes of it.
        let sum = x0 + x1 + x2;
        let is_usable = sum.simd_eq(sum);
        let size = splat(simd, 2.0);
        let near_the_face = x_max.simd_le(size) & x_min.simd_ge(-size) & y_max.simd_le(size) & y_min.simd_ge(-size);
        let is_even = if layer.face.is_parallel {
            mask32x16::splat(simd, true)
        } else {
            // The predicate's bound counts on it.
            nearest.simd_le(farthest * splat(simd, 1.99))
        };

        // Columns and rows are found as for points, which keeps their order.
        let margin = splat(simd, layer.margin);
        let scale = cells.scale();
        let (scale_x, scale_y) = (splat(simd, scale[0]), splat(simd, scale[1]));
        let first_column = cells_at(simd, x_min - margin, scale_x, cells.columns);
        let last_column = cells_at(simd, x_max + margin, scale_x, cells.columns);
        let first_row = cells_at(simd, y_min - margin, scale_y, cells.rows);
        let last_row = cells_at(simd, y_max + margin, scale_y, cells.rows);
        let is_small = (last_column - first_column).simd_lt(i32x16::splat(simd, SMALL_COLUMNS))
            & (last_row - first_row).simd_lt(i32x16::splat(simd, SMALL_ROWS));

        let [per_side, per_area, constant] = layer.edge_errors;
        let (per_side, per_area, constant) = (splat(simd, per_side), splat(simd, per_area), splat(simd, constant));
        let [of_width, of_height, of_depth] = layer.predicate_errors;
        let (of_width, of_height, of_depth) = (splat(simd, of_width), splat(simd, of_height), splat(simd, of_depth));
        let (ux, uy, tx, ty) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
        let area = ux * ty - tx * uy;
        let sign = splat(simd, 1.0).copysign(area);
        let area = area * sign;
        let (width, height, depth) = (x_max - x_min, y_max - y_min, nearest - farthest);
        let bounds_area = width * height;
        let edge_error = (width + height) * per_side + bounds_area * per_area + constant;
        // Where the area is less than this, points outside could seem inside, and G lose its sign.
        let is_certain = area.simd_gt(edge_error * splat(simd, 4.0));
        let largest_nearness =
            if layer.face.is_parallel { nearest.abs().max(farthest.abs()).max(splat(simd, 1.0)) } else { nearest };
        let relative_depth = if layer.face.is_parallel { depth } else { depth / nearest };
        let of_predicate = width * of_width + height * of_height + relative_depth * of_depth;
        // Edge functions are wrong by `edge_error`, in each of the two products with d and in the area; nearnesses by
        // theirs, weighted by the area; G's own 10 roundings and those of E, relative to at most 3 times area × depth.
        let depth_error = edge_error * depth * splat(simd, 4.0)
            + bounds_area * largest_nearness * splat(simd, layer.nearness_error)
            + bounds_area * depth * splat(simd, 30.0 * super::face::HALF_ULP as f32)
            + of_predicate * of_predicate * largest_nearness
            // Products that underflow lose their bound.
            + splat(simd, 1e-30);
        let infinite = splat(simd, f32::INFINITY);

        let store = |field: &mut [f32; BATCH], value: f32x16<S>| {
            value.store_slice(&mut field[place..place + LANES]);
        };
        store(&mut self.x, x0);
        store(&mut self.y, y0);
        store(&mut self.nearness, w0);
        store(&mut self.a[0], (y1 - y2) * sign);
        store(&mut self.b[0], (x2 - x1) * sign);
        store(&mut self.a[1], ty * sign);
        store(&mut self.b[1], -tx * sign);
        store(&mut self.a[2], -uy * sign);
        store(&mut self.b[2], ux * sign);
        store(&mut self.area, area);
        store(&mut self.rises[0], w1 - w0);
        store(&mut self.rises[1], w2 - w0);
        store(&mut self.outside, edge_error);
        store(&mut self.inside, is_certain.select(edge_error, infinite));
        store(&mut self.depth_error, is_certain.select(depth_error, infinite));
        let grown = nearest + nearest.abs() * splat(simd, 8.0 * layer.nearness_error);
        store(&mut self.nearest, grown + splat(simd, 8.0 * layer.nearness_error));
        first_column.store_slice(&mut self.first_column[place..place + LANES]);
        last_column.store_slice(&mut self.last_column[place..place + LANES]);
        first_row.store_slice(&mut self.first_row[place..place + LANES]);
        last_row.store_slice(&mut self.last_row[place..place + LANES]);
        let fast = reaches & is_usable & near_the_face & is_even & is_small;
        let outside = is_usable
            & (x_min.simd_gt(splat(simd, 1.0) + margin)
                | x_max.simd_lt(splat(simd, -1.0) - margin)
                | y_min.simd_gt(splat(simd, 1.0) + margin)
                | y_max.simd_lt(splat(simd, -1.0) - margin));
        let (fast, outside) = (fast.to_bitmask(), outside.to_bitmask());
        let reaches = reaches.to_bitmask() & !outside;
        Survivors { small: reaches & fast, large: reaches & !fast }
    }

    /// Tests a triangle against a block: which of its points it shadows for certain, and about which the predicate must
    /// be asked.
    #[inline(always)]
    pub(super) fn test<S: Simd>(&self, simd: S, triangle: usize, id: u32, block: &Block) -> (u64, u64) {
        let triangle = triangle % BATCH;
        let of = |field: &[f32; BATCH]| splat(simd, field[triangle]);
        let x = f32x16::simd_from(simd, block.x) - of(&self.x);
        let y = f32x16::simd_from(simd, block.y) - of(&self.y);
        let rise = f32x16::simd_from(simd, block.nearness) - of(&self.nearness);
        let area = of(&self.area);
        let e0 = of(&self.a[0]).mul_add(x, of(&self.b[0]).mul_add(y, area));
        let e1 = of(&self.a[1]).mul_add(x, of(&self.b[1]) * y);
        let e2 = of(&self.a[2]).mul_add(x, of(&self.b[2]) * y);
        let least = min3([e0, e1, e2]);
        let nearer = e1.mul_add(of(&self.rises[0]), e2.mul_add(of(&self.rises[1]), -(area * rise)));
        let depth_error = of(&self.depth_error);
        // Written so that NaN is undecided.
        let possible = least.simd_ge(-of(&self.outside)) & !nearer.simd_lt(-depth_error);
        if !possible.any_true() {
            // Most end here, without a look at the points' own triangles, which are a cache line of their own.
            return (0, 0);
        }
        let others = u32x16::simd_from(simd, block.triangle).simd_ne(u32x16::splat(simd, id));
        let certain = least.simd_gt(of(&self.inside)) & nearer.simd_gt(depth_error);
        let (possible, certain) = ((possible & others).to_bitmask(), certain.to_bitmask());
        (possible & certain, possible & !certain)
    }
}
