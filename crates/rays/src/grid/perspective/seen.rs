/// What each pixel of an image sees, in rows from the upper left.
///
/// 12 bytes a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenPixels {
    /// The triangle that is hit nearest, the one with the lowest id at equal distance; [`SeenPixels::NONE`] for none.
    pub triangle: Vec<u32>,
    /// About 1/t, where t is the depth along [`Camera::forward`](crate::Camera::forward); zero for none.
    pub inverse_depth: Vec<f32>,
    /// How wrong `inverse_depth` may be in relation to the true 1/t; zero for none.
    pub relative_error: Vec<f32>,
}

impl SeenPixels {
    /// Stands for no triangle.
    pub const NONE: u32 = u32::MAX;

    /// Makes room for `pixels` pixels and keeps the memory.
    pub(super) fn resize(&mut self, pixels: usize) {
        self.triangle.resize(pixels, Self::NONE);
        self.inverse_depth.resize(pixels, 0.0);
        self.relative_error.resize(pixels, 0.0);
    }
}
