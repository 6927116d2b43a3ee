use super::face::{Face, ROUNDING};
use super::survey::CameraRays;

/// How pixels with depths are mapped to a face: a projective map.
///
/// A pixel's column and row, and s, the inverse of its point's depth (in an orthographic view the depth itself), make
/// four linear functions R of (column, row, 1, s), and the point is at X = R₀ / R₃, Y = R₁ / R₃, W = R₂ / R₃. With the
/// camera at o and a ray's direction d, which is linear in column and row, the point is o + t d, and so its offset
/// from the light, over t, d + (o − l) / t. An orthographic camera has o linear in column and row in place of d.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelMap {
    /// The factors of column, row, one and s.
    pub(super) rows: [[f64; 4]; 4],
    /// How far each R is from what it would be for the predicate's point: at most the first of its two numbers, plus s
    /// times the second.
    pub(super) errors: [[f64; 2]; 4],
    /// The predicate takes a point for what may be as far from it as the first of these, plus s times the second, over
    /// R₃; in relation to its p.z in perspective.
    pub(super) point_errors: [f64; 2],
    /// Whether s is the inverse of the inverse depth.
    pub(super) is_reciprocal: bool,
}

/// Places in [`PixelMap::rows`].
pub(super) const COLUMN: usize = 0;
pub(super) const ROW: usize = 1;
pub(super) const ONE: usize = 2;
pub(super) const DEPTH: usize = 3;

impl PixelMap {
    pub(super) fn new(face: &Face, rays: &CameraRays) -> Self {
        // What is multiplied with one and with s, and the magnitudes of directions and of offsets from the light, in
        // that order.
        let largest = rays.largest_origin + face.origin.abs().max_element();
        let (constant, varying, sizes) = if rays.is_perspective {
            (rays.corner, rays.position - face.origin, [rays.largest_direction, largest])
        } else {
            (rays.corner - face.origin, rays.forward, [largest, rays.largest_direction])
        };
        let axes = [face.x, face.y, face.z];
        let [x, y, z] =
            axes.map(|axis| [axis.dot(rays.step_x), axis.dot(rays.step_y), axis.dot(constant), axis.dot(varying)]);
        // The predicate's own ray and point have ten roundings, the factors here and their sums less than twenty.
        let norms = face.norms() * (64.0 * ROUNDING);
        let [error_x, error_y, error_z] = norms.to_array().map(|norm| sizes.map(|size| size * norm));
        // One, or what becomes one when it is divided by t.
        let unit = if rays.is_perspective { [0.0, 0.0, 0.0, 1.0] } else { [0.0, 0.0, 1.0, 0.0] };
        let (rows, errors) = if face.is_parallel {
            ([x, y, z, unit], [error_x, error_y, error_z, [0.0; 2]])
        } else {
            ([x, y, unit.map(|factor| factor * face.near), z], [error_x, error_y, [0.0; 2], error_z])
        };
        let point_errors = if rays.is_perspective {
            [10.0 * ROUNDING * rays.largest_direction, 5.0 * ROUNDING * rays.largest_origin]
        } else {
            [5.0 * ROUNDING * rays.largest_origin, 10.0 * ROUNDING * rays.largest_direction]
        };
        Self { rows, errors, point_errors, is_reciprocal: !rays.is_perspective }
    }

    /// The constant part of each R at a column and row.
    #[cfg(test)]
    pub(super) fn at(&self, column: f64, row: f64, s: f64) -> [f64; 3] {
        let [x, y, w, d] = self.rows.map(|r| r[COLUMN] * column + r[ROW] * row + r[ONE] + r[DEPTH] * s);
        [x / d, y / d, w / d]
    }
}
