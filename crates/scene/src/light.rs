use std::sync::Arc;

use glam::Vec3;
use umbrage_rays::LightSource;

/// A light of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Its name in the file; may be empty.
    pub name: Arc<str>,
    /// Where its light comes from.
    pub source: LightSource,
    /// Linear colour.
    pub color: Vec3,
    /// In candela for point and spot lights, in lux for directional ones.
    pub intensity: f32,
    /// Distance at which the light has faded to nothing, in world units; `None` for never.
    pub range: Option<f32>,
    /// Whether triangles keep its light away from what is behind them.
    pub casts_shadow: bool,
    /// How large it is: the radius of its ball in world units, for a directional light that of its disk in the sky, in
    /// degrees. With 0, all its light comes from one point; otherwise shadows have soft edges, where samples are many.
    pub radius: f32,
}

impl Light {
    /// The largest [radius](Self::radius) of a directional light.
    pub const MAX_SUN_RADIUS_DEGREES: f32 = 45.0;
}
