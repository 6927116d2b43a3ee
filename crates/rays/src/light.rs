use std::f32::consts::FRAC_PI_2;

use glam::Vec3;

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
