use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec3;

use super::lines::Face;
use crate::patches::{Patches, SixteenBoxes};
use crate::simd::lanes::{LANES, bits_of, load, splat};

/// A tree of boxes over the patches' boxes, sixteen to a node.
#[derive(Debug, Default)]
pub(super) struct Boxes {
    /// The boxes of each level. A box of the first level is around sixteen patches.
    levels: Vec<Vec<SixteenBoxes>>,
    /// The largest magnitude of a finite coordinate.
    pub(super) reach: f32,
    /// Lowest and highest finite coordinates.
    around: [[f32; 3]; 2],
}

/// The box of patches with NaN coordinates: all of space.
const EVERYWHERE: [[f32; 3]; 2] = [[f32::NEG_INFINITY; 3], [f32::INFINITY; 3]];

impl Boxes {
    pub(super) fn find(&mut self, patches: &Patches) {
        let Self { levels, reach, around } = self;
        let count = patches.bounds.sixteens.len();
        let mut level = 0;
        let mut boxes = count;
        *around = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        while boxes > 1 {
            if levels.len() == level {
                levels.push(Vec::new());
            }
            let (below, above) = levels.split_at_mut(level);
            let below = below.last().unwrap_or(&patches.bounds.sixteens);
            above[0].clear();
            above[0].extend(below.chunks(LANES).map(|sixteens| {
                let mut sixteen = SixteenBoxes::EMPTY;
                for (lane, boxes) in sixteens.iter().enumerate() {
                    sixteen.set(lane, all_of(boxes));
                }
                sixteen
            }));
            boxes = above[0].len();
            level += 1;
        }
        levels.truncate(level);
        for boxes in &patches.bounds.sixteens {
            for lane in 0..LANES {
                let [low, high] = boxes.get(lane);
                for axis in [0, 1, 2] {
                    if low[axis].is_finite() && high[axis].is_finite() {
                        around[0][axis] = around[0][axis].min(low[axis]);
                        around[1][axis] = around[1][axis].max(high[axis]);
                    }
                }
            }
        }
        *reach =
            around.as_flattened().iter().filter(|end| end.is_finite()).fold(0.0, |reach, end| reach.max(end.abs()));
    }

    /// Lists the patches that may be in a frustum, nearest first, each with a lower bound of its depth.
    #[inline(always)]
    pub(super) fn find_in<S: Simd>(&self, simd: S, patches: &Patches, frustum: &Frustum, found: &mut Vec<u64>) {
        found.clear();
        if patches.len() > 0 {
            self.descend(simd, patches, frustum, (self.levels.len(), 0), found);
        }
        found.sort_unstable();
    }

    fn descend<S: Simd>(
        &self,
        simd: S,
        patches: &Patches,
        frustum: &Frustum,
        (level, sixteen): (usize, usize),
        found: &mut Vec<u64>,
    ) {
        let of_level = if level == 0 { &patches.bounds.sixteens } else { &self.levels[level - 1] };
        let count = match level {
            0 => patches.len(),
            1 => patches.bounds.sixteens.len(),
            _ => self.levels[level - 2].len(),
        };
        let (inside, nearest) = crate::vectorized!(simd => frustum.test(simd, &of_level[sixteen]));
        for lane in bits_of(inside) {
            let below = sixteen * LANES + lane;
            if below >= count {
                break;
            }
            if level == 0 {
                found.push(u64::from(ascending(nearest[lane])) << 32 | below as u64);
            } else {
                self.descend(simd, patches, frustum, (level - 1, below), found);
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.capacity() * size_of::<SixteenBoxes>()).sum()
    }
}

/// The box around sixteen boxes.
fn all_of(boxes: &SixteenBoxes) -> [[f32; 3]; 2] {
    let mut all = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for lane in 0..LANES {
        let [low, high] = boxes.get(lane);
        for axis in [0, 1, 2] {
            if low[axis].is_nan() || high[axis].is_nan() {
                return EVERYWHERE;
            }
            all[0][axis] = all[0][axis].min(low[axis]);
            all[1][axis] = all[1][axis].max(high[axis]);
        }
    }
    all
}

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
