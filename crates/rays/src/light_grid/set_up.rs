use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::boxes::{FaceBox, SixteenBoxes};
use super::face::{Face, HALF_ULP, VertexErrors};
use crate::simd::lanes::{load, load_local_corner, max3, min3};
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

/// Sixteen triangles of a patch, or its last ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleGroup<'a> {
    /// X, Y and W of the patch's vertices.
    pub(crate) vertices: &'a [[f32; 4]],
    /// The corners of each triangle, as indices of `vertices`.
    pub(crate) corners: &'a [[u8; 4]; LANES],
    pub(crate) ids: &'a [u32; LANES],
    /// A bit for each triangle; the other lanes are padding.
    pub(crate) filled: u16,
}

impl TriangleGroup<'_> {
    /// W of a triangle's corners.
    pub(crate) fn nearness_of_corners(&self, triangle: usize) -> [f32; 3] {
        let [a, b, c, _] = self.corners[triangle];
        [a, b, c].map(|corner| self.vertices[usize::from(corner)][2])
    }
}

/// The corners of a group's triangles on the face.
pub(crate) struct GroupCorners<S: Simd> {
    x: [f32x16<S>; 3],
    y: [f32x16<S>; 3],
    nearness: [f32x16<S>; 3],
    filled: mask32x16<S>,
}

impl<S: Simd> GroupCorners<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, group: &TriangleGroup<'_>) -> Self {
        let [x0, y0, w0] = load_local_corner(simd, group.vertices, group.corners, 0);
        let [x1, y1, w1] = load_local_corner(simd, group.vertices, group.corners, 1);
        let [x2, y2, w2] = load_local_corner(simd, group.vertices, group.corners, 2);
        let filled = mask32x16::from_bitmask(simd, group.filled.into());
        Self { x: [x0, x1, x2], y: [y0, y1, y2], nearness: [w0, w1, w2], filled }
    }

    /// The bounds of the points that the triangles may shadow, as these are found in relation to the tile's origin.
    ///
    /// With the names of [`SetUp::fill`]: a point in shadow is within the bounds of the true corners, and not nearer than
    /// the nearest. Along X and Y these are 1.125 ε beyond the rounded ones at most, and the point is found e beyond that.
    /// Subtraction is monotone, so corners are reduced before the origin is subtracted, which moves a bound by ε R; growing
    /// it by the margin makes another ε R, and ε of the margin. Along W, W + 1.125 ε |W| grows with W, in parallel light
    /// with one for a smaller |W|, so the nearest rounded corner bounds all true ones; two roundings of W in relation to the
    /// origin and the point's error come on top.
    #[inline(always)]
    pub(crate) fn bounds(&self, simd: S, face: &Face, extent: &Extent) -> FaceBox {
        let [origin_x, origin_y, origin_w] = extent.origin;
        let [position_error, nearness_error] = extent.errors;
        let infinity = splat(simd, f32::INFINITY);
        let low_x = self.filled.select(min3(self.x), infinity).reduce_min() - origin_x;
        let high_x = self.filled.select(max3(self.x), -infinity).reduce_max() - origin_x;
        let low_y = self.filled.select(min3(self.y), infinity).reduce_min() - origin_y;
        let high_y = self.filled.select(max3(self.y), -infinity).reduce_max() - origin_y;
        let nearest = self.filled.select(max3(self.nearness), -infinity).reduce_max();
        let reach = low_x.abs().max(high_x.abs()).max(low_y.abs().max(high_y.abs()));
        let margin = reach * (2.1 * EPSILON) + MOVED * 1.01 + position_error * 1.001;
        let local = nearest - origin_w;
        let largest_nearness = nearest.abs().max(if face.is_parallel { 1.0 } else { 0.0 });
        let depth_margin = largest_nearness * (1.25 * EPSILON) + local.abs() * (2.1 * EPSILON) + nearness_error * 1.001;
        FaceBox {
            x: [low_x - margin, high_x + margin],
            y: [low_y - margin, high_y + margin],
            nearness: local + depth_margin,
        }
    }
}

/// A group's triangles, set up for a tile's points. 76 bytes a triangle.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct SetUp {
    /// Bounds in X and Y in relation to the tile's origin, grown by the vertices' error; nearness of the nearest corner,
    /// grown by its error.
    pub(crate) bounds: SixteenBoxes,
    /// The numbers of [`Record::quads`], triangle after triangle.
    quads: [[[f32; LANES]; 4]; 3],
    /// Those of [`Record::errors`].
    errors: [[f32; LANES]; 2],
    /// A bit for each triangle that is there: neither padding nor seen from a side that it doesn't have.
    there: u16,
}

impl SetUp {
    pub(crate) const EMPTY: Self =
        Self { bounds: SixteenBoxes::NOTHING, quads: [[[0.0; LANES]; 4]; 3], errors: [[0.0; LANES]; 2], there: 0 };

