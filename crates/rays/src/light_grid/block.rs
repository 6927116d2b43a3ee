use crate::simd::vectors::LANES;

/// The points of 4×4 pixels on a face, in pixel order: what the filter tests at once. 192 bytes.
///
/// Lanes without a point of the face hold anything.
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

/// How wrong the points of a block may be.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockErrors {
    /// Of X and Y.
    pub(crate) position: f32,
    /// Of W.
    pub(crate) nearness: f32,
}
