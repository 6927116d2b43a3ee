use crate::simd::vectors::LANES;

/// The points of 4×4 pixels on a face, in pixel order: the filter tests them at once. 192 bytes.
///
/// Lanes without a point of the face have no meaning.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Block {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    /// Nearness to the light.
    pub(crate) nearness: [f32; LANES],
}

impl Block {
    pub(crate) const EMPTY: Self = Self { x: [0.0; LANES], y: [0.0; LANES], nearness: [0.0; LANES] };
}

/// Error bounds of a block's points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockErrors {
    /// Error of X and Y.
    pub(crate) position: f32,
    /// Error of W.
    pub(crate) nearness: f32,
}
