use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::boxes::{FaceBox, SplatBox};
use super::candidates::BATCH_PARTS;
use super::filter::TilePoints;
use super::parts::TilePart;
use super::points::TILE_BLOCKS;
use crate::shot::Counts;
use crate::simd::lanes::bits_of;
use crate::simd::vectors::LANES;

/// The points of a batch's parts, and the verdicts on them.
pub(crate) struct BatchPoints<'a> {
    pub(crate) tile: TilePoints<'a>,
    pub(crate) parts: &'a [TilePart],
    untested: [Untested; BATCH_PARTS],
    /// Pairs of a point's index and a triangle that the filter couldn't decide.
    pub(crate) undecided: &'a mut Vec<[u32; 2]>,
    pub(crate) counts: &'a mut Counts,
}

/// The points of a part that must still be tested.
#[derive(Clone, Copy, Debug)]
struct Untested {
    /// The points of each slot that needn't be tested: they are in shadow, or aren't in the slot.
    done: [u16; LANES],
    /// The slots that have other points.
    alive: u16,
}

/// Slots of some parts of a batch.
#[derive(Clone, Debug)]
pub(crate) struct SlotList {
    /// The index of each part, and a mask of its slots.
    parts: [(u8, u16); BATCH_PARTS],
    len: usize,
    /// Whether the slots' points were searched.
    is_searched: bool,
    /// Those that were found; has no meaning where none were searched.
    found: [SlotPoints; MOST_SEARCHED],
    found_len: usize,
}

/// Points of a slot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SlotPoints {
    /// The index of its part in the batch.
    pub(crate) part: u8,
    pub(crate) slot: u8,
    pub(crate) points: u16,
}

/// The largest number of slots whose points are searched.
pub(crate) const MOST_SEARCHED: usize = 64;

impl<'a> BatchPoints<'a> {
    /// The points of `parts` that aren't `shadowed`.
    pub(crate) fn new(
        tile: TilePoints<'a>,
        parts: &'a [TilePart],
        shadowed: &[u16; TILE_BLOCKS],
        undecided: &'a mut Vec<[u32; 2]>,
        counts: &'a mut Counts,
    ) -> Self {
        let mut untested = [Untested { done: [u16::MAX; LANES], alive: 0 }; BATCH_PARTS];
        for (untested, part) in untested.iter_mut().zip(parts) {
            *untested = Untested::of(part, shadowed);
        }
        Self { tile, parts, untested, undecided, counts }
    }

    /// The slots of a part with points that must still be tested.
    #[inline(always)]
    pub(crate) fn alive(&self, part: usize) -> u16 {
        self.untested[part].alive
    }

    /// The points of a slot that needn't be tested.
    #[inline(always)]
    pub(crate) fn done(&self, part: usize, slot: usize) -> u16 {
        self.untested[part].done[slot % LANES]
    }

    /// Lists those `among` some slots that have untested points in a box. Where more than `most_searched` have bounds that
    /// overlap it, which is at most [`MOST_SEARCHED`], their points aren't searched.
    #[inline(always)]
    pub(crate) fn list_reached<S: Simd>(
        &self,
        simd: S,
        around: &FaceBox,
        among: impl Iterator<Item = (usize, u16)>,
        most_searched: u32,
        list: &mut SlotList,
    ) {
        let around = SplatBox::new(simd, around);
        let mut count = 0;
        (list.len, list.found_len) = (0, 0);
        for (part, slots) in among {
            let overlap = self.parts[part].boxes.reached(simd, &around).to_bitmask() as u16;
            let slots = overlap & slots & self.alive(part);
            count += slots.count_ones();
            list.push(part, slots);
        }
        list.is_searched = count <= most_searched;
        if !list.is_searched {
            return;
        }
        let overlapping = std::mem::take(&mut list.len);
        for entry in 0..overlapping {
            let (part, slots) = list.get(entry);
            let mut reached = 0;
            for slot in bits_of(slots) {
                let inside = self.tile.inside(simd, self.parts[part].blocks[slot % LANES], &around);
                let points = inside & !self.done(part, slot);
                reached |= u16::from(points != 0) << slot;
                list.found[list.found_len % MOST_SEARCHED] = SlotPoints { part: part as u8, slot: slot as u8, points };
                list.found_len += usize::from(points != 0);
            }
            list.push(part, reached);
        }
    }

    /// Notes which points of a slot a triangle certainly shadows, and which of those that it may shadow are undecided.
    #[inline(always)]
    pub(crate) fn note(&mut self, (part, slot): (usize, usize), id: u32, possible: u16, certain: u16) {
        self.untested[part].take_out(slot, certain);
        if possible & !certain != 0 {
            self.tile.list_pending(self.parts[part].blocks[slot], id, possible & !certain, self.undecided);
        }
    }

    /// Adds the points found in shadow to those of the tile's blocks.
    pub(crate) fn keep(&self, shadowed: &mut [u16; TILE_BLOCKS]) {
        for (part, untested) in self.parts.iter().zip(&self.untested) {
            for ((&block, &members), done) in part.blocks.iter().zip(&part.points).zip(untested.done) {
                shadowed[usize::from(block)] |= members & done;
            }
        }
    }
}

impl Untested {
    fn of(part: &TilePart, shadowed: &[u16; TILE_BLOCKS]) -> Self {
        let done: [u16; LANES] =
            std::array::from_fn(|slot| !part.points[slot] | shadowed[usize::from(part.blocks[slot])]);
        let alive = (0..LANES).fold(0, |alive, slot| alive | u16::from(done[slot] != u16::MAX) << slot);
        Self { done, alive }
    }

    #[inline(always)]
    fn take_out(&mut self, slot: usize, points: u16) {
        let slot = slot % LANES;
        self.done[slot] |= points;
        self.alive &= !(u16::from(self.done[slot] == u16::MAX) << slot);
    }
}

impl SlotList {
    pub(crate) const EMPTY: Self = Self {
        parts: [(0, 0); BATCH_PARTS],
        len: 0,
        is_searched: false,
        found: [SlotPoints { part: 0, slot: 0, points: 0 }; MOST_SEARCHED],
        found_len: 0,
    };

    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The untested points of each slot in the box, if they were searched.
    #[inline(always)]
    pub(crate) fn found(&self) -> Option<&[SlotPoints]> {
        self.is_searched.then(|| &self.found[..self.found_len.min(MOST_SEARCHED)])
    }

    #[inline(always)]
    fn get(&self, entry: usize) -> (usize, u16) {
        let (part, slots) = self.parts[entry % BATCH_PARTS];
        (usize::from(part), slots)
    }

    /// The index of each part, and a mask of its slots.
    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, u16)> {
        (0..self.len).map(|entry| self.get(entry))
    }

    /// Adds slots of a part, if there are any.
    #[inline(always)]
    fn push(&mut self, part: usize, slots: u16) {
        self.parts[self.len % BATCH_PARTS] = (part as u8, slots);
        self.len += usize::from(slots != 0);
    }
}

#[cfg(test)]
mod tests;
