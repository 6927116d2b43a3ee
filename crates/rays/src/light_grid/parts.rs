use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::boxes::{FaceBox, SixteenBoxes};
use super::face::Block;
use super::points::{MappedGroup, TILE_BLOCKS, block_of};
use super::set_up::Extent;
use super::worker::make_room;
use crate::simd::lanes::{bits_of, load};
use crate::simd::vectors::{LANES, splat};

/// Points of a tile that are near each other for the light, in sixteen slots: each slot has points of one block.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct TilePart {
    /// Bounds of slots in relation to the tile's origin, grown by the points' error and then rounded to nearest; the
    /// patches' and triangles' bounds are grown for that rounding. The nearness is the farthest point's.
    pub(crate) boxes: SixteenBoxes,
    /// Nearness of the nearest point of each slot.
    nearest: [f32; LANES],
    /// Bounds of all its points.
    pub(crate) whole: FaceBox,
    /// Each slot's block in the tile.
    pub(crate) blocks: [u8; LANES],
    /// A mask of the block's points that are in the slot.
    pub(crate) points: [u16; LANES],
}

/// Some points of a block, where it shows surfaces that are apart for the light.
#[derive(Clone, Copy, Debug)]
struct Fragment {
    /// Its position along a curve through the tile.
    key: u32,
    block: u8,
    points: u16,
    around: Range3,
}

/// Lowest and highest X, Y and W.
#[derive(Clone, Copy, Debug)]
struct Range3 {
    x: [f32; 2],
    y: [f32; 2],
    nearness: [f32; 2],
}

impl Range3 {
    const NOTHING: Self = {
        let nothing = [f32::INFINITY, f32::NEG_INFINITY];
        Self { x: nothing, y: nothing, nearness: nothing }
    };

    fn area(&self) -> f32 {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }

    fn join(&mut self, other: &Self) {
        let join = |a: &mut [f32; 2], b: [f32; 2]| *a = [a[0].min(b[0]), a[1].max(b[1])];
        join(&mut self.x, other.x);
        join(&mut self.y, other.y);
        join(&mut self.nearness, other.nearness);
    }

    fn of_block(group: &MappedGroup, block: usize) -> Self {
        let of = |ranges: &[[f32; LANES]; 2]| [ranges[0][block], ranges[1][block]];
        Self { x: of(&group.x), y: of(&group.y), nearness: of(&group.nearness) }
    }

    /// The range of some points of a block.
    #[inline(always)]
    fn of_points<S: Simd>(simd: S, block: &Block, points: u16) -> Self {
        let points = mask32x16::from_bitmask(simd, points.into());
        let infinity = splat(simd, f32::INFINITY);
        let (x, y, nearness) = (load(simd, &block.x), load(simd, &block.y), load(simd, &block.nearness));
        Self {
            x: [points.select(x, infinity).reduce_min(), points.select(x, -infinity).reduce_max()],
            y: [points.select(y, infinity).reduce_min(), points.select(y, -infinity).reduce_max()],
            nearness: [points.select(nearness, infinity).reduce_min(), points.select(nearness, -infinity).reduce_max()],
        }
    }
}

/// The parts of a tile.
#[derive(Debug, Default)]
pub(crate) struct TileParts {
    pub(crate) parts: Vec<TilePart>,
    fragments: Vec<Fragment>,
    /// The fragment that a block is being divided into.
    rest: Vec<(u16, Range3)>,
}

/// A block that covers more of the face than this many blocks do on average is divided: 20 take 7 % less time than 10 over
/// nine scenes, and 40 are as fast in smooth ones.
const SPRAWLING_BLOCKS: f32 = 20.0;

/// Blocks of a group stay together where their common bounds cover at most this many times the sum of their own.
const LOOSE: f32 = 6.0;

/// A block is cut where its halves together cover less than this share of its area.
const WORTH_CUTTING: f32 = 0.3;

impl TileParts {
    pub(crate) fn clear(&mut self) {
        self.parts.clear();
        self.fragments.clear();
    }

    pub(crate) fn bytes(&self) -> usize {
        self.parts.capacity() * size_of::<TilePart>() + self.fragments.capacity() * size_of::<Fragment>()
    }

