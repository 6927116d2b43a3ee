//! Motion of the pixels' hits until a moment later.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3};
use umbrage_rays::{Camera, Hit, Projection, View};
use umbrage_scene::Frame;

use crate::engine::Staged;
use crate::frame::Subject;
use crate::{Error, Layer};

/// A frame, and the same scene and camera a moment later.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Next<'a> {
    frame: &'a Frame,
    /// The views from the middle of the lens, now and then.
    views: [View; 2],
    /// Whether both moments have the same triangles.
    is_same_mesh: bool,
}

impl<'a> Next<'a> {
    /// The moment after a frame that is posed `posed_at` seconds after its own, posed in memory that is used again; `None`
    /// unless motion is asked for.
    ///
    /// # Errors
    /// Where the scene can't be posed then, or has no such camera.
    pub(crate) fn of(
        subject: Subject<'_>,
        posed_at: f64,
        staged: &Staged<'_>,
        memory: &'a mut Frame,
    ) -> Result<Option<Self>, Error> {
        let Staged { settings, view, .. } = *staged;
        if !settings.layers.has(Layer::Motion) {
            return Ok(None);
        }
        let after = subject.after(posed_at + settings.motion_seconds);
        let Subject::Moment(scene, moment) = after else { return Ok(None) };
        scene.pose(moment, memory)?;
        let [now, then] = [&staged.frame.mesh, &memory.mesh];
        let is_same_mesh = Arc::ptr_eq(now, then) || now.triangles == then.triangles;
        let views = [view, settings.view(memory)?];
        Ok(Some(Self { frame: memory, views, is_same_mesh }))
    }

    /// The motion of a hit in `frame`, in pixels to the right and downwards; zero where it isn't known.
    pub(crate) fn motion(&self, frame: &Frame, hit: &Hit) -> Vec2 {
        let pixel = |frame: &Frame, view: &View| {
            let [a, b, c] = frame.triangles().corners(hit.triangle).map(Vec3::as_dvec3);
            let [second, third] = hit.barycentric.map(f64::from);
            pixel_of(view, a * (1.0 - second - third) + b * second + c * third)
        };
        let [now, then] = &self.views;
        match (pixel(frame, now), self.is_same_mesh.then(|| pixel(self.frame, then)).flatten()) {
            (Some(from), Some(to)) => {
                Some((to - from).as_vec2()).filter(|motion| motion.is_finite()).unwrap_or_default()
            }
            _ => Vec2::ZERO,
        }
    }
}

/// The position of a point in the image, in pixels from its upper left corner; `None` behind the camera.
fn pixel_of(view: &View, point: DVec3) -> Option<DVec2> {
    let position = along_axes(view, point);
    let is_behind = matches!(view.camera.projection, Projection::Perspective { .. }) && position.z <= 0.0;
    (!is_behind).then(|| in_image(view, position))
}

/// A point of the world along the camera's axes; z is its depth.
pub(crate) fn along_axes(view: &View, point: DVec3) -> DVec3 {
    let Camera { position, right, up, forward, .. } = view.camera;
    let offset = point - position.as_dvec3();
    DVec3::from([right, up, forward].map(|axis| offset.dot(axis.as_dvec3())))
}

/// The pixels from the image's upper left corner to a point before the camera, given along its axes.
pub(crate) fn in_image(view: &View, point: DVec3) -> DVec2 {
    let half_height = match view.camera.projection {
        Projection::Perspective { tan_half_height } => f64::from(tan_half_height) * point.z,
        Projection::Orthographic { half_height } => f64::from(half_height),
    };
    let half_size = 0.5 * DVec2::new(view.width.into(), view.height.into());
    half_size + DVec2::new(point.x, -point.y) * (half_size.y / half_height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_rays_are_where_the_rays_go_through_the_image() {
        let camera = Camera::look_at(Vec3::new(3.1, -1.7, 2.3), Vec3::ZERO, Vec3::Y, 0.83);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera };
        for camera in [camera, parallel] {
            let view = View { camera, width: 64, height: 48 };
            for (x, y) in [(0.0, 0.0), (10.25, 40.5), (64.0, 7.0)] {
                let ray = view.ray(x, y);
                let pixel = pixel_of(&view, ray.origin + ray.direction * 3.0).unwrap();
                assert!(pixel.distance(DVec2::new(x, y)) < 1e-5, "{pixel}");
            }
        }
        let view = View { camera, width: 64, height: 48 };
        assert!(pixel_of(&view, (camera.position - camera.forward).as_dvec3()).is_none());
    }
}
