use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Ray;

/// A camera in the world. Its three axes are of unit length and at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World position.
    pub position: Vec3,
    /// Towards the right edge of the image.
    pub right: Vec3,
    /// Towards the upper edge of the image.
    pub up: Vec3,
    /// Into the image.
    pub forward: Vec3,
    /// The spread of rays.
    pub projection: Projection,
}

/// The spread of a camera's rays. The width of the view follows from the image's: pixels are square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the camera.
    Perspective {
        /// Tangent of half the vertical field of view, above zero.
        tan_half_height: f32,
    },
    /// All rays are parallel and start in the camera's plane.
    Orthographic {
        /// Half the height of the view, in world units, above zero.
        half_height: f32,
    },
}

impl Camera {
    /// A perspective camera at `position` that looks at `target` with `world_up` upwards.
    ///
    /// A `target` at the camera, or straight along `world_up`, gives some valid camera rather than none.
    #[must_use]
    pub fn look_at(position: Vec3, target: Vec3, world_up: Vec3, vertical_fov_radians: f32) -> Self {
        let forward = (target - position).try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = forward
            .cross(world_up)
            .try_normalize()
            .filter(|right| right.is_finite())
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let projection = Projection::Perspective { tan_half_height: libm::tanf(0.5 * vertical_fov_radians) };
        Self { position, right, up, forward, projection }
    }

    /// The nearest camera that looks along `forward` and sees all finite `points` in an image of `aspect` (width over
    /// height): they fill [`FILL`](Self::FILL) of its width or of its height.
    ///
    /// The distance to the points depends only on their extent, however far they are from the origin. Where an `f32`
    /// position is too coarse, the camera turns and its field of view narrows or widens, so that the picture stays filled.
    ///
    /// Without points, or with one only, it is some valid camera that looks at it.
    #[must_use]
    pub fn framing<P>(points: P, forward: Vec3, aspect: f32, vertical_fov_radians: f32) -> Self
    where
        P: IntoParallelIterator<Item = Vec3>,
        P::Iter: Clone,
    {
        let mut camera = Self::look_at(Vec3::ZERO, forward, Vec3::Y, vertical_fov_radians);
        let points = points.into_par_iter().filter(|point| point.is_finite());
        let Some(first) = points.clone().find_first(|_| true) else { return camera };
        // Offsets from one of the points, so that nothing cancels: f64 holds the differences of all coordinates, and their
        // squares, exactly enough.
        let offset = |point: Vec3| point.as_dvec3() - first.as_dvec3();
        let tan_half_height = libm::tan(0.5 * f64::from(vertical_fov_radians)) * Self::FILL;
        let tan_half_width = tan_half_height * f64::from(aspect);
        let axes = |camera: &Self| [camera.right, camera.up, camera.forward].map(Vec3::as_dvec3);
        let in_axes = |[right, up, forward]: [DVec3; 3], point: DVec3| {
            DVec3::new(point.dot(right), point.dot(up), point.dot(forward))
        };
        // A point (x, y, z) in the camera's axes is inside the right edge of a camera at c when
        // x − c.x ≤ tan · (z − c.z), so when x − tan · z ≤ c.x − tan · c.z; the other three edges follow suit.
        let axes_before = axes(&camera);
        let reaches = points.clone().map(|point| {
            let DVec3 { x, y, z } = in_axes(axes_before, offset(point));
            let (beside, above) = (tan_half_width * z, tan_half_height * z);
            [x - beside, -x - beside, y - above, -y - above, z, -z]
        });
        let farther = |one: [f64; 6], other: [f64; 6]| std::array::from_fn(|edge| one[edge].max(other[edge]));
        let [right, left, top, bottom, farthest, nearest] = reaches.reduce(|| [f64::MIN; 6], farther);
        let nearest = -nearest;
        let depth_of_edges = (-0.5 * (right + left) / tan_half_width).min(-0.5 * (top + bottom) / tan_half_height);
        // In front of the nearest point by a quarter of the points' depth. A lone point has no depth: there by at least the
        // spacing of f32 at its coordinates.
        let least = f64::from(first.abs().max_element() * f32::EPSILON).max(f64::from(f32::MIN_POSITIVE));
        let depth = depth_of_edges.min(nearest - (0.25 * (farthest - nearest)).max(least));
        let [x, y] = [0.5 * (right - left), 0.5 * (top - bottom)];
        let [across, upwards, inwards] = axes_before;
        let wanted = first.as_dvec3() + across * x + upwards * y + inwards * depth;
        camera.position = wanted.as_vec3().clamp(Vec3::MIN, Vec3::MAX);
        let middle = across * x + upwards * y + inwards * (0.5 * (nearest + farthest));
        let distance = 0.5 * (nearest + farthest) - depth;
        if camera.position.as_dvec3().distance(wanted) > Self::COARSE * distance {
            camera.aim(middle - offset(camera.position), points.map(offset), aspect, offset(camera.position));
        }
        camera
    }

