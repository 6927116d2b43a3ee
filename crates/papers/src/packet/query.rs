use fearless_simd::Simd;

use super::Planes;

/// A query for the rays of a packet.
pub(crate) trait Query {
    /// The least nearness that matters to any ray: hits that are certainly farther change nothing.
    fn least_nearness(&self) -> f32;

    /// Tests the rays against the triangle in `lane`, whose id is `id`.
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32);
}
