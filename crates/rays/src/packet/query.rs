use fearless_simd::Simd;

use super::{LANES, Planes};

/// Sixteen rays of a packet: where they are in its [`Space`](super::Space). Lanes that aren't members are at its middle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct RayBlock {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) members: u16,
}

/// What is asked of a packet's rays.
pub(crate) trait Query {
    /// The least nearness that still matters to some ray: hits that are certainly farther away change nothing.
    fn least_nearness(&self) -> f32;

    /// Tests the rays against the triangle in `lane`, whose id is `id`.
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32);
}
