use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::simd::SimdLevel;
use umbrage_rays::simd::lanes::{load_corner, quads, sixteen_of};
use umbrage_rays::simd::vectors::{LANES, Vectors, dot, largest, minus, narrow, splat, splat_vector, widen};

use super::Frame;
use super::angles::atan2;

const CHUNK_VERTICES: usize = 2048;

/// The entry of a missing vertex.
const UNUSABLE: [f32; 4] = [f32::NAN; 4];

/// An angle is known if its larger component exceeds this, relative to the offset's largest component: then its error is at
/// most [`ANGLE_ERROR`](super::angles::ANGLE_ERROR) of itself, plus 2⁻²³.
///
/// In f64 an offset and its components along the light's axes have an error of 16 roundings of the offset's largest
/// component, which moves an angle by at most twice that, divided by the larger of its two components.
const SMALLEST_PART: f64 = 1.0 / (1 << 24) as f64;

/// All vertices, and one after them that stands for all missing ones. 32 bytes each.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    /// World coordinates.
    positions: Vec<[f32; 4]>,
    /// α and β: NaN for an unknown angle.
    angles: Vec<[f32; 4]>,
}

impl Vertices {
    pub(super) fn bytes(&self) -> usize {
        (self.positions.capacity() + self.angles.capacity()) * size_of::<[f32; 4]>()
    }

    /// Transforms all vertices to the light's frame.
    pub(super) fn project(&mut self, frame: &Frame, positions: &[Vec3], level: SimdLevel) {
        for quads in [&mut self.positions, &mut self.angles] {
            quads.resize(positions.len() + 1, UNUSABLE);
            quads[positions.len()] = UNUSABLE;
        }
        let quads = self.positions.par_chunks_mut(CHUNK_VERTICES).zip(self.angles.par_chunks_mut(CHUNK_VERTICES));
        let chunks = positions.par_chunks(CHUNK_VERTICES).zip(quads);
        chunks.each(|(positions, (copies, angles))| {
            dispatch!(level, simd => project(simd, frame, positions, copies, angles));
        });
    }

    /// One corner of 16 triangles.
    #[inline(always)]
    pub(super) fn corner<S: Simd>(&self, simd: S, triangles: &[[u32; 3]; LANES], corner: usize) -> [f32x16<S>; 3] {
        let [x, y, z, _] = load_corner(simd, &self.positions, triangles, corner);
        [x, y, z]
    }

    /// α and β of the corners of 16 triangles.
    #[inline(always)]
    pub(super) fn angles<S: Simd>(&self, simd: S, triangles: &[[u32; 3]; LANES]) -> [[f32x16<S>; 3]; 2] {
        let [a0, b0, ..] = load_corner(simd, &self.angles, triangles, 0);
        let [a1, b1, ..] = load_corner(simd, &self.angles, triangles, 1);
        let [a2, b2, ..] = load_corner(simd, &self.angles, triangles, 2);
        [[a0, a1, a2], [b0, b1, b2]]
    }
}

#[inline(always)]
fn project<S: Simd>(simd: S, frame: &Frame, positions: &[Vec3], copies: &mut [[f32; 4]], angles: &mut [[f32; 4]]) {
    let nan = splat(simd, f32::NAN);
    for (index, positions) in positions.chunks(LANES).enumerate() {
        let of_world = sixteen_of(simd, positions);
        let [low, high] = widen(of_world);
        let (low, low_angles) = parts(simd, frame, low);
        let (high, high_angles) = parts(simd, frame, high);
        let [x, y, z] = narrow(low, high);
        let is_known = |plane: usize| {
            let bits = low_angles[plane] | high_angles[plane] << 8;
            fearless_simd::mask32x16::from_bitmask(simd, bits)
        };
        let alpha = is_known(0).select(atan2(simd, x, z), nan);
        let beta = is_known(1).select(atan2(simd, y, z), nan);
        let [x, y, z] = of_world;
        let mut both = [[[0.0; 4]; LANES]; 2];
        for (to, from) in both.iter_mut().zip([quads([x, y, z, nan]), quads([alpha, beta, nan, nan])]) {
            for (quad, to) in from.into_iter().zip(to.as_flattened_mut().chunks_exact_mut(LANES)) {
                quad.store_slice(to);
            }
        }
        let first = index * LANES;
        copies[first..first + positions.len()].copy_from_slice(&both[0][..positions.len()]);
        angles[first..first + positions.len()].copy_from_slice(&both[1][..positions.len()]);
    }
}

/// The components of eight positions along the light's axes, scaled, and the masks of known α and β.
#[inline(always)]
fn parts<S: Simd>(simd: S, frame: &Frame, position: Vectors<S>) -> (Vectors<S>, [u64; 2]) {
    let offset = minus(position, splat_vector(simd, frame.light.as_dvec3()));
    let scale = f64x8::splat(simd, frame.scale);
    let parts = along_axes(simd, frame, offset);
    let parts = [parts[0] * scale, parts[1] * scale, parts[2] * scale];
    // Angles are also unknown where f32 would lose bits or overflow.
    let least = (largest(offset) * scale * SMALLEST_PART).max(f64x8::splat(simd, 1e-30));
    let (x, y, z) = (parts[0].abs(), parts[1].abs(), parts[2].abs());
    let is_finite = x.max(y).max(z).simd_lt(f64x8::splat(simd, 1e38));
    let known =
        [(x.max(z).simd_gt(least) & is_finite).to_bitmask(), (y.max(z).simd_gt(least) & is_finite).to_bitmask()];
    (parts, known)
}

/// The components of eight offsets along the light's axes, with an error of at most 8 roundings of the offset's largest
/// component.
#[inline(always)]
pub(super) fn along_axes<S: Simd>(simd: S, frame: &Frame, offset: Vectors<S>) -> Vectors<S> {
    let Frame { right, up, forward, .. } = *frame;
    [
        dot(offset, splat_vector(simd, right)),
        dot(offset, splat_vector(simd, up)),
        dot(offset, splat_vector(simd, forward)),
    ]
}
