use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};
use umbrage_rays::light_grid::face::{Block, FACE_LIMIT, Face, HALF_ULP, VERTEX_MARGIN, VertexErrors};
use umbrage_rays::simd::lanes::{max3, min3};
use umbrage_rays::simd::vectors::{LANES, load_corner, splat};

use super::BlockErrors;

/// Triangles set up together before their points are tested.
pub(super) const BATCH: usize = 64;

/// Columns and rows of cells: a triangle below both limits is small.
const SMALL_COLUMNS: u16 = 24;
const SMALL_ROWS: u16 = 8;

const EPSILON: f32 = HALF_ULP as f32;

// Error bound of an edge function, with ε = `EPSILON`, w and h the extents of the triangle's bounds, v the largest rounding
// of a vertex and e the point's own error. The function is (p − s) × (q − s), with p and q two corners and s the point. It
// changes by at most v (w + h) when p or q moves and by e (w + h) when s does; both together add 2 (2 v)² and 4 v e. Its own
// roundings: the differences, factors and products make at most eleven of w h for each of two products, and the area in the
// third function as much. For a point outside of the bounds all of this grows in proportion to its distance from them. So
// does the least of the functions, in a triangle whose area is certain, but more steeply and to below zero.
const OF_GIRTH: f32 = (2.0 * VertexErrors::MOVED * 1.1) as f32;
const OF_BOUNDS: f32 = 24.0 * EPSILON;
const OF_NOTHING: f32 = (8.0 * VertexErrors::MOVED * VertexErrors::MOVED) as f32;

/// Error bound of nearness, relative to the largest nearness: that of three corners, each with an error of ε, weighted by at
/// most 2, and the roundings of the point's.
const NEARNESS_ERROR: f32 = 8.0 * EPSILON;

/// The mapped vertices that triangles are set up from.
pub(crate) struct Mapped<'a> {
    pub(super) face: &'a Face,
    pub(super) vertex_errors: VertexErrors,
    /// Number of columns, and of rows, of cells.
    pub(super) side: usize,
    /// Vertices as [`project`](super::project::project) writes them.
    pub(super) vertices: &'a [[f32; 4]],
}

/// The results of setting up 16 triangles.
pub(crate) struct Survivors {
    /// Triangles in the batch.
    pub(super) small: u64,
    /// Triangles that need the other test.
    pub(super) large: u64,
}

/// Triangles in the filter's form, by field. 112 bytes each.
///
/// With s the first corner and (x, y) a point relative to it, the edge functions are E₁ = a₁ x + b₁ y and E₂ = a₂ x + b₂ y,
/// the barycentric weights of the second and third corner times `area`, and E₀ = a₀ x + b₀ y + area. The triangle's nearness
/// minus the point's, times `area`, is G = E₁ d₁ + E₂ d₂ − area · (W − W₀).
pub(crate) struct Batch {
    x: [f32; BATCH],
    y: [f32; BATCH],
    nearness: [f32; BATCH],
    a: [[f32; BATCH]; 3],
    b: [[f32; BATCH]; 3],
    area: [f32; BATCH],
    rises: [[f32; BATCH]; 2],
    /// Error bound of edge functions: the first, plus the second times the point's own error.
    edge_error: [[f32; BATCH]; 2],
    /// Error bound of G: the first, plus the second times the point's own error in X and Y, plus the area times that in W.
    /// Infinite where the area is too uncertain for any verdict.
    depth_error: [[f32; BATCH]; 2],
    /// Lowest and highest X, and Y, grown by the vertices' error.
    pub(super) x_range: [[f32; BATCH]; 2],
    pub(super) y_range: [[f32; BATCH]; 2],
    /// Nearness of the nearest corner, grown by its error.
    pub(super) nearest: [f32; BATCH],
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
            edge_error: [zero; 2],
            depth_error: [zero; 2],
            x_range: [zero; 2],
            y_range: [zero; 2],
            nearest: zero,
        }
    }
}

#[inline(always)]
fn store<S: Simd>(slot: usize, field: &mut [f32; BATCH], value: f32x16<S>) {
    value.store_slice(&mut field[slot..slot + LANES]);
}

