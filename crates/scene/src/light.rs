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
}