    /// The capacities for fragments and for halves of a block.
    pub(crate) fn room(&self) -> [usize; 2] {
        [self.fragments.capacity(), self.rest.capacity()]
    }

    /// Makes room for at least this many.
    pub(crate) fn make_room(&mut self, [fragments, rest]: [usize; 2]) {
        make_room(&mut self.fragments, fragments);
        make_room(&mut self.rest, rest);
    }

    /// Divides a group's points into parts or fragments. `average` is the area of the face over the number of blocks.
    #[inline(always)]
    pub(crate) fn divide<S: Simd>(
        &mut self,
        simd: S,
        number: usize,
        group: &MappedGroup,
        blocks: &[Block; TILE_BLOCKS],
        average: f32,
    ) {
        let sprawling_area = SPRAWLING_BLOCKS * average;
        let (low_x, high_x, low_y, high_y) =
            (load(simd, &group.x[0]), load(simd, &group.x[1]), load(simd, &group.y[0]), load(simd, &group.y[1]));
        let filled = low_x.simd_le(high_x);
        let area = filled.select((high_x - low_x) * (high_y - low_y), splat(simd, 0.0));
        let sprawling = area.simd_gt(splat(simd, sprawling_area)).to_bitmask();
        let mut compact = filled.to_bitmask() & !sprawling;
        for index in bits_of(sprawling) {
            let block = block_of(number, index);
            let start = self.fragments.len();
            let around = Range3::of_block(group, index);
            self.cut(simd, block, &blocks[block], (group.members[index], around), sprawling_area);
            if self.fragments.len() == start + 1 {
                self.fragments.pop();
                compact |= 1 << index;
            }
        }
        if compact == 0 {
            return;
        }
        let mut whole = Range3::NOTHING;
        bits_of(compact).for_each(|index| whole.join(&Range3::of_block(group, index)));
        let areas = area.to_array();
        let sum: f32 = bits_of(compact).map(|index| areas[index]).sum();
        // Blocks that are far from each other are sorted with all others of the tile.
        if whole.area() > sprawling_area * 2.0 && whole.area() > LOOSE * sum {
            for index in bits_of(compact) {
                let around = Range3::of_block(group, index);
                let block = block_of(number, index) as u8;
                self.fragments.push(Fragment { key: 0, block, points: group.members[index], around });
            }
            return;
        }
        let mut part = TilePart::EMPTY;
        for (slot, index) in bits_of(compact).enumerate() {
            part.set(slot, block_of(number, index) as u8, group.members[index], &Range3::of_block(group, index));
        }
        self.parts.push(part);
    }

    /// Cuts a block's points in halves while that makes the area they cover much smaller, or it is large.
    #[inline(always)]
    fn cut<S: Simd>(&mut self, simd: S, block: usize, points: &Block, all: (u16, Range3), sprawling_area: f32) {
        let start = self.fragments.len();
        let (x, y) = (f32x16::simd_from(simd, points.x), f32x16::simd_from(simd, points.y));
        self.rest.clear();
        self.rest.push(all);
        while let Some((members, around)) = self.rest.pop() {
            if members.count_ones() > 1 && self.fragments.len() - start + self.rest.len() < LANES {
                let [width, height] = [around.x, around.y].map(|range| range[1] - range[0]);
                let (along, range) = if width > height { (x, around.x) } else { (y, around.y) };
                let lower = along.simd_lt(splat(simd, 0.5 * (range[0] + range[1])));
                let lower = lower.to_bitmask() as u16 & members;
                let upper = members & !lower;
                if lower != 0 && upper != 0 {
                    let of_lower = Range3::of_points(simd, points, lower);
                    let of_upper = Range3::of_points(simd, points, upper);
                    let area = of_lower.area() + of_upper.area();
                    if area < WORTH_CUTTING * around.area() || around.area() > 2.0 * sprawling_area {
                        self.rest.extend([(lower, of_lower), (upper, of_upper)]);
                        continue;
                    }
                }
            }
            self.fragments.push(Fragment { key: 0, block: block as u8, points: members, around });
        }
    }