    /// See [`Record::quads`].
    #[inline(always)]
    pub(crate) fn quads(&self, triangle: usize) -> [[f32; 4]; 3] {
        std::array::from_fn(|quad| std::array::from_fn(|number| self.quads[quad][number][triangle % LANES]))
    }

    /// The sixteen triangles' values of a quad of [`Record::quads`].
    #[inline(always)]
    fn quad_of_all<S: Simd>(&self, simd: S, quad: usize) -> [f32x16<S>; 4] {
        let [a, b, c, depth] = &self.quads[quad];
        [load(simd, a), load(simd, b), load(simd, c), load(simd, depth)]
    }

    /// Tests a point, on the triangle `own`, against all triangles: those that may shadow it, and those that certainly do.
    #[inline(always)]
    pub(crate) fn test_point<S: Simd>(
        &self,
        simd: S,
        ids: &[u32; LANES],
        [x, y, nearness]: [f32; 3],
        own: u32,
    ) -> [u16; 2] {
        let ([a0, b0, c0, p], [a1, b1, c1, q], [a2, b2, c2, r]) =
            (self.quad_of_all(simd, 0), self.quad_of_all(simd, 1), self.quad_of_all(simd, 2));
        let (x, y) = (splat(simd, x), splat(simd, y));
        let e0 = a0.mul_add(x, b0.mul_add(y, c0));
        let e1 = a1.mul_add(x, b1.mul_add(y, c1));
        let e2 = a2.mul_add(x, b2.mul_add(y, c2));
        let nearer = p.mul_add(x, q.mul_add(y, r)) - splat(simd, nearness);
        let least = min3([e0, e1, e2]);
        let zero = splat(simd, 0.0);
        let own = u32x16::simd_from(simd, *ids).simd_eq(u32x16::splat(simd, own));
        // Written so that NaN is possible.
        let missed = least.simd_lt(zero) | nearer.simd_lt(zero) | own;
        let possible = !(missed.to_bitmask() as u16) & self.there;
        let certain = least.simd_gt(load(simd, &self.errors[0])) & nearer.simd_gt(load(simd, &self.errors[1]));
        [possible, certain.to_bitmask() as u16 & possible]
    }

    pub(crate) fn record(&self, triangle: usize, id: u32) -> Record {
        Record { quads: self.quads(triangle), id, errors: self.errors(triangle) }
    }

    /// See [`Record::errors`].
    #[inline(always)]
    pub(crate) fn errors(&self, triangle: usize) -> [f32; 2] {
        std::array::from_fn(|number| self.errors[number][triangle % LANES])
    }

    /// Sets up the triangles of a group.
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
    /// certain it tells the side. Bounds of triangles that aren't there, and of padding, are turned around: no point is in
    /// them.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(
        &mut self,
        simd: S,
        face: &Face,
        vertex_errors: &VertexErrors,
        corners: &GroupCorners<S>,
        extent: &Extent,
        one_sided: u16,
    ) {
        let [origin_x, origin_y, origin_w] = extent.origin;
        let [position_error, nearness_error] = extent.errors;
        let of_parallel = if face.is_parallel { 1.0 } else { 0.0 };
        let [of_width, of_height, of_depth] = vertex_errors.of_predicate;
        let front = splat(simd, face.sign_of_fronts());
        let &GroupCorners { x: [x0, x1, x2], y: [y0, y1, y2], nearness: [w0, w1, w2], filled } = corners;
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
        let is_gone = is_certain & shows_back & mask32x16::from_bitmask(simd, one_sided.into());

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
        let quads = [[a0, b0, c0, p], [a1, b1, c1, q], [a2, b2, c2, r + depth_error]];
        for (quad, to) in quads.iter().zip(&mut self.quads) {
            for (number, to) in quad.iter().zip(to) {
                number.store_slice(to);
            }
        }
        (edge_error * 2.001).store_slice(&mut self.errors[0]);
        (depth_error * 2.001).store_slice(&mut self.errors[1]);
        // v, and the roundings of this sum and of that of the points' bounds.
        let margin = reach * (3.1 * EPSILON) + MOVED * 1.01;
        let (nowhere, is_there) = (splat(simd, f32::INFINITY), filled & !is_gone);
        self.there = is_there.to_bitmask() as u16;
        let SixteenBoxes { x, y, nearness } = &mut self.bounds;
        is_there.select(x_min - margin, nowhere).store_slice(&mut x[0]);
        is_there.select(x_max + margin, -nowhere).store_slice(&mut x[1]);
        (y_min - margin).store_slice(&mut y[0]);
        (y_max + margin).store_slice(&mut y[1]);
        (nearest + corner_error + local_depth * (3.1 * EPSILON)).store_slice(nearness);
    }
}

#[cfg(test)]
mod tests;
