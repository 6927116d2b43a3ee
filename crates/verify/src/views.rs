//! Cameras for the test meshes.

use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, Projection, View};

/// Offset of rays in each pixel: not the middle, where symmetric meshes have seams.
pub const OFFSET_PIXELS: DVec2 = DVec2::new(0.5, 0.375);

/// A camera above the middle of the world that looks slightly downwards.
#[must_use]
pub fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8)
}

/// The same, with parallel rays.
#[must_use]
pub fn parallel_camera() -> Camera {
    Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera() }
}

/// A camera `far` away that sees the room as if it were near: its points' errors are about as large as their distances
/// from lights among them.
#[must_use]
pub fn telescope(far: f32) -> Camera {
    let forward = Vec3::new(-0.25, -0.5, -1.0).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let projection = Projection::Perspective { tan_half_height: 1.5 / far };
    Camera { position: -forward * far, right, up: right.cross(forward), forward, projection }
}

/// The camera that sees the same of a scaled and moved world as `camera` sees of the world.
#[must_use]
pub fn placed(camera: Camera, scale: f32, offset: Vec3) -> Camera {
    let projection = match camera.projection {
        Projection::Orthographic { half_height } => Projection::Orthographic { half_height: half_height * scale },
        perspective @ Projection::Perspective { .. } => perspective,
    };
    Camera { position: camera.position * scale + offset, projection, ..camera }
}

/// A camera with an image.
#[must_use]
pub fn view(camera: Camera, width: u32, height: u32) -> View {
    View { camera, width, height }
}
