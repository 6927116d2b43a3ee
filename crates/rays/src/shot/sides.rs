use glam::{DVec3, Vec3};

use super::{MaskAnswers, MaskPoints, Opacity, Shot};
use crate::{Camera, LightSource, Projection, Ray, Triangles, predicate};

/// Which sides of triangles stop rays, be they a camera's, a light's or any others.
///
/// A ray that comes to a side that isn't there goes through, as if there were no triangle. The front is the side from which
/// corners are seen counterclockwise; a shadow ray comes from its light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides<'a> {
    /// Both sides of all.
    #[default]
    Both,
    /// Only the front of all.
    Front,
    /// The front, and the back of those that have a bit here: that of triangle i is bit i % 64 of word i / 64. What is
    /// beyond the last word has both.
    Each(&'a [u64]),
}

impl Sides<'_> {
    /// Whether the back of a triangle stops rays, as its front does.
    #[inline]
    #[must_use]
    pub fn has_back(self, triangle: u32) -> bool {
        self.backs(triangle) & 1 == 1
    }

    /// Which of 16 triangles, of which the first is a multiple of 16, have a back that stops rays.
    #[inline]
    pub(crate) fn sixteen_backs(self, first: u32) -> u64 {
        debug_assert!(first.is_multiple_of(16), "they are in one word");
        self.backs(first) & 0xffff
    }

    /// The bits from a triangle's on, of those that are in its word.
    #[inline]
    fn backs(self, triangle: u32) -> u64 {
        match self {
            Self::Both => u64::MAX,
            Self::Front => 0,
            Self::Each(bits) => bits.get(triangle as usize / 64).unwrap_or(&u64::MAX) >> (triangle % 64),
        }
    }

    /// Whether a ray is stopped by the side of a triangle that it comes to.
    #[must_use]
    pub fn stop(self, ray: &Ray, triangle: u32, corners: [Vec3; 3]) -> bool {
        self.has_back(triangle) || predicate::is_front_along(ray.direction, corners)
    }

    /// Whether a light is stopped by the side of a triangle that it falls on.
    #[must_use]
    pub fn stop_light(self, light: &LightSource, triangle: u32, corners: [Vec3; 3]) -> bool {
        self.has_back(triangle) || Source::of_light(light).falls_on_front(corners)
    }
}

/// Where the rays come from that a camera, or a light, has in common.
#[derive(Clone, Copy)]
enum Source {
    Point(DVec3),
    Direction(DVec3),
}

impl Source {
    fn of_camera(Camera { position, forward, projection, .. }: Camera) -> Self {
        match projection {
            Projection::Perspective { .. } => Self::Point(position.as_dvec3()),
            Projection::Orthographic { .. } => Self::Direction(forward.as_dvec3()),
        }
    }

    fn of_light(light: &LightSource) -> Self {
        match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => Self::Point(position.as_dvec3()),
            LightSource::Directional { direction } => Self::Direction(direction.as_dvec3()),
        }
    }

    fn falls_on_front(self, corners: [Vec3; 3]) -> bool {
        match self {
            Self::Point(point) => predicate::is_front_from(point, corners),
            Self::Direction(direction) => predicate::is_front_along(direction, corners),
        }
    }
}

/// What stops the rays from a camera or a light, with the sides of triangles taken into account.
#[derive(Clone, Copy)]
pub(crate) struct OpacityOfSides<'a> {
    pub(crate) triangles: Triangles<'a>,
    /// Of triangles whose sides stop rays.
    pub(crate) opacity: &'a dyn Opacity,
    pub(crate) sides: Sides<'a>,
    source: Source,
}

impl<'a> OpacityOfSides<'a> {
    pub(crate) fn of_camera(shot: &Shot<'a>) -> Self {
        let Shot { triangles, view, opacity, sides, .. } = *shot;
        Self { triangles, opacity, sides, source: Source::of_camera(view.camera) }
    }

    pub(crate) fn of_light(shot: &Shot<'a>, light: &LightSource) -> Self {
        let Shot { triangles, shadow_opacity, sides, .. } = *shot;
        Self::between(triangles, (shadow_opacity, sides), light)
    }

    /// What of triangles stops a light.
    pub(crate) fn between(
        triangles: Triangles<'a>,
        (opacity, sides): (&'a dyn Opacity, Sides<'a>),
        light: &LightSource,
    ) -> Self {
        Self { triangles, opacity, sides, source: Source::of_light(light) }
    }

    /// Whether rays come to a side of a triangle that stops them, where they hit it; anything of one that can't be hit.
    pub(crate) fn is_there(&self, triangle: u32) -> bool {
        let faces = || self.source.falls_on_front(self.triangles.corners(triangle));
        self.sides.has_back(triangle) || self.triangles.has_all_corners(triangle) && faces()
    }
}

impl Opacity for OpacityOfSides<'_> {
    fn is_opaque(&self, triangle: u32) -> bool {
        self.opacity.is_opaque(triangle) && self.is_there(triangle)
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        self.is_there(triangle) && self.opacity.is_stopped_at(triangle, barycentric)
    }

    fn which_stop(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        if !self.is_there(triangle) {
            MaskAnswers { opaque: 0, cut: points.lanes }
        } else if self.opacity.is_opaque(triangle) {
            MaskAnswers { opaque: points.lanes, cut: 0 }
        } else {
            self.opacity.which_stop(triangle, points)
        }
    }
}
