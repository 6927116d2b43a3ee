use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::boxes::{SixteenBoxes, SplatBox};
use super::face::Block;
use super::parts::TilePart;
use super::points::TILE_BLOCKS;
use super::set_up::SetUp;
use super::trace::QUEUE;
use crate::simd::lanes::{bits_of, load, min3};
use crate::simd::vectors::{LANES, splat};

/// Where a triangle's bounds overlap more slots of a part than this, its edges are tested against the slots' boxes before it
/// is tested against their points.
const MOST_UNTESTED: u32 = 6;

/// The points of a tile.
pub(crate) struct TilePoints<'a> {
    /// The index of the tile's first pixel.
    first: usize,
    blocks: &'a [Block; TILE_BLOCKS],
    /// The triangle that each point is on.
    own: &'a [[u32; LANES]],
}

/// The filter's result for a triangle and the points of a slot.
pub(crate) struct FilterResult<S: Simd> {
    /// The edge functions, grown by their error.
    pub(crate) edges: [f32x16<S>; 3],
    /// The least of them.
    pub(crate) least: f32x16<S>,
    /// The difference in nearness by which the triangle is nearer to the light, grown by its error.
    pub(crate) nearer: f32x16<S>,
    /// The points still to be tested that it may shadow.
    pub(crate) possible: u16,
}

impl<S: Simd> FilterResult<S> {
    /// The points that the triangle certainly shadows; `errors` are twice those of the edge functions and of the nearness.
    #[inline(always)]
    pub(crate) fn certain(&self, simd: S, errors: [f32; 2]) -> u16 {
        let certain = self.least.simd_gt(splat(simd, errors[0])) & self.nearer.simd_gt(splat(simd, errors[1]));
        certain.to_bitmask() as u16 & self.possible
    }
}

impl<'a> TilePoints<'a> {
    /// The points of the tile whose first pixel has the index `first`; `own` has all of the image's triangles.
    pub(crate) fn new(first: usize, blocks: &'a [Block; TILE_BLOCKS], own: &'a [u32]) -> Self {
        Self { first, blocks, own: own[first..first + TILE_BLOCKS * LANES].as_chunks().0 }
    }

    /// Tests a triangle against the points of a block that aren't `done`.
    ///
    /// Points on the triangle itself are left out at once: most tests of lit surfaces find nothing but these, and a branch
    /// on that can't be predicted.
    #[inline(always)]
    pub(crate) fn test<S: Simd>(
        &self,
        simd: S,
        [first, second, third]: &[[f32; 4]; 3],
        id: u32,
        (block, done): (u8, u16),
    ) -> FilterResult<S> {
        let own = u32x16::simd_from(simd, self.own[usize::from(block)]);
        let block = &self.blocks[usize::from(block)];
        let (x, y) = (f32x16::simd_from(simd, block.x), f32x16::simd_from(simd, block.y));
        let nearness = f32x16::simd_from(simd, block.nearness);
        let e0 = line(simd, [first[0], first[1], first[2]], x, y);
        let e1 = line(simd, [second[0], second[1], second[2]], x, y);
        let e2 = line(simd, [third[0], third[1], third[2]], x, y);
        let nearer = line(simd, [first[3], second[3], third[3]], x, y) - nearness;
        let least = min3([e0, e1, e2]);
        let zero = splat(simd, 0.0);
        // Written so that NaN is possible.
        let missed = least.simd_lt(zero) | nearer.simd_lt(zero) | own.simd_eq(u32x16::splat(simd, id));
        let possible = !(missed.to_bitmask() as u16 | done);
        FilterResult { edges: [e0, e1, e2], least, nearer, possible }
    }

    /// X, Y and nearness of a point, and the triangle that it is on.
    #[inline(always)]
    pub(crate) fn point(&self, block: u8, lane: usize) -> ([f32; 3], u32) {
        let Block { x, y, nearness } = &self.blocks[usize::from(block)];
        let lane = lane % LANES;
        ([x[lane], y[lane], nearness[lane]], self.own[usize::from(block)][lane])
    }

