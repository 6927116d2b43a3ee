use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_rays::LightSource;

/// A light of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file; may be empty.
    pub name: Arc<str>,
    /// Kind, position and direction.
    pub source: LightSource,
    /// Linear colour.
    pub color: Vec3,
    /// Candela for point and spot lights; for flat ones candela straight ahead (π times as many lumens); lux for
    /// directional ones.
    pub intensity: f32,
    /// Distance at which the light has faded to nothing, in world units; `None` for never.
    pub range: Option<f32>,
    /// Whether triangles block this light.
    pub casts_shadow: bool,
    /// Size and form: lights larger than a point cast soft shadows, given several samples.
    pub shape: LightShape,
}

/// The emitting surface of a light, centred on its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// A ball of this radius in world units. For a directional light, a disk in the sky of this radius in degrees. With 0,
    /// all light comes from one point.
    Ball(f32),
    /// A flat rectangle around a source made by [`LightSource::to_one_side`]. Its radiance is equal in all directions in
    /// front, so its intensity falls off with the cosine. The width is horizontal, or along x where it faces straight up
    /// or down.
    Rectangle {
        /// In world units.
        width: f32,
        /// In world units, across the width.
        height: f32,
    },
    /// A flat disk of this radius in world units, which emits like [a rectangle](Self::Rectangle).
    Disk(f32),
}

impl LightShape {
    /// All light comes from one point.
    pub const POINT: Self = Self::Ball(0.0);

    /// Whether light comes from more than one point.
    #[must_use]
    pub fn is_wide(self) -> bool {
        match self {
            Self::Ball(radius) | Self::Disk(radius) => radius > 0.0,
            Self::Rectangle { width, height } => width.max(height) > 0.0,
        }
    }

    /// The same shape with size zero: all light comes from the centre.
    #[must_use]
    pub fn narrowed(self) -> Self {
        match self {
            Self::Ball(_) => Self::POINT,
            Self::Disk(_) => Self::Disk(0.0),
            Self::Rectangle { .. } => Self::Rectangle { width: 0.0, height: 0.0 },
        }
    }

    /// Whether the shape is flat: it then emits to its front only, with cosine falloff.
    #[must_use]
    pub fn is_flat(self) -> bool {
        !matches!(self, Self::Ball(_))
    }
}

impl Light {
    /// The largest radius of a directional light's [disk](LightShape::Ball).
    pub const MAX_SUN_RADIUS_DEGREES: f32 = 45.0;

    /// Makes a white point-sized light of `intensity` candela or lux, with shadows and without a name or range.
    #[must_use]
    pub fn new(source: LightSource, intensity: f32) -> Self {
        let (color, shape) = (Vec3::ONE, LightShape::POINT);
        Self { name: "".into(), source, color, intensity, range: None, casts_shadow: true, shape }
    }

    /// Unit vectors along the width and the height of a flat light that faces `direction`.
    #[must_use]
    pub fn axes(direction: Vec3) -> [DVec3; 2] {
        let direction = direction.as_dvec3().normalize_or(DVec3::NEG_Y);
        let across = direction.cross(DVec3::Y);
        // Within a thousandth of vertical, rounding would make the axis unstable.
        let across = if across.length_squared() > 1e-6 { across.normalize() } else { DVec3::X };
        let up = across.cross(direction).normalize();
        [across, up]
    }
}
