use glam::{DVec3, Vec3};

use crate::{Bounds, Ray};

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
        let projection = Projection::Perspective { tan_half_height: (0.5 * vertical_fov_radians).tan() };
        Self { position, right, up, forward, projection }
    }

    /// A camera that sees all of `bounds`, looking along `forward`, in an image of `aspect` (width over height).
    #[must_use]
    pub fn framing(bounds: Bounds, forward: Vec3, aspect: f32, vertical_fov_radians: f32) -> Self {
        let center = bounds.center();
        let mut camera = Self::look_at(center, center + forward, Vec3::Y, vertical_fov_radians);
        let tan_half_height = (0.5 * vertical_fov_radians).tan();
        let tan_half_width = tan_half_height * aspect;
        // Far enough back that every corner of the box is inside all four sides of the view.
        let distance = bounds.corners().into_iter().fold(0.0_f32, |distance, corner| {
            let offset = corner - center;
            let across =
                (offset.dot(camera.right).abs() / tan_half_width).max(offset.dot(camera.up).abs() / tan_half_height);
            distance.max(across - offset.dot(camera.forward))
        });
        const MARGIN: f32 = 1.05;
        let distance = if distance.is_finite() && distance > 0.0 { distance * MARGIN } else { 1.0 };
        camera.position = center - camera.forward * distance;
        camera
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
    /// The ray through a place in the image: `x_pixels` from 0 at the left edge to the width at the right one,
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
