use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};
use glam::DVec3;

use super::block::{Block, BlockErrors};
use super::face::{Face, HALF_ULP, LARGEST_POINT_ERROR, POINT_LIMIT};
use super::map::{Mapper, Slab};
use crate::shot::{CameraRays, EightPoints, SeenImage, SeenPixels};
use crate::simd::vectors::{LANES, Vectors, dot, splat_vector};

impl Mapper<'_> {
    /// Maps the points of a block from the planes of the triangles that they are on, in f64: for blocks whose depths
    /// aren't exact enough for the face. Which points were mapped; others that belong to the face are outliers.
    #[inline(always)]
    pub(crate) fn refine<S: Simd>(
        &self,
        simd: S,
        block: u32,
        points: &mut Block,
        slab: &mut Slab,
    ) -> (u16, BlockErrors) {
        let first = block * LANES as u32;
        let mut mapped = 0_u16;
        let (mut position_error, mut nearness_error) = (0.0_f64, 0.0_f64);
        for half in [0, 8] {
            let indices = std::array::from_fn(|lane| first + half + lane as u32);
            let eight = refine_eight(simd, self.image, &self.survey.rays, self.face, indices);
            for (lane, index) in indices.into_iter().enumerate() {
                if eight.members >> lane & 1 == 0 {
                    continue;
                }
                if eight.exact >> lane & 1 == 0 {
                    slab.outliers.push(index);
                    continue;
                }
                let at = half as usize + lane;
                points.x[at] = eight.at[0][lane] as f32;
                points.y[at] = eight.at[1][lane] as f32;
                points.nearness[at] = eight.at[2][lane] as f32;
                mapped |= 1 << at;
                position_error = position_error.max(eight.errors[0][lane]);
                nearness_error = nearness_error.max(eight.errors[1][lane]);
            }
        }
        slab.refined += mapped.count_ones();
        // Rounded up.
        let error = BlockErrors {
            position: (position_error * 1.001) as f32 + 2.0 * HALF_ULP as f32,
            nearness: (nearness_error * 1.001) as f32,
        };
        (mapped, error)
    }
}

/// Eight pixels' points on a face, from the planes of the triangles that they are on.
#[inline(always)]
pub(crate) fn refine_eight<S: Simd>(
    simd: S,
    image: &SeenImage<'_>,
    rays: &CameraRays,
    face: &Face,
    indices: [u32; 8],
) -> Refined {
    let known = indices.map(|index| {
        let index = index as usize;
        image.seen.triangle[index] != SeenPixels::NONE && !image.seen.inverse_depth[index].is_nan()
    });
    let known = known.into_iter().enumerate().fold(0, |mask, (lane, known)| mask | u64::from(known) << lane);
    let points = EightPoints::find(simd, image, rays, indices, face.origin);
    let v = points.offset;
    let (at, inverse) = face.project(simd, v);
    let one = f64x8::splat(simd, 1.0);
    let error = points.error;
    let (position_error, nearness_error) = if face.is_parallel {
        let norms = face.norms();
        (error * norms.x.max(norms.y), error * norms.z)
    } else {
        // X moves by (x − X z) · dv / p.z, and all roundings of the map are some of f64's.
        let norms = face.norms();
        let relative = error * inverse;
        let reach = at[0].abs().max(at[1].abs());
        ((reach * norms.z + norms.x.max(norms.y)) * relative * 1.1, at[2] * relative * (norms.z * 1.1))
    };
    let rounded = HALF_ULP * 1.01;
    let position_error = position_error + (at[0].abs().max(at[1].abs()) + one) * rounded;
    let nearness_error = nearness_error + at[2].abs() * rounded;
    let limit = f64x8::splat(simd, POINT_LIMIT);
    // How far from the light, over how far the light's face is.
    let depth_is_certain = (error * inverse * face.norms().z).simd_lt(f64x8::splat(simd, 1.0 / 16.0));
    let exact = points.certain
        & depth_is_certain
        & at[0].abs().simd_le(limit)
        & at[1].abs().simd_le(limit)
        & inverse.simd_gt(f64x8::splat(simd, 0.0))
        & at[2].abs().simd_lt(f64x8::splat(simd, 1e15))
        & (points.predicate_error * inverse).simd_le(f64x8::splat(simd, face.point_error))
        & position_error.simd_le(f64x8::splat(simd, LARGEST_POINT_ERROR));
    let members = known & !is_elsewhere(simd, face, v, error, points.certain).to_bitmask();
    let exact = exact.to_bitmask();
    Refined {
        at: [at[0].to_array(), at[1].to_array(), at[2].to_array()],
        errors: [position_error.to_array(), nearness_error.to_array()],
        members,
        exact,
    }
}

/// Which of eight vectors from the light certainly belong to other faces.
#[inline(always)]
fn is_elsewhere<S: Simd>(simd: S, face: &Face, v: Vectors<S>, error: f64x8<S>, certain: mask64x8<S>) -> mask64x8<S> {
    let Some([x, y]) = face.owned else { return mask64x8::splat(simd, false) };
    let norms = face.norms();
    let most = x[0].abs().max(x[1].abs()).max(y[0].abs()).max(y[1].abs());
    let error = error * (2.0 * (norms.x.max(norms.y) + most * norms.z));
    let of = |axis: DVec3| dot(v, splat_vector(simd, axis));
    let (px, py, pz) = (of(face.x), of(face.y), of(face.z));
    let beyond = (px - pz * x[1]).simd_gt(error)
        | (pz * x[0] - px).simd_gt(error)
        | (py - pz * y[1]).simd_gt(error)
        | (pz * y[0] - py).simd_gt(error)
        | (-pz).simd_gt(error);
    certain & beyond
}

/// Eight points on a face.
pub(crate) struct Refined {
    /// X, Y and W.
    pub(crate) at: [[f64; 8]; 3],
    /// Of X and Y, and of W, counting the rounding to f32.
    pub(crate) errors: [[f64; 8]; 2],
    /// Which points belong to the face.
    pub(crate) members: u64,
    /// For which of them the rest holds.
    pub(crate) exact: u64,
}
