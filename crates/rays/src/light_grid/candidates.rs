use std::ops::Range;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::boxes::{FaceBox, SixteenBoxes, SplatBox};
use super::face::HALF_ULP;
use super::filter::may_touch;
use super::parts::TilePart;
use super::set_up::{Extent, Record};
use super::trace::Tracer;
use super::worker::{ShadowWorker, make_room};
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;
use crate::vectorized;

/// Parts whose candidates are found together.
pub(crate) const BATCH_PARTS: usize = 128;

/// A bit for each part of a batch.
pub(crate) type PartBits = [u64; BATCH_PARTS / 64];

/// The patches and large triangles that may shadow points of some parts.
#[derive(Debug, Default)]
pub(crate) struct CandidateBatch {
    /// The boxes of parts, sixteen together.
    pub(crate) boxes: Vec<SixteenBoxes>,
    pub(crate) candidates: Vec<CandidatePatch>,
    /// The candidates' indices, in the lower half of each number, the nearest to the light first.
    pub(crate) order: Vec<u64>,
    pub(crate) large: Vec<(Record, PartBits)>,
}

/// A patch that may shadow points of a batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CandidatePatch {
    pub(crate) number: u32,
    /// Bounds in relation to the tile's origin of the points that it may shadow, as these are found.
    pub(crate) around: FaceBox,
    /// The parts that have points it may shadow.
    pub(crate) parts: PartBits,
}

impl CandidateBatch {
    pub(crate) fn bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<SixteenBoxes>()
            + self.candidates.capacity() * (size_of::<CandidatePatch>() + size_of::<u64>())
            + self.large.capacity() * size_of::<(Record, PartBits)>()
    }

    /// The capacity of each list.
    pub(crate) fn room(&self) -> [usize; 3] {
        [self.boxes.capacity(), self.candidates.capacity(), self.large.capacity()]
    }

    /// Makes room for at least this number of elements in each list.
    pub(crate) fn make_room(&mut self, [boxes, candidates, large]: [usize; 3]) {
        make_room(&mut self.boxes, boxes);
        make_room(&mut self.candidates, candidates);
        make_room(&mut self.order, candidates);
        make_room(&mut self.large, large);
    }
}

/// The parts' indices in their batch.
#[inline(always)]
pub(crate) fn bits_of_parts(&[low, high]: &PartBits) -> impl Iterator<Item = usize> {
    bits_of(low).chain(bits_of(high).map(|bit| 64 + bit))
}

impl Tracer<'_> {
    /// Finds the patches and large triangles that may shadow points of some parts.
    #[inline(never)]
    pub(crate) fn find_candidates<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, parts: Range<usize>) {
        vectorized!(simd => self.find_candidates_with(simd, worker, parts));
    }

    #[inline(always)]
    fn find_candidates_with<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, parts: Range<usize>) {
        let ShadowWorker { tile, parts: all, batch, counts, .. } = worker;
        let parts = &all.parts[parts];
        let CandidateBatch { boxes, candidates, order, large, .. } = batch;
        let around = boxes_on_face(&tile.extent, parts, boxes);
        let splat_around = SplatBox::new(simd, &around);
        candidates.clear();
        for (number, upper) in self.on_face.upper.iter().enumerate() {
            for lane in bits_of(upper.may_shadow(simd, &splat_around)) {
                let number = number * LANES + lane;
                let sixteen = &self.on_face.sixteens[number];
                for lane in bits_of(sixteen.may_shadow(simd, &splat_around)) {
                    let one = sixteen.get(lane);
                    let splat_one = SplatBox::new(simd, &one);
                    let mut reached = PartBits::default();
                    for (number, boxes) in boxes.iter().enumerate() {
                        reached[number / 4] |= boxes.reached(simd, &splat_one).to_bitmask() << (number % 4 * LANES);
                    }
                    if reached == PartBits::default() {
                        continue;
                    }
                    let around = in_tile(&tile.extent, &one);
                    let number = (number * LANES + lane) as u32;
                    candidates.push(CandidatePatch { number, around, parts: reached });
                }
            }
        }
        // The nearest to the light first, since shadowed points needn't be tested again.
        order.clear();
        order.extend(
            candidates
                .iter()
                .enumerate()
                .map(|(index, candidate)| u64::from(!ascending(candidate.around.nearness)) << 32 | index as u64),
        );
        order.sort_unstable();
        large.clear();
        // A large triangle reaches a tile's bounds more often than it reaches its parts.
        let mut wholes = [SixteenBoxes::NO_POINTS; BATCH_PARTS / LANES];
        for (index, part) in parts.iter().enumerate() {
            wholes[index / LANES].set(index % LANES, part.whole);
        }
        self.on_face.large.reaching(
            simd,
            &around,
            #[inline(always)]
            |number| {
                let Extent { origin, reach, depth, errors } = tile.extent;
                let record = self.on_face.large.record(number, origin, [reach, depth], errors);
                let mut reached = PartBits::default();
                for (number, wholes) in wholes[..parts.len().div_ceil(LANES)].iter().enumerate() {
                    for lane in bits_of(may_touch(simd, &record.quads, wholes)) {
                        let index = number * LANES + lane;
                        let touched = may_touch(simd, &record.quads, &parts[index].boxes);
                        reached[index / 64] |= u64::from(touched != 0) << (index % 64);
                    }
                }
                if reached != PartBits::default() {
                    large.push((record, reached));
                }
            },
        );
        counts.large_triangles += large.len() as u64;
    }
}