    /// The fraction of the picture's width or height, whichever fills first, that [`Camera::framing`]'s points fill.
    pub const FILL: f64 = 0.8;
    /// The largest rounding of the position that [`Camera::framing`] accepts, relative to the distance of the points'
    /// middle: a fifth of a pixel in a thousand.
    const COARSE: f64 = 1e-4;

    /// Turns the camera along `forward` and sets its field of view so that `points` fill [`FILL`](Self::FILL) of it.
    /// `points` and `position` count from the same origin. If a point is beside or behind the camera, it stays as it is.
    fn aim(&mut self, forward: DVec3, points: impl ParallelIterator<Item = DVec3>, aspect: f32, position: DVec3) {
        let turned = Self::look_at(Vec3::ZERO, forward.normalize_or(DVec3::NEG_Z).as_vec3(), Vec3::Y, 1.0);
        let [right, up, forward] = [turned.right, turned.up, turned.forward].map(Vec3::as_dvec3);
        let tangents = points.map(|point| {
            let (x, y, z) =
                ((point - position).dot(right), (point - position).dot(up), (point - position).dot(forward));
            if z > 0.0 { (x / f64::from(aspect)).abs().max(y.abs()) / z } else { f64::INFINITY }
        });
        let tangent = tangents.reduce(|| 0.0, f64::max);
        let tan_half_height = (tangent / Self::FILL) as f32;
        if tan_half_height.is_finite() && tan_half_height > 0.0 {
            *self = Self { projection: Projection::Perspective { tan_half_height }, position: self.position, ..turned };
        }
    }
}

/// A camera with an image size: the source of camera rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
}

