use crate::parallel::both;
use fearless_simd::prelude::*;
use std::sync::PoisonError;

use crate::dispatch;
use fearless_simd::{Simd, f32x4, f32x16, u8x64, u32x16};
use glam::Vec3;

use super::{MOST_TRIANGLES, MOST_VERTICES, Patches};
use crate::Triangles;
use crate::simd::lanes::{bits_of, transposed};
use crate::simd::vectors::{LANES, splat};
use crate::simd::{SimdLevel, each};

/// The bounds of patches, sixteen together. 24 bytes a patch.
#[derive(Debug, Default)]
pub(crate) struct WorldBounds {
    pub(crate) sixteens: Vec<SixteenBoxes>,
}

/// The coordinates of sixteen vertices of a patch, axis by axis.
pub(crate) type SixteenPositions = [[f32; LANES]; 3];

/// Lowest and highest coordinates of sixteen patches. A patch with a vertex that isn't finite has NaN. In lanes without a
/// patch, low is above high.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct SixteenBoxes {
    pub(crate) low: [[f32; LANES]; 3],
    pub(crate) high: [[f32; LANES]; 3],
}

impl SixteenBoxes {
    pub(crate) const EMPTY: Self = Self { low: [[f32::INFINITY; LANES]; 3], high: [[f32::NEG_INFINITY; LANES]; 3] };

    /// Lowest and highest coordinates of one patch.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> [[f32; 3]; 2] {
        let lane = lane % LANES;
        [&self.low, &self.high].map(|[x, y, z]| [x[lane], y[lane], z[lane]])
    }

    /// Replaces the coordinates of one patch.
    pub(crate) fn set(&mut self, lane: usize, [low, high]: [[f32; 3]; 2]) {
        for axis in 0..3 {
            self.low[axis][lane] = low[axis];
            self.high[axis][lane] = high[axis];
        }
    }
}

impl WorldBounds {
    pub(crate) fn bytes(&self) -> usize {
        self.sixteens.capacity() * size_of::<SixteenBoxes>()
    }

    /// Half of the surface of all boxes, in squares of side `unit`. Larger boxes count as cubes of that size, so that one
    /// far too large box doesn't hide a change of the others.
    pub(super) fn spread(&self, unit: f32) -> f32 {
        let of_sixteen = |boxes: &SixteenBoxes| -> f32 {
            let half_surface = |lane: usize| {
                // Zero for lanes without a box or with one that isn't finite: the maximum of NaN and zero is zero.
                let [x, y, z] =
                    [0, 1, 2].map(|axis| (boxes.high[axis][lane] - boxes.low[axis][lane]).max(0.0).min(unit));
                x * y + y * z + z * x
            };
            (0..LANES).map(half_surface).sum()
        };
        self.sixteens.iter().map(of_sixteen).sum::<f32>() / (unit * unit)
    }
}

impl Patches {
    /// Finds the bounds of patches, the positions of their vertices, and the triangles that no ray can hit.
    pub(super) fn bound(&mut self, triangles: Triangles<'_>, level: SimdLevel) {
        let mut sixteens = std::mem::take(&mut self.bounds.sixteens);
        let mut positions = std::mem::take(&mut self.positions);
        sixteens.resize(self.len().div_ceil(LANES), SixteenBoxes::EMPTY);
        positions.resize(self.vertex_count() / LANES, SixteenPositions::default());
        let bounding = Bounding { patches: self, positions: triangles.positions, level };
        bounding.bound(0, &mut sixteens, &mut positions);
        self.bounds.sixteens = sixteens;
        self.positions = positions;
        self.omit(triangles);
    }

    /// Notes the triangles that no ray can hit, among the suspects and those in no patch.
    fn omit(&mut self, triangles: Triangles<'_>) {
        let Self { suspects, omitted, in_none, .. } = self;
        let suspects = suspects.get_mut().unwrap_or_else(PoisonError::into_inner);
        suspects.extend_from_slice(in_none);
        suspects.sort_unstable();
        omitted.clear();
        for id in suspects.drain(..) {
            if let Err(why) = triangles.usable_corners(id) {
                omitted.note(id, why);
            }
        }
    }

    fn suspect(&self, ids: impl Iterator<Item = u32>) {
        self.suspects.lock().unwrap_or_else(PoisonError::into_inner).extend(ids);
    }
}

struct Bounding<'a> {
    patches: &'a Patches,
    positions: &'a [Vec3],
    level: SimdLevel,
}

