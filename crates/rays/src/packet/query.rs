use fearless_simd::Simd;

use super::Planes;

/// What is asked of a packet's rays.
pub(crate) trait Query {
    /// The least nearness that still matters to some ray: hits that are certainly farther away change nothing.
    fn least_nearness(&self) -> f32;

    /// Tests the rays against the triangle in `lane`, whose id is `id`.
    fn test<S: Simd>(&mut self, simd: S, planes: &Planes, lane: usize, id: u32);
}
