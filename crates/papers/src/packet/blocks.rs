use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::{LANES, MOST_BLOCKS, Planes};

/// Sixteen rays of a packet, as coordinates in its [`Space`](super::Space). Lanes that aren't members are at its middle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct RayBlock {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) members: u16,
}

/// The rays of a packet, sixteen to a block, and the bounds of each block.
#[repr(align(64))]
pub(crate) struct PacketRays {
    blocks: [RayBlock; MOST_BLOCKS],
    count: usize,
    /// The middle of each block's bounds along x and y.
    middle: [[f32; MOST_BLOCKS]; 2],
    /// Half the extent of each block's box, or more.
    half: [[f32; MOST_BLOCKS]; 2],
    /// Blocks with members, a bit for each.
    occupied: u64,
}

impl Default for PacketRays {
    fn default() -> Self {
        Self {
            blocks: [RayBlock::default(); MOST_BLOCKS],
            count: 0,
            middle: [[0.0; MOST_BLOCKS]; 2],
            half: [[0.0; MOST_BLOCKS]; 2],
            occupied: 0,
        }
    }
}

impl PacketRays {
    /// Makes room for this many blocks, each of which must then be [set](Self::set).
    pub(crate) fn start(&mut self, count: usize) {
        self.count = count;
        self.occupied = 0;
    }

    /// Sets the coordinates of a block's rays, and which of them are members.
    #[inline(always)]
    pub(crate) fn set<S: Simd>(&mut self, simd: S, block: usize, coordinates: [f32x16<S>; 2], members: u16) {
        let is_member = mask32x16::from_bitmask(simd, u64::from(members));
        let [zero, one] = [f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0)];
        for (axis, &at) in coordinates.iter().enumerate() {
            let low = is_member.select(at, one).reduce_min();
            let high = is_member.select(at, -one).reduce_max();
            self.middle[axis][block] = 0.5 * (low + high);
            // Coordinates are one at most, and rounded twice.
            self.half[axis][block] = 0.5 * (high - low) + f32::EPSILON;
        }
        let to = &mut self.blocks[block];
        is_member.select(coordinates[0], zero).store_slice(&mut to.x);
        is_member.select(coordinates[1], zero).store_slice(&mut to.y);
        to.members = members;
        self.occupied |= u64::from(members != 0) << block;
    }

    pub(crate) fn blocks(&self) -> &[RayBlock] {
        &self.blocks[..self.count]
    }

    /// The blocks with rays that may hit the triangle in `lane` at a nearness of at least the block's `least`: a bit for
    /// each.
    ///
    /// A ray ruled out here would be ruled out by its own test too, with that test's error bounds: the sums here have four
    /// roundings more than those of a ray, relative to numbers at most twice as large.
    #[inline(always)]
    pub(crate) fn reached<S: Simd>(&self, simd: S, planes: &Planes, lane: usize, least: &[f32; MOST_BLOCKS]) -> u64 {
        if self.count == 1 || planes.oriented >> lane & 1 == 0 {
            return self.occupied;
        }
        let mut reached = 0;
        for first in (0..self.count).step_by(LANES) {
            let middle = [sixteen(simd, &self.middle[0], first), sixteen(simd, &self.middle[1], first)];
            let half = [sixteen(simd, &self.half[0], first), sixteen(simd, &self.half[1], first)];
            let missed = planes.missed_boxes(simd, lane, middle, half, sixteen(simd, least, first));
            reached |= (!missed & 0xffff) << first;
        }
        reached & self.occupied
    }
}

/// Sixteen numbers from index `first`.
#[inline(always)]
fn sixteen<S: Simd>(simd: S, numbers: &[f32; MOST_BLOCKS], first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &numbers[first..first + LANES])
}

/// The least number whose bit is set; infinite if there are none.
#[inline(always)]
pub(super) fn least_of<S: Simd>(simd: S, numbers: f32x16<S>, bits: u16) -> f32 {
    let bits = mask32x16::from_bitmask(simd, u64::from(bits));
    bits.select(numbers, f32x16::splat(simd, f32::INFINITY)).reduce_min()
}

/// The least of the first `count` numbers. The others are infinite.
#[inline(always)]
pub(super) fn least_of_blocks<S: Simd>(simd: S, numbers: &[f32; MOST_BLOCKS], count: usize) -> f32 {
    if count == 1 {
        return numbers[0];
    }
    let mut least = f32x16::splat(simd, f32::INFINITY);
    for first in (0..count).step_by(LANES) {
        least = least.min(sixteen(simd, numbers, first));
    }
    least.reduce_min()
}
