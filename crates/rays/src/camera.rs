use glam::{DVec3, Vec3};

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
    /// How rays spread.
    pub projection: Projection,
}

/// How a camera's rays spread. The width of the view follows from the image's: pixels are square.
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

    /// The nearest camera that looks along `forward` and sees all of the finite ones of `points` in an image of `aspect`
    /// (width over height), with a small margin.
    ///
    /// Without points, or with one only, it is some valid camera that looks at it.
    #[must_use]
    pub fn framing(
        points: impl IntoIterator<Item = Vec3>,
        forward: Vec3,
        aspect: f32,
        vertical_fov_radians: f32,
    ) -> Self {
        const MARGIN: f32 = 1.06;
        let camera = Self::look_at(Vec3::ZERO, forward, Vec3::Y, vertical_fov_radians);
        let tan_half_height = libm::tanf(0.5 * vertical_fov_radians) / MARGIN;
        let tan_half_width = tan_half_height * aspect;
        // A point (x, y, z) in the camera's axes is inside the right edge of a camera at c when
        // x − c.x ≤ tan · (z − c.z), so when x − tan · z ≤ c.x − tan · c.z; the other three edges follow suit.
        let (mut right, mut left, mut top, mut bottom) = (f32::MIN, f32::MIN, f32::MIN, f32::MIN);
        let (mut nearest, mut farthest) = (f32::MAX, f32::MIN);
        for point in points.into_iter().filter(|point| point.is_finite()) {
            let (x, y, z) = (point.dot(camera.right), point.dot(camera.up), point.dot(camera.forward));
            right = right.max(x - tan_half_width * z);
            left = left.max(-x - tan_half_width * z);
            top = top.max(y - tan_half_height * z);
            bottom = bottom.max(-y - tan_half_height * z);
            (nearest, farthest) = (nearest.min(z), farthest.max(z));
        }
        if right == f32::MIN {
            return camera;
        }
        // Not so near that something sticks into the lens, nor in a lone point itself.
        let clearance = (0.25 * (farthest - nearest)).max(1e-3 * nearest.abs()).max(f32::MIN_POSITIVE);
        let depth = (-0.5 * (right + left) / tan_half_width)
            .min(-0.5 * (top + bottom) / tan_half_height)
            .min(nearest - clearance);
        let position =
            camera.right * (0.5 * (right - left)) + camera.up * (0.5 * (top - bottom)) + camera.forward * depth;
        Self { position, ..camera }
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

    /// Where a world point is in the image, in pixels.
    fn pixel(view: &View, point: Vec3) -> (f32, f32) {
        let Camera { position, right, up, forward, projection } = view.camera;
        let Projection::Perspective { tan_half_height } = projection else { panic!("a perspective camera") };
        let offset = point - position;
        let scale = view.height as f32 / (2.0 * tan_half_height * offset.dot(forward));
        let (x, y) = (offset.dot(right) * scale, offset.dot(up) * scale);
        (0.5 * view.width as f32 + x, 0.5 * view.height as f32 - y)
    }

    #[test]
    fn a_framed_scene_fills_the_image_and_no_more() {
        for (width, height) in [(300, 100), (100, 100), (100, 150)] {
            let points = [Vec3::new(1.0, 2.0, 1.0), Vec3::new(-4.0, 3.0, 1.0), Vec3::new(2.0, -1.0, -5.0), Vec3::ZERO];
            let camera = Camera::framing(points, Vec3::new(-0.5, -0.4, -1.0), width as f32 / height as f32, 0.7);
            let view = View { camera, width, height };
            let pixels = points.map(|point| pixel(&view, point));
            let (widest, tallest) = pixels.iter().fold((0.0_f32, 0.0_f32), |(widest, tallest), (x, y)| {
                assert!((0.0..=width as f32).contains(x) && (0.0..=height as f32).contains(y), "({x}, {y})");
                let across = |at: f32, side: u32| (2.0 * at / side as f32 - 1.0).abs();
                (widest.max(across(*x, width)), tallest.max(across(*y, height)))
            });
            assert!(widest.max(tallest) > 0.9, "{widest} {tallest}");
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
