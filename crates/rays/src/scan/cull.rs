use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec3;

use super::lines::Face;
use crate::patches::{BoxTree, Patches, SixteenBoxes};
use crate::simd::lanes::{LANES, bits_of, load, splat};

/// An integer in the order of floats.
fn ascending(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ if number.is_sign_negative() { u32::MAX } else { 1 << 31 }
}

/// The float that [`ascending`] was given.
pub(super) fn nearest_of(found: u64) -> f32 {
    let bits = (found >> 32) as u32;
    f32::from_bits(bits ^ if bits >> 31 == 0 { u32::MAX } else { 1 << 31 })
}

/// The frustum of a tile's lines, in world units.
pub(super) struct Frustum {
    axes: [usize; 3],
    sign: f32,
    origin: [f32; 3],
    /// Slopes of the low and the high side, for both axes.
    slopes: [[f32; 2]; 2],
    /// Depths of the first line's start and the last line's end.
    ends: [f32; 2],
    largest: f32,
}

impl Frustum {
    /// The frustum around lines on a face, given by their lowest and highest slopes along both axes.
    pub(super) fn new(face: &Face, origin: DVec3, slopes: [[f64; 2]; 2], ends: [f64; 2]) -> Self {
        Self {
            axes: face.axes,
            sign: face.sign as f32,
            origin: origin.as_vec3().to_array(),
            slopes: slopes.map(|side| side.map(|value| value as f32)),
            ends: ends.map(|end| end as f32),
            largest: origin.abs().max_element() as f32,
        }
    }

    /// Lists the patches that may be in the frustum, nearest first, each with a lower bound of its depth.
    #[inline(always)]
    pub(super) fn find_in<S: Simd>(&self, simd: S, boxes: &BoxTree, patches: &Patches, found: &mut Vec<u64>) {
        found.clear();
        if patches.len() > 0 {
            self.descend(simd, boxes, patches, (boxes.top(), 0), found);
        }
        found.sort_unstable();
    }

    fn descend<S: Simd>(
        &self,
        simd: S,
        boxes: &BoxTree,
        patches: &Patches,
        (level, number): (usize, usize),
        found: &mut Vec<u64>,
    ) {
        let (sixteen, count) = boxes.node(patches, level, number);
        let (inside, nearest) = crate::vectorized!(simd => self.test(simd, sixteen));
        for lane in bits_of(inside) {
            if lane >= count {
                break;
            }
            let below = number * LANES + lane;
            if level == 0 {
                found.push(u64::from(ascending(nearest[lane])) << 32 | below as u64);
            } else {
                self.descend(simd, boxes, patches, (level - 1, below), found);
            }
        }
    }

    /// Returns a mask of the boxes, of sixteen, that may meet the frustum, and a lower bound of each one's depth.
    ///
    /// Rounding the origin, differences, slopes, products and sums moves each side by a few ε of the largest number among
    /// them; the bound takes 32. Slopes are at most two.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, boxes: &SixteenBoxes) -> (u16, [f32; LANES]) {
        const ROUNDED: f32 = 32.0 / (1 << 24) as f32;
        let [i, j, k] = self.axes;
        // Written out: closures of `array::map` aren't inlined, and so are compiled without the instruction set.
        let near = load(simd, &boxes.low[k]) - splat(simd, self.origin[k]);
        let far = load(simd, &boxes.high[k]) - splat(simd, self.origin[k]);
        let (near, far) = if self.sign < 0.0 { (-far, -near) } else { (near, far) };
        let mut size = near.abs().max(far.abs()).max(splat(simd, self.largest));
        let mut outside = f32x16::splat(simd, 0.0).simd_gt(f32x16::splat(simd, 0.0));
        for (side, axis) in [(0, i), (1, j)] {
            let origin = splat(simd, self.origin[axis]);
            let (low, high) = (load(simd, &boxes.low[axis]) - origin, load(simd, &boxes.high[axis]) - origin);
            size = size.max(low.abs()).max(high.abs());
            let error = size * ROUNDED;
            let (low_slope, high_slope) = (splat(simd, self.slopes[side][0]), splat(simd, self.slopes[side][1]));
            let least = low - (near * high_slope).max(far * high_slope);
            let most = high - (near * low_slope).min(far * low_slope);
            outside |= least.simd_gt(error) | most.simd_lt(-error);
        }
        let error = size * ROUNDED;
        let (near, far) = (near - error, far + error);
        outside |= near.simd_gt(splat(simd, self.ends[1])) | far.simd_lt(splat(simd, self.ends[0]));
        (!(outside.to_bitmask() as u16), near.into())
    }
}
