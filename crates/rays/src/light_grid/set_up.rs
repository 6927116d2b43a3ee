use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::boxes::FaceBox;
use super::face::{Face, HALF_ULP, VertexErrors};
use crate::patches::{MOST_TRIANGLES, Patch};
use crate::simd::lanes::{load_local_corner, max3, min3, quads};
use crate::simd::vectors::{LANES, splat};

const EPSILON: f32 = HALF_ULP as f32;

/// The largest distance that rounding moves a vertex along X and Y.
const MOVED: f32 = VertexErrors::MOVED as f32;

/// The extent of a tile's points and their errors, for the filter.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    /// X, Y and W of the origin of all coordinates.
    pub(crate) origin: [f32; 3],
    /// The largest distance of a point from the origin in X and Y.
    pub(crate) reach: f32,
    /// The largest distance in W.
    pub(crate) depth: f32,
    /// Error of X and Y of any point, and of W.
    pub(crate) errors: [f32; 2],
}

/// A triangle set up for the filter.
///
/// Three edge functions Eₖ = aₖ x + bₖ y + cₖ of the point's position in relation to the tile's origin, and the triangle's
/// nearness p x + q y + r in relation to the origin's: quad k holds aₖ, bₖ, cₖ and one of p, q, r. All are grown by their
/// errors, so that a point with any of them below zero, or its own nearness above, is certainly not shadowed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    pub(crate) quads: [[f32; 4]; 3],
    pub(crate) id: u32,
    /// A point is shadowed for certain where all edge functions are above the first, and the difference in nearness
    /// above the second: twice their errors.
    pub(crate) errors: [f32; 2],
}

/// The triangles of a patch, set up for a tile's points. 88 bytes a triangle.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct SetUp {
    /// The patch's number.
    pub(crate) number: u32,
    /// Number of its triangles.
    pub(crate) count: u32,
    /// Lowest and highest X and Y, in relation to the tile's origin, grown by the vertices' error.
    pub(crate) x: [[f32; MOST_TRIANGLES]; 2],
    pub(crate) y: [[f32; MOST_TRIANGLES]; 2],
    /// Nearness of the nearest corner, grown by its error.
    pub(crate) nearness: [f32; MOST_TRIANGLES],
    quads: [[[f32; 4]; MOST_TRIANGLES]; 3],
    twice_edge_error: [f32; MOST_TRIANGLES],
    twice_depth_error: [f32; MOST_TRIANGLES],
}

impl SetUp {
    pub(crate) const EMPTY: Self = Self {
        number: 0,
        count: 0,
        x: [[0.0; MOST_TRIANGLES]; 2],
        y: [[0.0; MOST_TRIANGLES]; 2],
        nearness: [0.0; MOST_TRIANGLES],
        quads: [[[0.0; 4]; MOST_TRIANGLES]; 3],
        twice_edge_error: [0.0; MOST_TRIANGLES],
        twice_depth_error: [0.0; MOST_TRIANGLES],
    };

    #[inline(always)]
    pub(crate) fn quads(&self, triangle: usize) -> [&[f32; 4]; 3] {
        let triangle = triangle % MOST_TRIANGLES;
        [&self.quads[0][triangle], &self.quads[1][triangle], &self.quads[2][triangle]]
    }

    pub(crate) fn record(&self, triangle: usize, id: u32) -> Record {
        Record { quads: self.quads(triangle).map(|quad| *quad), id, errors: self.errors(triangle) }
    }

    /// See [`Record::errors`].
    #[inline(always)]
    pub(crate) fn errors(&self, triangle: usize) -> [f32; 2] {
        let triangle = triangle % MOST_TRIANGLES;
        [self.twice_edge_error[triangle], self.twice_depth_error[triangle]]
    }

    pub(crate) fn bounds(&self, triangle: usize) -> FaceBox {
        FaceBox {
            x: [self.x[0][triangle], self.x[1][triangle]],
            y: [self.y[0][triangle], self.y[1][triangle]],
            nearness: self.nearness[triangle],
        }
    }

