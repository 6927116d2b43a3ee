use umbrage_rays::Camera;
use umbrage_scene::Light;

use crate::Background;

/// How a frame is rendered.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Camera rays for each pixel, spread evenly over it.
    pub samples: u32,
    /// The camera; `None` for the scene's own first camera, or else one that sees the whole scene.
    pub camera: Option<Camera>,
    /// The lights; `None` for the scene's own.
    pub lights: Option<Vec<Light>>,
    /// What is behind and around the scene.
    pub background: Background,
    /// Brightness in photographic stops: each step doubles it.
    pub exposure_stops: f32,
    /// From linear radiance to what a screen can show.
    pub tone_map: ToneMap,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 1,
            camera: None,
            lights: None,
            background: Background::Sky,
            exposure_stops: 0.0,
            tone_map: ToneMap::PbrNeutral,
        }
    }
}

/// From linear radiance to what a screen can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral: colours below 0.8 stay as they are, highlights are compressed and desaturated.
    #[default]
    PbrNeutral,
    /// Everything above one is cut off.
    Clip,
}
