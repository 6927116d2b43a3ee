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

/// Points of a block that are near each other on the face: what triangles look for. A block is one cluster, or several
/// where it shows surfaces that are apart. 28 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    /// Lowest and highest X, grown by the points' error.
    pub(crate) x: [f32; 2],
    /// Lowest and highest Y, grown by the points' error.
    pub(crate) y: [f32; 2],
    /// At most the nearness of the farthest point.
    pub(crate) farthest: f32,
    pub(crate) block: u32,
    /// The first and the last column of cells that it is in.
    pub(crate) columns: [u16; 2],
}