impl Bounding<'_> {
    /// Bounds the sixteens from `first` on, in halves for other threads to share.
    fn bound(&self, first: usize, sixteens: &mut [SixteenBoxes], positions: &mut [SixteenPositions]) {
        const CHUNK: usize = 8;
        let start = |sixteen: usize| self.patches.first_vertex((sixteen * LANES).min(self.patches.len())) / LANES;
        if sixteens.len() > CHUNK {
            let middle = sixteens.len() / 2;
            let (low, high) = sixteens.split_at_mut(middle);
            let (low_positions, high_positions) = positions.split_at_mut(start(first + middle) - start(first));
            both(|| self.bound(first, low, low_positions), || self.bound(first + middle, high, high_positions));
            return;
        }
        let mut rest = positions;
        for (sixteen, boxes) in sixteens.iter_mut().enumerate() {
            let sixteen = first + sixteen;
            let (positions, after) = rest.split_at_mut(start(sixteen + 1) - start(sixteen));
            rest = after;
            dispatch!(self.level, simd => self.bound_sixteen(simd, sixteen * LANES, boxes, positions));
        }
    }

    /// Finds the bounds of sixteen patches from `first` on.
    #[inline(always)]
    fn bound_sixteen<S: Simd>(
        &self,
        simd: S,
        first: usize,
        boxes: &mut SixteenBoxes,
        mut positions: &mut [SixteenPositions],
    ) {
        *boxes = SixteenBoxes::EMPTY;
        for number in first..self.patches.len().min(first + LANES) {
            let patch = self.patches.get(number);
            let (of_patch, rest) = positions.split_at_mut(patch.vertices.len() / LANES);
            positions = rest;
            let (low, high, hashes) = bounds(simd, self.positions, patch.vertices, of_patch);
            for axis in 0..3 {
                boxes.low[axis][number - first] = low[axis];
                boxes.high[axis][number - first] = high[axis];
            }
            // Padding triangles have one vertex three times, and no id.
            let all = low[0].is_nan();
            let mut suspected = 0;
            for (sixteen, corners) in patch.corners.as_chunks().0.iter().enumerate() {
                let suspects = if all { 0xffff } else { suspects(simd, hashes, corners) };
                suspected |= suspects << (sixteen * LANES);
            }
            suspected &= u64::MAX >> (MOST_TRIANGLES - patch.count);
            if suspected != 0 {
                self.patches.suspect(bits_of(suspected).map(|triangle| patch.ids[triangle]));
            }
        }
    }
}

/// Returns a mask of the triangles, of 16, that may have two corners at the same position, given two bytes of a hash of each
/// vertex's position.
#[inline(always)]
fn suspects<S: Simd>(simd: S, hashes: [u8x64<S>; 2], corners: &[[u8; 4]; LANES]) -> u64 {
    let corners = u8x64::from_slice(simd, corners.as_flattened());
    let hashes = [hashes[0].swizzle_dyn(corners), hashes[1].swizzle_dyn(corners)];
    let (low, high) = (hashes[0].bitcast::<u32x16<S>>(), hashes[1].bitcast::<u32x16<S>>());
    let first = u32x16::splat(simd, 0xff);
    let differ = |shift: u32| (low ^ (low >> shift)) | (high ^ (high >> shift));
    let zero = u32x16::splat(simd, 0);
    // Corners 0 and 1, 1 and 2, 0 and 2.
    let same = (differ(8) & first).simd_eq(zero)
        | (differ(8) & (first << 8)).simd_eq(zero)
        | (differ(16) & first).simd_eq(zero);
    same.to_bitmask()
}

/// The coordinates of 16 vertices; NaN for vertices beyond the list's end.
#[inline(always)]
fn gather<S: Simd>(simd: S, positions: &[Vec3], vertices: &[u32; LANES]) -> [f32x16<S>; 3] {
    transposed(
        #[inline(always)]
        |lane| {
            let position = positions.get(vertices[lane] as usize).copied().unwrap_or(Vec3::NAN);
            f32x4::simd_from(simd, [position.x, position.y, position.z, 0.0])
        },
    )
}

/// Copies a patch's vertices, a multiple of 16, `into` its own order. Returns their lowest and highest coordinates, NaN if
/// one isn't finite, and two bytes of a hash of each position.
#[inline(always)]
fn bounds<S: Simd>(
    simd: S,
    positions: &[Vec3],
    vertices: &[u32],
    into: &mut [SixteenPositions],
) -> ([f32; 3], [f32; 3], [u8x64<S>; 2]) {
    let (infinity, zero) = (splat(simd, f32::INFINITY), splat(simd, 0.0));
    let (mut low, mut high) = ([infinity; 3], [-infinity; 3]);
    // Zero times NaN or infinity is NaN, and NaN stays in sums.
    let mut spoilt = zero;
    let mut hashes = [[0; MOST_VERTICES]; 2];
    for (sixteen, (indices, to)) in vertices.as_chunks().0.iter().zip(into).enumerate() {
        let [x, y, z] = gather(simd, positions, indices);
        *to = [x.into(), y.into(), z.into()];
        low = [low[0].min(x), low[1].min(y), low[2].min(z)];
        high = [high[0].max(x), high[1].max(y), high[2].max(z)];
        spoilt += (x * zero + y * zero) + z * zero;
        // Minus zero plus zero is zero.
        let bits = each!(axis in [x, y, z] => (axis + zero).bitcast::<u32x16<S>>());
        let hash = bits[0] * 0x9E37_79B1 + bits[1] * 0x85EB_CA77 + bits[2] * 0xC2B2_AE3D;
        let hash: [u32; LANES] = hash.into();
        for (lane, hash) in hash.into_iter().enumerate() {
            hashes[0][sixteen * LANES % MOST_VERTICES + lane] = (hash >> 24) as u8;
            hashes[1][sixteen * LANES % MOST_VERTICES + lane] = (hash >> 16) as u8;
        }
    }
    let hashes = [u8x64::simd_from(simd, hashes[0]), u8x64::simd_from(simd, hashes[1])];
    let is_finite = spoilt.simd_eq(spoilt).all_true();
    if !is_finite {
        return ([f32::NAN; 3], [f32::NAN; 3], hashes);
    }
    let lowest = [low[0].reduce_min(), low[1].reduce_min(), low[2].reduce_min()];
    (lowest, [high[0].reduce_max(), high[1].reduce_max(), high[2].reduce_max()], hashes)
}
