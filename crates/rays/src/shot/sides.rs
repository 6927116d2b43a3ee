use super::{MaskAnswers, MaskPoints, Opacity, Shot};
use crate::{Camera, Projection, Ray, predicate};

/// Which sides of triangles stop camera rays. Shadow rays are stopped by both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// Both.
    #[default]
    Both,
    /// The front: camera rays go through triangles whose corners they see clockwise.
    Front,
}

impl Sides {
    /// Whether a ray is stopped by triangle `corners` for the side that it meets.
    #[must_use]
    pub fn stop(self, ray: &Ray, corners: [glam::Vec3; 3]) -> bool {
        self == Self::Both || predicate::is_front_along(ray.direction, corners)
    }
}

/// What stops a camera's rays, with the sides of triangles taken into account.
#[derive(Clone, Copy)]
pub(crate) struct OpacityOfSides<'a>(pub(crate) &'a Shot<'a>);

impl OpacityOfSides<'_> {
    /// Whether the camera sees a side of a triangle that stops its rays.
    fn is_seen(&self, triangle: u32) -> bool {
        let Shot { triangles, view, sides, .. } = self.0;
        if *sides == Sides::Both {
            return true;
        }
        let Camera { position, forward, projection, .. } = view.camera;
        let corners = triangles.corners(triangle);
        match projection {
            Projection::Perspective { .. } => predicate::is_front_from(position.as_dvec3(), corners),
            Projection::Orthographic { .. } => predicate::is_front_along(forward.as_dvec3(), corners),
        }
    }
}

impl Opacity for OpacityOfSides<'_> {
    fn is_opaque(&self, triangle: u32) -> bool {
        self.0.opacity.is_opaque(triangle) && self.is_seen(triangle)
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self.is_seen(triangle) && self.0.opacity.is_stopped_at(triangle, barycentric)
    }

    fn which_stop(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        if !self.is_seen(triangle) {
            MaskAnswers { opaque: 0, cut: points.lanes }
        } else if self.0.opacity.is_opaque(triangle) {
            MaskAnswers { opaque: points.lanes, cut: 0 }
        } else {
            self.0.opacity.which_stop(triangle, points)
        }
    }
}