    /// The points of a block that are found in a box and not nearer than that.
    #[inline(always)]
    pub(crate) fn inside<S: Simd>(&self, simd: S, block: u8, around: &SplatBox<S>) -> u16 {
        let block = &self.blocks[usize::from(block)];
        let (x, y) = (f32x16::simd_from(simd, block.x), f32x16::simd_from(simd, block.y));
        let inside = x.simd_ge(around.x[0])
            & x.simd_le(around.x[1])
            & y.simd_ge(around.y[0])
            & y.simd_le(around.y[1])
            & f32x16::simd_from(simd, block.nearness).simd_le(around.nearness);
        inside.to_bitmask() as u16
    }

    /// Lists the pairs of a triangle and the points of a block that are pending.
    #[cold]
    #[inline(never)]
    pub(crate) fn list_pending(&self, block: u8, id: u32, pending: u16, undecided: &mut Vec<[u32; 2]>) {
        let first = (self.first + usize::from(block) * LANES) as u32;
        undecided.extend(bits_of(pending).map(|lane| [first + lane as u32, id]));
    }
}

/// A mask of a part's slots with points that a triangle may shadow: those where none of its functions is below zero
/// everywhere.
#[inline(always)]
pub(crate) fn may_touch<S: Simd>(simd: S, [first, second, third]: &[[f32; 4]; 3], points: &SixteenBoxes) -> u16 {
    let (x, y) =
        ([load(simd, &points.x[0]), load(simd, &points.x[1])], [load(simd, &points.y[0]), load(simd, &points.y[1])]);
    let e0 = most(simd, [first[0], first[1], first[2]], x, y);
    let e1 = most(simd, [second[0], second[1], second[2]], x, y);
    let e2 = most(simd, [third[0], third[1], third[2]], x, y);
    let nearer = most(simd, [first[3], second[3], third[3]], x, y) - load(simd, &points.nearness);
    let missed = min3([e0, e1, e2]).min(nearer).simd_lt(splat(simd, 0.0)) | x[0].simd_gt(x[1]);
    !(missed.to_bitmask() as u16)
}

/// The maximum of a linear function in boxes.
///
/// Rounding is monotone, so the larger of the values at both ends is the value at the end that the factor's sign names: no
/// branch on signs, which can't be predicted, is needed.
#[inline(always)]
fn most<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: [f32x16<S>; 2], y: [f32x16<S>; 2]) -> f32x16<S> {
    let (a, b, c) = (splat(simd, a), splat(simd, b), splat(simd, c));
    let along_y = b.mul_add(y[0], c).max(b.mul_add(y[1], c));
    a.mul_add(x[0], along_y).max(a.mul_add(x[1], along_y))
}

#[inline(always)]
fn line<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    splat(simd, a).mul_add(x, splat(simd, b).mul_add(y, splat(simd, c)))
}

/// Queues the pairs of a triangle and one of `slots` of a part with points that it may shadow; returns how many there are. A
/// pair has the triangle in its upper bits, and the slot in the lowest four.
#[inline(always)]
pub(crate) fn enqueue<S: Simd>(
    simd: S,
    set_up: &SetUp,
    part: &TilePart,
    slots: u16,
    queue: &mut [u32; QUEUE],
) -> usize {
    let lanes = u32x16::simd_from(simd, std::array::from_fn::<u32, LANES, _>(|lane| lane as u32));
    let overlap = set_up.bounds.may_shadow(simd, &SplatBox::new(simd, &part.whole));
    let mut end = 0;
    for triangle in bits_of(overlap) {
        let bounds = SplatBox::new(simd, &set_up.bounds.get(triangle));
        let mut slots = part.boxes.reached(simd, &bounds).to_bitmask() as u16 & slots;
        if slots.count_ones() > MOST_UNTESTED {
            slots &= may_touch(simd, &set_up.quads(triangle), &part.boxes);
        }
        let pairs = lanes | u32x16::splat(simd, (triangle * LANES) as u32);
        let pairs = pairs.compress(mask32x16::from_bitmask(simd, slots.into()));
        pairs.store_slice(&mut queue[end..end + LANES]);
        end += slots.count_ones() as usize;
    }
    end
}

#[cfg(test)]
mod tests;