impl Batch {
    /// Sets up at most 16 triangles in the slots from `slot`, a multiple of 16.
    #[inline(always)]
    pub(super) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        on: &Mapped<'_>,
        triangles: &[[u32; 3]],
        slot: usize,
    ) -> Survivors {
        let &Mapped { face, vertex_errors, side, vertices } = on;
        let mut padded = [[u32::MAX; 3]; LANES];
        let all = triangles.try_into().unwrap_or_else(|_| {
            padded[..triangles.len()].copy_from_slice(triangles);
            &padded
        });
        let [x0, y0, w0, code0] = load_corner(simd, vertices, all, 0);
        let [x1, y1, w1, code1] = load_corner(simd, vertices, all, 1);
        let [x2, y2, w2, code2] = load_corner(simd, vertices, all, 2);
        let filled = mask32x16::from_bitmask(simd, (1_u64 << triangles.len()) - 1);
        let shared = code0.to_bits() & code1.to_bits() & code2.to_bits();
        let reaches = shared.simd_eq(u32x16::splat(simd, 0)) & filled;
        if !reaches.any_true() {
            return Survivors { small: 0, large: 0 };
        }
        let (x_min, x_max) = (min3([x0, x1, x2]), max3([x0, x1, x2]));
        let (y_min, y_max) = (min3([y0, y1, y2]), max3([y0, y1, y2]));
        let (farthest, nearest) = (min3([w0, w1, w2]), max3([w0, w1, w2]));
        // A sum is NaN if a term is; a minimum may not be.
        let sum = x0 + x1 + x2;
        let is_usable = sum.simd_eq(sum);
        // A coordinate found to be at 2 may have been rounded to it by 2 ε.
        let size = splat(simd, 2.0);
        let near_the_face = x_max.simd_lt(size) & x_min.simd_gt(-size) & y_max.simd_lt(size) & y_min.simd_gt(-size);
        let is_even = if face.is_parallel {
            mask32x16::splat(simd, true)
        } else {
            // The predicate's bound relies on it.
            nearest.simd_le(farthest * splat(simd, 1.99))
        };

        let margin = splat(simd, VERTEX_MARGIN);
        let (x_range, y_range) = ([x_min - margin, x_max + margin], [y_min - margin, y_max + margin]);
        let cell = 2.0 / side as f32;
        // Triangles with NaN bounds aren't small.
        let is_small = (x_range[1] - x_range[0]).simd_lt(splat(simd, cell * f32::from(SMALL_COLUMNS)))
            & (y_range[1] - y_range[0]).simd_lt(splat(simd, cell * f32::from(SMALL_ROWS)));
        let grown = nearest + nearest.abs() * splat(simd, 8.0 * NEARNESS_ERROR);
        let grown = if face.is_parallel { grown + splat(simd, 8.0 * NEARNESS_ERROR) } else { grown };
        let limit = splat(simd, FACE_LIMIT as f32);
        let is_outside = x_min.simd_gt(limit) | x_max.simd_lt(-limit) | y_min.simd_gt(limit) | y_max.simd_lt(-limit);
        let reaches = reaches & !(is_usable & is_outside);
        if !reaches.any_true() {
            return Survivors { small: 0, large: 0 };
        }

        let [of_width, of_height, of_depth] = vertex_errors.of_predicate;
        let (ux, uy, tx, ty) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
        let area = ux * ty - tx * uy;
        let sign = splat(simd, 1.0).copysign(area);
        let area = area * sign;
        let (width, height, depth) = (x_max - x_min, y_max - y_min, nearest - farthest);
        let (girth, bounds_area) = (width + height, width * height);
        let edge_error = girth * OF_GIRTH + bounds_area * OF_BOUNDS + OF_NOTHING;
        // If the area is less than this, its sign, and that of the functions, is uncertain.
        let is_certain = area.simd_gt(edge_error * splat(simd, 4.0));
        let largest_nearness =
            if face.is_parallel { nearest.abs().max(farthest.abs()).max(splat(simd, 1.0)) } else { nearest };
        let relative_depth = if face.is_parallel { depth } else { depth / nearest };
        let of_predicate = width * of_width + height * of_height + relative_depth * of_depth;
        let (rise1, rise2) = (w1 - w0, w2 - w0);
        // G's slopes along X and Y.
        let slope = (ty * rise1 - uy * rise2).abs() + (ux * rise2 - tx * rise1).abs();
        let depth_error = edge_error * depth * splat(simd, 4.0)
            + bounds_area * largest_nearness * splat(simd, NEARNESS_ERROR)
            + bounds_area * depth * splat(simd, 30.0 * EPSILON)
            + of_predicate * of_predicate * largest_nearness
            // Covers products that underflow.
            + splat(simd, 1e-30);
        let depth_per_error = slope * splat(simd, 1.001)
            + (girth * (depth * 64.0 + largest_nearness * 4.0) + depth * 20.0) * splat(simd, EPSILON);
        let infinite = splat(simd, f32::INFINITY);
        store(slot, &mut self.x, x0);
        store(slot, &mut self.y, y0);
        store(slot, &mut self.nearness, w0);
        store(slot, &mut self.a[0], (y1 - y2) * sign);
        store(slot, &mut self.b[0], (x2 - x1) * sign);
        store(slot, &mut self.a[1], ty * sign);
        store(slot, &mut self.b[1], -tx * sign);
        store(slot, &mut self.a[2], -uy * sign);
        store(slot, &mut self.b[2], ux * sign);
        store(slot, &mut self.area, area);
        store(slot, &mut self.rises[0], rise1);
        store(slot, &mut self.rises[1], rise2);
        // With the wrong sign, a point inside has edge functions down to minus the area, which is below two errors.
        store(slot, &mut self.edge_error[0], is_certain.select(edge_error, edge_error * 4.0));
        store(slot, &mut self.edge_error[1], girth * splat(simd, 1.001) + splat(simd, 8.0 * EPSILON));
        store(slot, &mut self.depth_error[0], is_certain.select(depth_error, infinite));
        store(slot, &mut self.depth_error[1], depth_per_error);
        store(slot, &mut self.x_range[0], x_range[0]);
        store(slot, &mut self.x_range[1], x_range[1]);
        store(slot, &mut self.y_range[0], y_range[0]);
        store(slot, &mut self.y_range[1], y_range[1]);
        store(slot, &mut self.nearest, grown);
        let fast = reaches & is_usable & near_the_face & is_even & is_small;
        let (fast, reaches) = (fast.to_bitmask(), reaches.to_bitmask());
        Survivors { small: reaches & fast, large: reaches & !fast }
    }

    /// The edge functions at a block's points.
    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, triangle: usize, block: &Block) -> [f32x16<S>; 3] {
        let x = f32x16::simd_from(simd, block.x) - splat(simd, self.x[triangle]);
        let y = f32x16::simd_from(simd, block.y) - splat(simd, self.y[triangle]);
        let area = splat(simd, self.area[triangle]);
        [
            splat(simd, self.a[0][triangle]).mul_add(x, splat(simd, self.b[0][triangle]).mul_add(y, area)),
            splat(simd, self.a[1][triangle]).mul_add(x, splat(simd, self.b[1][triangle]) * y),
            splat(simd, self.a[2][triangle]).mul_add(x, splat(simd, self.b[2][triangle]) * y),
        ]
    }

    /// Tests a triangle against a block. Returns the points that it certainly shadows, and those that it possibly shadows,
    /// which include the former. Points on the triangle itself may be among the latter.
    #[inline(always)]
    pub(super) fn test<S: Simd>(
        &self,
        simd: S,
        triangle: usize,
        block: &Block,
        error: BlockErrors,
    ) -> (mask32x16<S>, mask32x16<S>) {
        let triangle = triangle % BATCH;
        let rise = f32x16::simd_from(simd, block.nearness) - splat(simd, self.nearness[triangle]);
        let area = splat(simd, self.area[triangle]);
        let [e0, e1, e2] = self.edges(simd, triangle, block);
        let least = min3([e0, e1, e2]);
        let nearer = e1.mul_add(
            splat(simd, self.rises[0][triangle]),
            e2.mul_add(splat(simd, self.rises[1][triangle]), -(area * rise)),
        );
        let edge_error = splat(simd, error.position * self.edge_error[1][triangle] + self.edge_error[0][triangle]);
        let depth_error = splat(
            simd,
            error.position * self.depth_error[1][triangle]
                + error.nearness * self.area[triangle]
                + self.depth_error[0][triangle],
        );
        // Written so that NaN is possible. An infinite error leaves nothing certain.
        let possible = least.simd_ge(-edge_error) & !nearer.simd_lt(-depth_error);
        let certain = least.simd_gt(edge_error) & nearer.simd_gt(depth_error);
        (certain, possible)
    }
}