    /// Makes parts of the fragments, grows all parts by the errors of `extent`, and sets its reach and depth.
    #[inline(always)]
    pub(crate) fn finish<S: Simd>(&mut self, simd: S, extent: &mut Extent) {
        self.sort_fragments();
        for sixteen in self.fragments.chunks(LANES) {
            let mut part = TilePart::EMPTY;
            for (slot, fragment) in sixteen.iter().enumerate() {
                part.set(slot, fragment.block, fragment.points, &fragment.around);
            }
            self.parts.push(part);
        }
        let mut reach = splat(simd, 0.0);
        let mut depth = splat(simd, 0.0);
        let [position_error, nearness_error] = extent.errors;
        for part in &mut self.parts {
            let TilePart { boxes, .. } = part;
            let filled = load(simd, &boxes.x[0]).simd_le(load(simd, &boxes.x[1]));
            let size = Sizes { simd, filled };
            let farthest =
                size.of(&boxes.x[0]).max(size.of(&boxes.x[1])).max(size.of(&boxes.y[0]).max(size.of(&boxes.y[1])));
            reach = reach.max(farthest);
            depth = depth.max(size.of(&part.nearest)).max(size.of(&boxes.nearness));
            (load(simd, &boxes.x[0]) - position_error).store_slice(&mut boxes.x[0]);
            (load(simd, &boxes.x[1]) + position_error).store_slice(&mut boxes.x[1]);
            (load(simd, &boxes.y[0]) - position_error).store_slice(&mut boxes.y[0]);
            (load(simd, &boxes.y[1]) + position_error).store_slice(&mut boxes.y[1]);
            (load(simd, &boxes.nearness) - nearness_error).store_slice(&mut boxes.nearness);
            part.whole = FaceBox {
                x: [load(simd, &boxes.x[0]).reduce_min(), load(simd, &boxes.x[1]).reduce_max()],
                y: [load(simd, &boxes.y[0]).reduce_min(), load(simd, &boxes.y[1]).reduce_max()],
                nearness: load(simd, &boxes.nearness).reduce_min(),
            };
        }
        extent.reach = reach.reduce_max() + position_error;
        extent.depth = depth.reduce_max() + nearness_error;
    }

    /// Sorts the fragments so that neighbours in the list are near each other.
    fn sort_fragments(&mut self) {
        let mut all = Range3::NOTHING;
        self.fragments.iter().for_each(|fragment| all.join(&fragment.around));
        let scale = 1023.0 / (all.x[1] - all.x[0]).max(all.y[1] - all.y[0]).max(1e-9);
        for Fragment { key, around, .. } in &mut self.fragments {
            let cell = |range: [f32; 2], low: f32| ((0.5 * (range[0] + range[1]) - low) * scale) as u32;
            *key = spread_bits(cell(around.x, all.x[0])) | spread_bits(cell(around.y, all.y[0])) << 1;
        }
        self.fragments.sort_unstable_by_key(|fragment| (fragment.key, fragment.block, fragment.points));
    }
}

/// Magnitudes of values in the filled lanes, zero in the others.
struct Sizes<S: Simd> {
    simd: S,
    filled: mask32x16<S>,
}

impl<S: Simd> Sizes<S> {
    #[inline(always)]
    fn of(&self, values: &[f32; LANES]) -> f32x16<S> {
        self.filled.select(load(self.simd, values).abs(), splat(self.simd, 0.0))
    }
}

/// A number below 1024 with a zero after each bit.
fn spread_bits(number: u32) -> u32 {
    let bits = (number | number << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

impl TilePart {
    pub(super) const EMPTY: Self = Self {
        boxes: SixteenBoxes::NO_POINTS,
        nearest: [f32::NEG_INFINITY; LANES],
        whole: FaceBox::NOTHING,
        blocks: [0; LANES],
        points: [0; LANES],
    };

    fn set(&mut self, slot: usize, block: u8, points: u16, around: &Range3) {
        let &Range3 { x, y, nearness } = around;
        self.boxes.set(slot, FaceBox { x, y, nearness: nearness[0] });
        self.nearest[slot] = nearness[1];
        self.blocks[slot] = block;
        self.points[slot] = points;
    }
}
