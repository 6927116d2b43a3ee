use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16, f64x8};
use glam::Vec3;
use rayon::prelude::*;

use super::face::{FACE_LIMIT, Face};
use super::pass::LightPass;
use crate::simd::vectors::{LANES, Vectors, dot, largest, minus, narrow, splat_vector, widen};

const CHUNK_VERTICES: usize = 2048;

/// A vertex of a face is (X, Y, W, outcode). One that the filter can't use has NaN for X, Y and W.
///
/// The outcode has a bit for each side of the face's frustum, grown to [`FACE_LIMIT`], that the vertex is certainly
/// outside of: high X, low X, high Y, low Y, behind the light. A triangle whose vertices share a bit can't be between
/// the light and the face's points.
const UNUSABLE: [f32; 4] = [f32::NAN, f32::NAN, f32::NAN, 0.0];

impl LightPass {
    /// Maps all vertices to the face, each once, and lists one after them that stands for all that don't exist.
    pub(crate) fn project(&mut self, positions: &[Vec3]) {
        let Self { vertices, face, level, .. } = self;
        vertices.resize(positions.len() + 1, UNUSABLE);
        vertices[positions.len()] = UNUSABLE;
        let (face, level) = (&*face, level.0);
        let chunks =
            vertices[..positions.len()].par_chunks_mut(CHUNK_VERTICES).zip(positions.par_chunks(CHUNK_VERTICES));
        chunks.for_each(|(vertices, positions)| {
            dispatch!(level, simd => project(simd, face, positions, vertices));
        });
    }
}

#[inline(always)]
fn project<S: Simd>(simd: S, face: &Face, positions: &[Vec3], vertices: &mut [[f32; 4]]) {
    for (positions, vertices) in positions.chunks(LANES).zip(vertices.chunks_mut(LANES)) {
        let mut axes = [[f32::NAN; LANES]; 3];
        for (lane, position) in positions.iter().enumerate() {
            axes[0][lane] = position.x;
            axes[1][lane] = position.y;
            axes[2][lane] = position.z;
        }
        let [x, y, z] = axes;
        let [low, high] = widen([f32x16::simd_from(simd, x), f32x16::simd_from(simd, y), f32x16::simd_from(simd, z)]);
        let (low, low_codes) = project_eight(simd, face, low);
        let (high, high_codes) = project_eight(simd, face, high);
        let [x, y, nearness] = narrow(low, high);
        let (x, y, nearness) = (x.to_array(), y.to_array(), nearness.to_array());
        let codes = [low_codes, high_codes];
        for (lane, vertex) in vertices.iter_mut().enumerate() {
            let code = codes[lane / 8].map(|outside| (outside >> (lane % 8)) as u32 & 1);
            let code = code.into_iter().enumerate().fold(0, |all, (side, bit)| all | bit << side);
            *vertex = [x[lane], y[lane], nearness[lane], f32::from_bits(code)];
        }
    }
}

/// X, Y and W of eight vertices, NaN where the filter can't use them, and the lanes of each outcode.
///
/// The filter counts on coordinates that f64 got right to ε / 8 of their size or of one, ε = 2⁻²⁴. The homogeneous
/// ones are wrong by 4 u · |x|₁ |v|, so where |v| ≤ 16 p.z, and with |x|₁ below 2²⁰, X is wrong by 2⁻⁵³ · 2⁸ · 2²⁰
/// at most; W in relation to itself by far less. In parallel light X and W are wrong by 4 u |x|₁ |v| ≤ ε / 8 where
/// |v| |x|₁ is at most 2²⁴.
#[inline(always)]
pub(crate) fn project_eight<S: Simd>(simd: S, face: &Face, position: Vectors<S>) -> (Vectors<S>, [u64; 5]) {
    const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
    let constant = |value: f64| f64x8::splat(simd, value);
    let v = minus(position, splat_vector(simd, face.origin));
    let (at, inverse) = face.project(simd, v);
    let reach = largest(v);
    let one = constant(1.0);
    let usable = if face.is_parallel {
        (reach * face.norms().max_element()).simd_le(constant(f64::from(1 << 24)))
    } else {
        (reach * inverse).simd_le(constant(16.0))
            & inverse.simd_gt(constant(0.0))
            & at[2].simd_lt(constant((1_u64 << 40) as f64))
            & at[2].simd_gt(constant(1.0 / (1_u64 << 60) as f64))
    };
    let usable = usable & at[0].abs().max(at[1].abs()).simd_le(constant(4096.0));
    let nan = constant(f64::NAN);

    // p.x > p.z and so on, by more than rounding; written so that NaN is outside of nothing.
    let (x, y) = (dot(v, splat_vector(simd, face.x)), dot(v, splat_vector(simd, face.y)));
    let z = if face.is_parallel { one } else { dot(v, splat_vector(simd, face.z)) };
    let norms = face.norms();
    let error = reach * ((norms.x + norms.y + norms.z) * ROUNDINGS) + z.abs() * 1e-6;
    let limit = z * FACE_LIMIT + error;
    let behind = if face.is_parallel { 0 } else { (z + error).simd_lt(constant(0.0)).to_bitmask() };
    let outside = [
        x.simd_gt(limit).to_bitmask(),
        (-x).simd_gt(limit).to_bitmask(),
        y.simd_gt(limit).to_bitmask(),
        (-y).simd_gt(limit).to_bitmask(),
        behind,
    ];
    ([usable.select(at[0], nan), usable.select(at[1], nan), usable.select(at[2], nan)], outside)
}