impl View {
    /// The ray through a point of the image: `x_pixels` from 0 at the left edge to the width at the right one,
    /// `y_pixels` from 0 at the upper edge to the height at the lower one.
    ///
    /// For both projections t is the depth along [`Camera::forward`] in world units.
    #[must_use]
    pub fn ray(&self, x_pixels: f64, y_pixels: f64) -> Ray {
        let Camera { position, right, up, forward, projection } = self.camera;
        let height = f64::from(self.height);
        let x = (2.0 * x_pixels - f64::from(self.width)) / height;
        let y = (height - 2.0 * y_pixels) / height;
        let across = |half_height: f32| {
            let half_height = f64::from(half_height);
            right.as_dvec3() * (x * half_height) + up.as_dvec3() * (y * half_height)
        };
        let (origin, direction): (DVec3, DVec3) = match projection {
            Projection::Perspective { tan_half_height } => {
                (position.as_dvec3(), forward.as_dvec3() + across(tan_half_height))
            }
            Projection::Orthographic { half_height } => (position.as_dvec3() + across(half_height), forward.as_dvec3()),
        };
        Ray::new(origin, direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounds;

    /// Returns the position of a world point in the image, in pixels.
    fn pixel(view: &View, point: Vec3) -> (f32, f32) {
        let Camera { position, right, up, forward, projection } = view.camera;
        let Projection::Perspective { tan_half_height } = projection else { panic!("a perspective camera") };
        let offset = point - position;
        let scale = view.height as f32 / (2.0 * tan_half_height * offset.dot(forward));
        let (x, y) = (offset.dot(right) * scale, offset.dot(up) * scale);
        (0.5 * view.width as f32 + x, 0.5 * view.height as f32 - y)
    }

    /// The largest distance of a point from the middle of the image, across or up, in halves of the image's sides.
    fn filled(camera: Camera, points: &[Vec3], [width, height]: [u32; 2]) -> f64 {
        let view = View { camera, width, height };
        points.iter().fold(0.0, |most, &point| {
            let offset = point.as_dvec3() - camera.position.as_dvec3();
            let depth = offset.dot(camera.forward.as_dvec3());
            assert!(depth > 0.0, "{point} is behind {camera:?}");
            let ray = |x, y| view.ray(x, y).direction - camera.forward.as_dvec3();
            let (right, up) = (ray(f64::from(width), 0.5 * f64::from(height)), ray(0.5 * f64::from(width), 0.0));
            let across = |edge: DVec3| (offset.dot(edge) / depth / edge.length_squared()).abs();
            most.max(across(right)).max(across(up))
        })
    }

    /// Sizes of pictures: wide, square and narrow.
    const SIZES: [[u32; 2]; 3] = [[300, 100], [100, 100], [100, 150]];
    const FORWARD: Vec3 = Vec3::new(-0.5, -0.4, -1.0);

    #[test]
    fn a_framed_scene_fills_a_part_of_the_image_and_no_more() {
        for size in SIZES {
            let points = [Vec3::new(1.0, 2.0, 1.0), Vec3::new(-4.0, 3.0, 1.0), Vec3::new(2.0, -1.0, -5.0), Vec3::ZERO];
            let camera = Camera::framing(points, FORWARD, size[0] as f32 / size[1] as f32, 0.7);
            let filled = filled(camera, &points, size);
            assert!((filled - Camera::FILL).abs() < 1e-4, "{filled} of {size:?}");
        }
    }

    #[test]
    fn a_scene_is_framed_alike_at_any_size_and_far_from_the_origin() {
        let corners = |scale: f32, offset: Vec3| Bounds { min: offset, max: offset + Vec3::splat(scale) }.corners();
        for size in SIZES {
            let fills = |points: [Vec3; 8]| {
                let camera = Camera::framing(points, FORWARD, size[0] as f32 / size[1] as f32, 0.7);
                assert!(camera.position.is_finite());
                filled(camera, &points, size)
            };
            for scale in [1e-20, 1e-10, 1e-3, 1.0, 1e10, 1e30] {
                for steps in [0.0, 1.0, -1e3] {
                    let filled = fills(corners(scale, Vec3::new(steps, 2.0 * steps, -steps) * scale));
                    assert!((filled - Camera::FILL).abs() < 1e-3, "{filled} of {size:?} at {scale}, {steps}");
                }
            }
            // Neighbouring floats are 3 cm apart on the first axis and half a metre on the second.
            for (metres, offset) in [(1.0, Vec3::new(5e5, 4_649_776.0, 100.0)), (30.0, Vec3::new(100.0, 1e4, -5.4e6))] {
                let filled = fills(corners(metres, offset));
                assert!((filled - Camera::FILL).abs() < 0.01, "{filled} of {size:?} at {offset}");
            }
        }
    }

    #[test]
    fn a_lone_point_is_in_front_of_the_camera_that_frames_it() {
        for point in [Vec3::ZERO, Vec3::ONE, Vec3::new(-5e6, 1e-9, 3.0), Vec3::splat(1e30)] {
            let camera = Camera::framing([point, Vec3::NAN], FORWARD, 1.0, 0.7);
            assert!((point - camera.position).as_dvec3().dot(camera.forward.as_dvec3()) > 0.0, "{camera:?}");
        }
    }

    #[test]
    fn rays_go_through_their_pixels() {
        let camera = Camera::look_at(Vec3::new(3.0, 1.0, 2.0), Vec3::ZERO, Vec3::Y, 0.8);
        let view = View { camera, width: 64, height: 48 };
        let ray = view.ray(10.25, 40.5);
        let (x, y) = pixel(&view, (ray.origin + ray.direction * 3.0).as_vec3());
        assert!((x - 10.25).abs() < 1e-3 && (y - 40.5).abs() < 1e-3, "({x}, {y})");
    }

    #[test]
    fn cameras_without_a_direction_are_valid_all_the_same() {
        for target in [Vec3::ZERO, Vec3::Y, Vec3::NAN] {
            let camera = Camera::look_at(Vec3::ZERO, target, Vec3::Y, 0.8);
            for axis in [camera.right, camera.up, camera.forward] {
                assert!((axis.length() - 1.0).abs() < 1e-5, "{camera:?}");
            }
        }
    }
}