    /// Sets up a patch's triangles, `vertices` being X, Y and W of its vertices.
    ///
    /// With ε = 2⁻²⁴, e the points' error, R the largest coordinate of a corner, w and h the extents of a triangle's bounds,
    /// g = w + h, and v the most that rounding moves a corner: by 1.125 ε on the face and another ε R when the origin is
    /// subtracted.
    ///
    /// *Counterparts.* A point s of the true triangle has the same weights as some point s″ of the rounded one, at most v
    /// away from it, and so at most v + e from the point's found position. If on the other hand a point is found inside of
    /// the rounded triangle and more than v + e from each of its edges, then the true one is inside of the true triangle: on
    /// a straight way from the rounded corners and point to the true ones it can't meet an edge, which has a counterpart as
    /// well, and until then the triangle can't turn over. So only functions of the rounded triangle matter.
    ///
    /// *Edges.* The function E(s) = (P − s) × (Q − s) of the rounded P and Q isn't below zero at s″, and changes by at most
    /// (v + e) g up to the found position. Rounded are a and b, by ε each of themselves, which with a c from the same a and
    /// b is at most 2 ε g R; the products and sums of c, 3 ε g R; and those of the function but its last, which can't change
    /// the sign, 3 ε g R. The area is wrong by 6 ε w h ≤ 6 ε g R. Where its sign is found wrong it is no more than that, and
    /// neither are the functions at s″ below zero. That is 14 ε g R in all, or with v, 15.
    ///
    /// *Certain signs.* Moving the corners changes the area by at most 2 v g + 6 v². Its sign is certain above sixteen times
    /// the part of an edge's error that vertices and roundings make: no area is above w h, so there g is above 64 v.
    ///
    /// *Points* that are found inside are no farther from the origin than 1.16 R: of one that is D away, weights below zero
    /// are so by 8 ε g D over an area above 240 ε g R at most. Those inside are no farther than R + v + e, and the rest is
    /// lost in the error of a point.
    ///
    /// *Depth.* The plane through the rounded corners is wrong by the error of their W at s″, and changes by at most S (v +
    /// e) up to the found position, S being the sum of the magnitudes of its slopes. Numerators are wrong by 6 ε h d and 6 ε
    /// w d, d being the difference in W of the corners, which at s″ makes 12 ε w h d / area. The area's error scales both
    /// slopes by as much, and so the plane's rise from a corner, which is at most d: 6 ε w h d / area. Three more roundings
    /// of slopes of at most h d / area and w d / area make 6: taken as 26 together, since the area is wrong by a fortieth of
    /// itself at most where its sign is certain. The constant has 5 ε S R, and the function 3 ε S · 1.16 R: with v, 10. The
    /// largest W in relation to the origin is rounded 5 times, and with that of a corner, 6.
    ///
    /// *Sides.* `one_sided` has a bit for each triangle that is there for light on its front alone. Where the area's sign is
    /// certain it tells the side, and bounds of triangles that aren't there are turned around: no point is in them.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a patch on a face, seen from a tile")]
    pub(crate) fn fill<S: Simd>(
        &mut self,
        simd: S,
        face: &Face,
        vertex_errors: &VertexErrors,
        patch: &Patch<'_>,
        vertices: &[[f32; 4]],
        extent: &Extent,
        one_sided: u64,
    ) {
        self.count = patch.count as u32;
        let [origin_x, origin_y, origin_w] = extent.origin;
        let [position_error, nearness_error] = extent.errors;
        let of_parallel = if face.is_parallel { 1.0 } else { 0.0 };
        let [of_width, of_height, of_depth] = vertex_errors.of_predicate;
        let front = splat(simd, face.sign_of_fronts());
        for (group, corners) in patch.corners.chunks_exact(LANES).enumerate() {
            let [x0, y0, w0] = load_local_corner(simd, vertices, corners, 0);
            let [x1, y1, w1] = load_local_corner(simd, vertices, corners, 1);
            let [x2, y2, w2] = load_local_corner(simd, vertices, corners, 2);
            let largest_nearness = max3([w0.abs(), w1.abs(), w2.abs()]).max(splat(simd, of_parallel));
            let (ox, oy, ow) = (splat(simd, origin_x), splat(simd, origin_y), splat(simd, origin_w));
            let (x0, x1, x2) = (x0 - ox, x1 - ox, x2 - ox);
            let (y0, y1, y2) = (y0 - oy, y1 - oy, y2 - oy);
            let (w0, w1, w2) = (w0 - ow, w1 - ow, w2 - ow);
            let (x_min, x_max) = (min3([x0, x1, x2]), max3([x0, x1, x2]));
            let (y_min, y_max) = (min3([y0, y1, y2]), max3([y0, y1, y2]));
            let (farthest, nearest) = (min3([w0, w1, w2]), max3([w0, w1, w2]));
            let reach = x_min.abs().max(x_max.abs()).max(y_min.abs().max(y_max.abs()));
            let local_depth = farthest.abs().max(nearest.abs());
            // Error of W of a corner, except for the rounding when the origin is subtracted.
            let corner_error = largest_nearness * (1.25 * EPSILON);

            let (ux, uy, tx, ty) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
            let area = ux * ty - tx * uy;
            let sign = splat(simd, 1.0).copysign(area);
            let area = area * sign;
            let shows_back = (sign * front).simd_lt(splat(simd, 0.0));
            let (width, height, depth) = (x_max - x_min, y_max - y_min, nearest - farthest);
            let girth = width + height;
            let of_point = splat(simd, position_error * 1.001);
            let of_vertices = reach * (15.1 * EPSILON) + MOVED * 1.01;
            // Products that underflow lose their bound.
            let edge_error = girth * (of_vertices + of_point) + splat(simd, 1e-35);
            let is_certain = area.simd_gt(girth * of_vertices * 16.0);
            let of_group = one_sided >> (group * LANES) & 0xffff;
            let is_gone = is_certain & shows_back & mask32x16::from_bitmask(simd, of_group);

            let inverse = splat(simd, 1.0) / area;
            let signed = inverse * sign;
            let (rise1, rise2) = (w1 - w0, w2 - w0);
            let zero = splat(simd, 0.0);
            let p = is_certain.select((ty * rise1 - uy * rise2) * signed, zero);
            let q = is_certain.select((ux * rise2 - tx * rise1) * signed, zero);
            let r = w0 - (p * x0 + q * y0);
            let relative_depth = if face.is_parallel { depth } else { depth / largest_nearness };
            let of_predicate = width * of_width + height * of_height + relative_depth * of_depth;
            let depth_error = (p.abs() + q.abs()) * (reach * (10.1 * EPSILON) + MOVED * 1.01 + of_point)
                + corner_error
                + width * height * depth * inverse * (26.0 * EPSILON)
                + local_depth * (6.1 * EPSILON)
                + of_predicate * of_predicate * largest_nearness * inverse
                + nearness_error * 1.001;
            // Where it is NaN, nothing is certain.
            let is_bounded = is_certain & depth_error.simd_lt(splat(simd, 1e30));
            let depth_error = is_bounded.select(depth_error, splat(simd, f32::INFINITY));

            let (a0, b0) = ((y1 - y2) * sign, (x2 - x1) * sign);
            let (a1, b1) = (ty * sign, -tx * sign);
            let (a2, b2) = (-uy * sign, ux * sign);
            let c0 = edge_error - (a0 * x1 + b0 * y1);
            let c1 = edge_error - (a1 * x0 + b1 * y0);
            let c2 = edge_error - (a2 * x0 + b2 * y0);
            let slots = group * LANES..(group + 1) * LANES;
            store_quads(&mut self.quads[0][slots.clone()], quads([a0, b0, c0, p]));
            store_quads(&mut self.quads[1][slots.clone()], quads([a1, b1, c1, q]));
            store_quads(&mut self.quads[2][slots.clone()], quads([a2, b2, c2, r + depth_error]));
            (edge_error * 2.001).store_slice(&mut self.twice_edge_error[slots.clone()]);
            (depth_error * 2.001).store_slice(&mut self.twice_depth_error[slots.clone()]);
            // v, and the roundings of this sum and of that of the points' bounds.
            let margin = reach * (3.1 * EPSILON) + MOVED * 1.01;
            let nowhere = splat(simd, f32::INFINITY);
            is_gone.select(nowhere, x_min - margin).store_slice(&mut self.x[0][slots.clone()]);
            is_gone.select(-nowhere, x_max + margin).store_slice(&mut self.x[1][slots.clone()]);
            (y_min - margin).store_slice(&mut self.y[0][slots.clone()]);
            (y_max + margin).store_slice(&mut self.y[1][slots.clone()]);
            (nearest + corner_error + local_depth * (3.1 * EPSILON)).store_slice(&mut self.nearness[slots]);
        }
    }
}

#[inline(always)]
fn store_quads<S: Simd>(to: &mut [[f32; 4]], quads: [f32x16<S>; 4]) {
    for (quad, to) in quads.into_iter().zip(to.as_flattened_mut().chunks_exact_mut(LANES)) {
        quad.store_slice(to);
    }
}

#[cfg(test)]
mod tests;
