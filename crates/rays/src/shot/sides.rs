use glam::{DVec3, Vec3};

use super::{MaskAnswers, MaskPoints, Opacity, Shot};
use crate::{Camera, LightSource, Projection, Ray, Triangles, predicate};

/// The sides of triangles that stop rays: camera, shadow and any other rays.
///
/// A ray passes through a side that doesn't stop rays, as if there were no triangle. From the front, corners are seen
/// counterclockwise; a shadow ray comes from its light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides<'a> {
    /// Both sides of all triangles.
    #[default]
    Both,
    /// Only the front of all triangles.
    Front,
    /// The front of all triangles, and the back of those with a set bit: bit i % 64 of word i / 64 for triangle i. Triangles
    /// beyond the last word have both sides.
    Each(&'a [u64]),
}

impl Sides<'_> {
    /// Whether the back of a triangle stops rays, as its front does.
    #[inline]
    #[must_use]
    pub fn has_back(self, triangle: u32) -> bool {
        self.backs(triangle) & 1 == 1
    }

    /// The bits of the backs of 16 triangles from `first`, a multiple of 16.
    #[inline]
    pub fn sixteen_backs(self, first: u32) -> u64 {
        debug_assert!(first.is_multiple_of(16), "they are in one word");
        self.backs(first) & 0xffff
    }

    /// The bits of a triangle and of those after it in its word, the triangle's own lowest.
    #[inline]
    fn backs(self, triangle: u32) -> u64 {
        match self {
            Self::Both => u64::MAX,
            Self::Front => 0,
            Self::Each(bits) => bits.get(triangle as usize / 64).unwrap_or(&u64::MAX) >> (triangle % 64),
        }
    }

    /// Whether the side of a triangle that faces a ray's origin stops the ray.
    #[must_use]
    pub fn stop(self, ray: &Ray, triangle: u32, corners: [Vec3; 3]) -> bool {
        self.has_back(triangle) || predicate::is_front_along(ray.direction, corners)
    }

    /// Whether the side of a triangle that faces a light stops the light.
    #[must_use]
    pub fn stop_light(self, light: &LightSource, triangle: u32, corners: [Vec3; 3]) -> bool {
        self.has_back(triangle) || Source::of_light(light).falls_on_front(corners)
    }
}

/// The common origin, or direction, of the rays of a camera or light.
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

/// Opacity for the rays of a camera or a light that takes the sides of triangles into account.
#[derive(Clone, Copy)]
pub struct OpacityOfSides<'a> {
    pub triangles: Triangles<'a>,
    /// The opacity of triangles whose facing side stops rays.
    pub opacity: &'a dyn Opacity,
    pub sides: Sides<'a>,
    source: Source,
}

impl<'a> OpacityOfSides<'a> {
    pub fn of_camera(shot: &Shot<'a>) -> Self {
        let Shot { triangles, view, opacity, sides, .. } = *shot;
        Self { triangles, opacity, sides, source: Source::of_camera(view.camera) }
    }

    pub fn of_light(shot: &Shot<'a>, light: &LightSource) -> Self {
        let Shot { triangles, shadow_opacity, sides, .. } = *shot;
        Self::between(triangles, (shadow_opacity, sides), light)
    }

    /// The opacity of triangles for a light.
    pub fn between(
        triangles: Triangles<'a>,
        (opacity, sides): (&'a dyn Opacity, Sides<'a>),
        light: &LightSource,
    ) -> Self {
        Self { triangles, opacity, sides, source: Source::of_light(light) }
    }

    /// Whether the side of a triangle that faces the rays stops them. Either value for a triangle that can't be hit.
    pub fn is_there(&self, triangle: u32) -> bool {
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
