use super::face::{Face, ROUNDING};
use crate::shot::CameraRays;

/// How pixels with depths are mapped to a face: a projective map.
///
/// A pixel's column and row, and s, the inverse of its point's depth (in an orthographic view the depth itself), make
/// four linear functions R of (column, row, 1, s), and the point is at X = R₀ / R₃, Y = R₁ / R₃, W = R₂ / R₃. With the
/// camera at o and a ray's direction d, which is linear in column and row, the point is o + t d, and so its offset
/// from the light, over t, d + (o − l) / t. An orthographic camera has o linear in column and row in place of d.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelMap {
    /// The factors of column, row, one and s.
    pub(crate) rows: [[f64; 4]; 4],
    /// Error of each R against its value for the predicate's point: at most the first of its two numbers, plus s times the
    /// second.
    pub(crate) errors: [[f64; 2]; 4],
    /// The predicate's error of a point, in perspective in relation to its p.z: the first of these, plus s times the second,
    /// over R₃.
    pub(crate) point_errors: [f64; 2],
    /// Whether s is the inverse of the inverse depth.
    pub(crate) is_reciprocal: bool,
}

/// Indices in [`PixelMap::rows`].
pub(crate) const COLUMN: usize = 0;
pub(crate) const ROW: usize = 1;
pub(crate) const ONE: usize = 2;
pub(crate) const DEPTH: usize = 3;

impl PixelMap {
    pub fn new(face: &Face, rays: &CameraRays) -> Self {
        // The factors of one and of s, and the magnitudes of directions and of offsets from the light, in that order.
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
        // The function that is one, or becomes one when it is divided by t.
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
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3, Vec3};

    use super::super::choose::choose;
    use super::super::face::Face;
    use super::super::survey::SurveyedTile;
    use super::*;
    use crate::shot::CameraRays;
    use crate::shot::{SeenPixels, Shot};
    use crate::{Camera, LightSource, Projection, Triangles, View};

    /// X, Y and W of a world position.
    fn mapped(face: &Face, position: DVec3) -> [f64; 3] {
        let p = face.homogeneous(position);
        if face.is_parallel { p.to_array() } else { [p.x / p.z, p.y / p.z, face.near / p.z] }
    }

    #[test]
    fn pixels_are_where_their_points_are() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO, Vec3::Y, 0.7);
        let mut seen = SeenPixels::default();
        seen.resize(64, 64);
        for projection in [camera.projection, Projection::Orthographic { half_height: 2.0 }] {
            let view = View { camera: Camera { projection, ..camera }, width: 64, height: 64 };
            let offset_pixels = DVec2::new(0.25, 0.75);
            let shot = Shot { offset_pixels, ..Shot::new(Triangles::default(), view) };
            let rays = CameraRays::new(&shot);
            let tile = SurveyedTile { points: 1, corners: rays.frustum(0, [0.2, 0.4]), ..SurveyedTile::default() };
            let position = Vec3::new(3.0, 4.0, 1.0);
            for light in
                [LightSource::Point { position }, LightSource::Directional { direction: -position.normalize() }]
            {
                let mut faces = Vec::new();
                choose(&light, rays.step_x, &[tile], &mut faces).expect("a light");
                let map = PixelMap::new(&faces[0], &rays);
                for (column, row, t) in [(0.0, 0.0, 3.0), (17.0, 50.0, 4.0), (63.0, 2.0, 4.5)] {
                    let ray = view.ray(column + offset_pixels.x, row + offset_pixels.y);
                    let expected = mapped(&faces[0], ray.origin + ray.direction * t);
                    let s = if map.is_reciprocal { t } else { 1.0 / t };
                    let [x, y, w, d] = map.rows.map(|r| r[COLUMN] * column + r[ROW] * row + r[ONE] + r[DEPTH] * s);
                    for (found, expected) in [x / d, y / d, w / d].into_iter().zip(expected) {
                        assert!((found - expected).abs() < 1e-12, "{found} for {expected} of {light:?}");
                    }
                }
            }
        }
    }
}
