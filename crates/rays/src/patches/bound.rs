use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};
use glam::Vec3;
use rayon::prelude::*;

use super::Patches;
use crate::simd::SimdLevel;
use crate::simd::vectors::{LANES, splat};

/// Where patches are: boxes, sixteen together. 24 bytes a patch.
#[derive(Debug, Default)]
pub(crate) struct WorldBounds {
    pub(crate) sixteens: Vec<SixteenBoxes>,
}

/// Lowest and highest coordinates of sixteen patches. A patch with a vertex that isn't finite has NaN; where there is no
/// patch, low is above high.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct SixteenBoxes {
    pub(crate) low: [[f32; LANES]; 3],
    pub(crate) high: [[f32; LANES]; 3],
}

impl SixteenBoxes {
    const EMPTY: Self = Self { low: [[f32::INFINITY; LANES]; 3], high: [[f32::NEG_INFINITY; LANES]; 3] };
}

impl WorldBounds {
    pub(crate) fn bytes(&self) -> usize {
        self.sixteens.capacity() * size_of::<SixteenBoxes>()
    }

    /// Half of the surface of all boxes, in squares of so many units. Those that are larger count as cubes of that size,
    /// so that one that is far too large doesn't hide what the others do.
    pub(super) fn spread(&self, unit: f32) -> f32 {
        let of_sixteen = |boxes: &SixteenBoxes| -> f32 {
            let half_surface = |lane: usize| {
                // Nothing where there is no box, or one that isn't finite: the greater of NaN and zero is zero.
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
    /// Finds where patches are.
    pub(super) fn bound(&mut self, positions: &[Vec3], level: SimdLevel) {
        let mut sixteens = std::mem::take(&mut self.bounds.sixteens);
        sixteens.resize(self.len().div_ceil(LANES), SixteenBoxes::EMPTY);
        let patches = &*self;
        sixteens.par_iter_mut().enumerate().with_min_len(8).for_each(|(sixteen, boxes)| {
            dispatch!(level.0, simd => patches.bound_sixteen(simd, positions, sixteen * LANES, boxes));
        });
        self.bounds.sixteens = sixteens;
    }

    /// Finds where the sixteen patches from `first` on are.
    #[inline(always)]
    fn bound_sixteen<S: Simd>(&self, simd: S, positions: &[Vec3], first: usize, boxes: &mut SixteenBoxes) {
        *boxes = SixteenBoxes::EMPTY;
        for number in first..self.len().min(first + LANES) {
            let (low, high) = bounds(simd, positions, self.get(number).vertices);
            for axis in 0..3 {
                boxes.low[axis][number - first] = low[axis];
                boxes.high[axis][number - first] = high[axis];
            }
        }
    }
}

/// The coordinates of up to 16 vertices; those that are beyond the list's end are NaN.
#[inline(always)]
pub(crate) fn gather<S: Simd>(simd: S, positions: &[Vec3], vertices: &[u32]) -> [f32x16<S>; 3] {
    let mut axes = [[f32::NAN; LANES]; 3];
    for (lane, &vertex) in vertices.iter().enumerate().take(LANES) {
        let position = positions.get(vertex as usize).copied().unwrap_or(Vec3::NAN);
        axes[0][lane] = position.x;
        axes[1][lane] = position.y;
        axes[2][lane] = position.z;
    }
    let [x, y, z] = axes;
    [f32x16::simd_from(simd, x), f32x16::simd_from(simd, y), f32x16::simd_from(simd, z)]
}

/// The lowest and highest coordinates of a patch's vertices, a multiple of 16; NaN if one isn't finite.
#[inline(always)]
fn bounds<S: Simd>(simd: S, positions: &[Vec3], vertices: &[u32]) -> ([f32; 3], [f32; 3]) {
    let (infinity, zero) = (splat(simd, f32::INFINITY), splat(simd, 0.0));
    let (mut low, mut high) = ([infinity; 3], [-infinity; 3]);
    // Zero times what isn't finite is NaN, and stays so in sums.
    let mut spoilt = zero;
    for sixteen in vertices.chunks_exact(LANES) {
        let [x, y, z] = gather(simd, positions, sixteen);
        low = [low[0].min(x), low[1].min(y), low[2].min(z)];
        high = [high[0].max(x), high[1].max(y), high[2].max(z)];
        spoilt += (x * zero + y * zero) + z * zero;
    }
    let is_finite = spoilt.simd_eq(spoilt).all_true();
    if !is_finite {
        return ([f32::NAN; 3], [f32::NAN; 3]);
    }
    let lowest = [low[0].reduce_min(), low[1].reduce_min(), low[2].reduce_min()];
    (lowest, [high[0].reduce_max(), high[1].reduce_max(), high[2].reduce_max()])
}