/// The margin of boxes, in relation to the summands' magnitudes: for the roundings of a sum of at most about four, and for
/// the rounding of a part's own bounds.
const ROUNDED: f32 = 4.0 * HALF_ULP as f32;

/// The box of a patch in relation to a tile's origin, grown by the points' errors: up to rounding no further one than that of
/// the margin is left in comparing found points with it.
#[inline(always)]
fn in_tile(extent: &Extent, &FaceBox { x, y, nearness }: &FaceBox) -> FaceBox {
    let [origin_x, origin_y, origin_w] = extent.origin;
    let [position_error, nearness_error] = extent.errors;
    let margin = position_error * 1.001 + ROUNDED;
    let depth_margin = nearness_error * 1.001 + (nearness.abs() + origin_w.abs()) * ROUNDED;
    FaceBox {
        x: [x[0] - origin_x - margin, x[1] - origin_x + margin],
        y: [y[0] - origin_y - margin, y[1] - origin_y + margin],
        nearness: nearness - origin_w + depth_margin,
    }
}

/// The boxes of parts on the face, sixteen together, and the box around them all.
fn boxes_on_face(extent: &Extent, parts: &[TilePart], boxes: &mut Vec<SixteenBoxes>) -> FaceBox {
    let [origin_x, origin_y, origin_w] = extent.origin;
    let mut all = FaceBox { nearness: f32::INFINITY, ..FaceBox::NOTHING };
    boxes.clear();
    boxes.extend(parts.chunks(LANES).map(|parts| {
        let mut sixteen = SixteenBoxes::NO_POINTS;
        for (lane, part) in parts.iter().enumerate() {
            let FaceBox { x, y, nearness } = part.whole;
            let one = FaceBox {
                x: [x[0] + origin_x - ROUNDED, x[1] + origin_x + ROUNDED],
                y: [y[0] + origin_y - ROUNDED, y[1] + origin_y + ROUNDED],
                nearness: nearness + origin_w - (nearness.abs() + origin_w.abs()) * ROUNDED,
            };
            all.x = [all.x[0].min(one.x[0]), all.x[1].max(one.x[1])];
            all.y = [all.y[0].min(one.y[0]), all.y[1].max(one.y[1])];
            all.nearness = all.nearness.min(one.nearness);
            sixteen.set(lane, one);
        }
        sixteen
    }));
    all
}

/// An integer that ascends with `number`.
fn ascending(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ if number.is_sign_negative() { u32::MAX } else { 1 << 31 }
}

#[cfg(test)]
mod tests;
