use std::f32::consts::FRAC_PI_2;
use std::fmt;
use std::str::FromStr;

use glam::Vec3;

use crate::choices;

/// A light as a source of shadow rays. Directions are of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// Light in every direction from one point.
    Point {
        /// World position.
        position: Vec3,
    },
    /// Light from one point inside a cone.
    Spot {
        /// World position.
        position: Vec3,
        /// The cone's axis, away from the light.
        direction: Vec3,
        /// Half-angle inside which the light has its full strength.
        inner_radians: f32,
        /// Half-angle outside which there is no light ([`Cone`](crate::Cone)); above `inner_radians`, at most π/2.
        outer_radians: f32,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// The direction in which the light travels.
        direction: Vec3,
    },
}

impl LightSource {
    /// Light from one point into the half-space towards `direction`, which is of unit length.
    #[must_use]
    pub fn to_one_side(position: Vec3, direction: Vec3) -> Self {
        Self::Spot { position, direction, inner_radians: 0.0, outer_radians: FRAC_PI_2 }
    }
}

/// The map from a light's points and triangles to cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightMapping {
    /// One face if the light sees all points within a wide angle, else the sides of a cube, each with its own cells.
    #[default]
    Faces,
    /// One grid of two angles all around the light (§4.1). Suns have no angles, and use a face.
    Spherical,
}

choices! { LightMapping, "light map":
    "faces" => Faces, "a face of tangents, or the sides of a cube";
    "spherical" => Spherical, "the paper's: one grid of two angles around the light";
}

/// A rectangle of angles α and β around a light, in degrees from −180 to 180.
///
/// Both are measured from the light's forward direction: a spot's own, or towards the middle of the camera's points. α is to
/// the right, along the image's rows, and β to the third side. The rectangle's border cells also hold everything outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightClamp {
    /// Lowest and highest α, lowest and highest β.
    degrees: [f32; 4],
}

impl LightClamp {
    /// A rectangle from the lowest and highest α, and the lowest and highest β; `None` for an empty range or angles beyond
    /// ±180.
    #[must_use]
    pub fn new(degrees: [f32; 4]) -> Option<Self> {
        let [left, right, low, high] = degrees;
        let is_range = |low: f32, high: f32| -180.0 <= low && low < high && high <= 180.0;
        (is_range(left, right) && is_range(low, high)).then_some(Self { degrees })
    }

    /// The angles, as for [`new`](Self::new).
    #[must_use]
    pub fn degrees(self) -> [f32; 4] {
        self.degrees
    }

    /// Lowest and highest α, and β, in radians.
    #[must_use]
    pub fn radians(self) -> [[f32; 2]; 2] {
        let [left, right, low, high] = self.degrees.map(f32::to_radians);
        [[left, right], [low, high]]
    }
}

/// As `-30:30:-20:20`.
impl fmt::Display for LightClamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [left, right, low, high] = self.degrees;
        write!(f, "{left}:{right}:{low}:{high}")
    }
}

impl FromStr for LightClamp {
    type Err = NoLightClamp;

    fn from_str(text: &str) -> Result<Self, NoLightClamp> {
        let mut numbers = text.split(':').map(|number| number.parse().ok());
        let degrees = std::array::from_fn(|_| numbers.next().flatten().unwrap_or(f32::NAN));
        Self::new(degrees).filter(|_| numbers.next().is_none()).ok_or(NoLightClamp)
    }
}

/// The error for a text that is no [`LightClamp`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give the lowest and highest α and β in degrees from -180 to 180, as -30:30:-20:20")]
pub struct NoLightClamp;
