use glam::{Vec3, Vec4};

use crate::Settings;

/// What a render gathered for each pixel, in rows from the upper left corner.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean linear radiance (Rec. 709 primaries), and how much of the pixel is covered by the scene.
    pub color: Vec<Vec4>,
    /// Depth along the camera's forward axis at the pixel's first sample, in world units; infinite for a miss.
    pub depth: Vec<f32>,
    /// World-space shading normal at the first sample; zero for a miss.
    pub normal: Vec<Vec3>,
    /// Id of the triangle at the first sample; [`Film::NO_TRIANGLE`] for a miss.
    pub triangle: Vec<u32>,
}

/// A picture for a screen: sRGB-encoded rows of RGB, 16 bits a channel, from the upper left corner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<[u16; 3]>,
}

impl Film {
    /// What [`Film::triangle`] holds where nothing was hit.
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// Tone maps and encodes the film for a screen.
    #[must_use]
    pub fn develop(&self, settings: &Settings) -> Image {
        let _ = settings;
        Image { width: self.width, height: self.height, pixels: vec![[0; 3]; self.color.len()] }
    }
}
