use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::light_grid::face::Face;
use umbrage_rays::light_grid::project::project_eight;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::simd::SimdLevel;
use umbrage_rays::simd::vectors::{LANES, narrow, widen};

const CHUNK_VERTICES: usize = 2048;

/// A vertex of a face is (X, Y, W, outcode). If the filter can't use it, X, Y and W are NaN.
///
/// The outcode has a bit for each side of the face's slightly grown frustum that the vertex is certainly outside of: high X,
/// low X, high Y, low Y, behind the light. A triangle whose vertices share a bit can't be between the light and the face's
/// points.
const UNUSABLE: [f32; 4] = [f32::NAN, f32::NAN, f32::NAN, 0.0];

/// Maps all vertices to a face, each once, and appends one that stands for all missing vertices.
pub(super) fn project(face: &Face, positions: &[Vec3], vertices: &mut Vec<[f32; 4]>, level: SimdLevel) {
    vertices.resize(positions.len() + 1, UNUSABLE);
    vertices[positions.len()] = UNUSABLE;
    let chunks = vertices[..positions.len()].par_chunks_mut(CHUNK_VERTICES).zip(positions.par_chunks(CHUNK_VERTICES));
    chunks.each(|(vertices, positions)| {
        dispatch!(level, simd => project_chunk(simd, face, positions, vertices));
    });
}

#[inline(always)]
fn project_chunk<S: Simd>(simd: S, face: &Face, positions: &[Vec3], vertices: &mut [[f32; 4]]) {
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
