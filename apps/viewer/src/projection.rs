//! Conversion between the world and the screen.

use eframe::egui::{Pos2, Rect, pos2};
use glam::Vec3;
use umbrage::rays::{Camera, Projection, View};

/// A picture's camera and its rectangle on the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projected {
    pub(crate) camera: Camera,
    /// The picture's rectangle, in points.
    pub(crate) rect: Rect,
}

impl Projected {
    pub(crate) fn new(view: &View, rect: Rect) -> Self {
        Self { camera: view.camera, rect }
    }

    /// Projects a world point to the screen; `None` behind the camera.
    pub(crate) fn on_screen(&self, point: Vec3) -> Option<Pos2> {
        let Camera { position, right, up, forward, .. } = self.camera;
        let offset = point - position;
        let depth = offset.dot(forward);
        let height = self.height_at(depth)?;
        let scale = self.rect.height() / height;
        let center = self.rect.center();
        let position = pos2(center.x + offset.dot(right) * scale, center.y - offset.dot(up) * scale);
        (position.x.is_finite() && position.y.is_finite()).then_some(position)
    }

    /// The picture's height at a depth, in world units; `None` behind the camera.
    pub(crate) fn height_at(&self, depth: f32) -> Option<f32> {
        match self.camera.projection {
            Projection::Perspective { tan_half_height } => (depth > 0.0).then_some(2.0 * tan_half_height * depth),
            Projection::Orthographic { half_height } => Some(2.0 * half_height),
        }
    }

    /// Origin and direction of the ray through a position on the screen. The direction's component along the camera's axis
    /// is 1.
    pub(crate) fn ray(&self, pointer: Pos2) -> (Vec3, Vec3) {
        let Camera { position, right, up, forward, projection } = self.camera;
        let offset = (pointer - self.rect.center()) * (2.0 / self.rect.height());
        let across = |half_height: f32| (right * offset.x - up * offset.y) * half_height;
        match projection {
            Projection::Perspective { tan_half_height } => (position, forward + across(tan_half_height)),
            Projection::Orthographic { half_height } => (position + across(half_height), forward),
        }
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::vec2;

    use super::*;

    #[test]
    fn positions_and_rays_agree() {
        let camera = Camera::look_at(Vec3::new(3.0, 1.0, 2.0), Vec3::ZERO, Vec3::Y, 0.8);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 2.0 }, ..camera };
        for camera in [camera, parallel] {
            let picture = Projected { camera, rect: Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 200.0)) };
            let point = Vec3::new(0.4, -0.2, 0.3);
            let position = picture.on_screen(point).expect("in front");
            let (origin, direction) = picture.ray(position);
            let depth = (point - camera.position).dot(camera.forward);
            assert!((origin + direction * depth).distance(point) < 1e-4);
        }
    }

    #[test]
    fn what_is_behind_is_not_on_the_screen() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.8);
        let picture = Projected { camera, rect: Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 200.0)) };
        assert_eq!(picture.on_screen(Vec3::new(0.0, 0.0, 2.0)), None);
        assert_eq!(picture.on_screen(Vec3::ZERO), Some(pos2(150.0, 100.0)));
    }
}
