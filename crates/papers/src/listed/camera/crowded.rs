//! Crowded tiles, whose triangles are divided among several threads (Guntury and Narayanan 2010, §5, future work).

use std::num::NonZeroU32;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use umbrage_rays::camera_grid::bins::bytes_of;
use umbrage_rays::camera_grid::samples::{SAMPLES, Samples, Undecided};
use umbrage_rays::camera_grid::tile::TileHits;
use umbrage_rays::camera_grid::trace::{TileTrace, Tiles};
use umbrage_rays::parallel::Parallel;
use umbrage_rays::shot::{Counts, SeenPixels};

use crate::listed::sorted::Sorted;

/// A share of the list of each cell of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListShare {
    number: u32,
    of: u32,
}

impl ListShare {
    /// The whole list.
    pub(super) const WHOLE: Self = Self { number: 0, of: 1 };

    pub(super) fn is_first(self) -> bool {
        self.number == 0
    }

    /// This part of a cell's list.
    #[inline(always)]
    pub(super) fn of(self, listed: &[u32]) -> &[u32] {
        let at = |number: u32| (listed.len() as u64 * u64::from(number) / u64::from(self.of)) as usize;
        &listed[at(self.number)..at(self.number + 1)]
    }
}

/// The parts of all divided tiles.
#[derive(Debug, Default)]
pub(super) struct Crowded {
    /// Parts, in the order of their tiles.
    parts: Vec<(u32, ListShare)>,
    /// The hits found by each part's search.
    found: Vec<ShareHits>,
}

/// The nearest hits of a part. 48 KB.
#[derive(Debug, Default)]
struct ShareHits {
    low: Vec<f32>,
    high: Vec<f32>,
    triangle: Vec<u32>,
}

impl Crowded {
    /// Parts are so large that there are at most twice as many of them: 48 MB.
    const ENOUGH_PARTS: usize = 512;

    /// Divides tiles of more than `most` pairs.
    pub(super) fn divide(&mut self, tiles: &[Sorted<u32>], most: Option<NonZeroU32>) {
        self.parts.clear();
        let Some(most) = most else { return };
        let pairs = |cells: &Sorted<u32>| cells.items().len();
        let most = tiles.iter().map(pairs).sum::<usize>().div_ceil(Self::ENOUGH_PARTS).max(most.get() as usize);
        for (tile, cells) in (0..).zip(tiles) {
            let of = pairs(cells).div_ceil(most) as u32;
            if of > 1 {
                self.parts.extend((0..of).map(|number| (tile, ListShare { number, of })));
            }
        }
    }

    /// Searches all parts on all threads by `search`, which gets the tile's index and the part. Returns the work, and adds
    /// the work of pixels to `work`.
    pub(super) fn search<const N: usize>(
        &mut self,
        tiles: &Tiles<'_>,
        scratch: &mut Vec<Mutex<Box<TileHits>>>,
        work: &mut [[u32; N]],
        search: impl Fn(&mut TileTrace<'_, N>, usize, ListShare) + Sync,
    ) -> Counts {
        if self.parts.is_empty() {
            return Counts::default();
        }
        scratch.resize_with(rayon::current_num_threads() + 1, Mutex::default);
        let scratch = &*scratch;
        let Self { parts, found } = self;
        found.resize_with(parts.len().max(found.len()), ShareHits::default);
        let all_work = Mutex::new(work);
        let parts = parts.par_iter().zip(&mut *found).with_max_len(1);
        let counted = parts.map(|(&(tile, part), found)| {
            let tile = tile as usize;
            let mut work = vec![[0; N]; SAMPLES];
            let counts = tiles.search(scratch, tile, &mut work, |trace| {
                search(trace, tile, part);
                found.keep(&trace.tile.samples);
            });
            if N > 0 {
                let mut all_work = all_work.lock().unwrap_or_else(PoisonError::into_inner);
                let pixels = all_work[tile * SAMPLES..(tile + 1) * SAMPLES].as_flattened_mut();
                pixels.iter_mut().zip(work.as_flattened()).for_each(|(all, part)| *all += part);
            }
            counts
        });
        counted.merge(Counts::plus).unwrap_or_default()
    }

    /// Merges the parts' hits into the tile at an index. Returns false if the tile wasn't searched in parts.
    pub(super) fn merge<const N: usize>(&self, trace: &mut TileTrace<'_, N>, index: usize) -> bool {
        let first = self.parts.partition_point(|&(tile, _)| (tile as usize) < index);
        let parts = self.parts[first..].iter().zip(&self.found[first..]);
        let mut parts = parts.take_while(|&(&(tile, _), _)| tile as usize == index).map(|(_, found)| found);
        let Some(first) = parts.next() else { return false };
        first.give(&mut trace.tile.samples);
        for found in parts {
            found.merge(&mut trace.tile.samples);
            trace.settle();
        }
        true
    }

    pub(super) fn bytes(&self) -> usize {
        bytes_of(&self.parts) + self.found.iter().map(ShareHits::bytes).sum::<usize>()
    }
}

impl ShareHits {
    /// Copies the settled hits.
    fn keep(&mut self, samples: &Samples) {
        let Self { low, high, triangle } = self;
        low.clear();
        low.extend_from_slice(&samples.low);
        high.clear();
        high.extend_from_slice(&samples.high);
        triangle.clear();
        triangle.extend_from_slice(&samples.triangle);
    }

    /// Replaces a tile's hits.
    fn give(&self, samples: &mut Samples) {
        samples.low.copy_from_slice(&self.low);
        samples.high.copy_from_slice(&self.high);
        samples.triangle.copy_from_slice(&self.triangle);
    }

    /// Merges hits that are certainly nearer into a tile, and leaves those that may be nearer undecided.
    fn merge(&self, samples: &mut Samples) {
        let found = self.low.iter().zip(&self.high).zip(&self.triangle).enumerate();
        for (index, ((&low, &high), &triangle)) in found {
            if triangle == SeenPixels::NONE || high < samples.low[index] {
                continue;
            }
            if low > samples.high[index] {
                (samples.low[index], samples.high[index], samples.triangle[index]) = (low, high, triangle);
            } else {
                samples.undecided.push(Undecided { index: index as u32, triangle, high });
            }
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Self>() + bytes_of(&self.low) + bytes_of(&self.high) + bytes_of(&self.triangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_never_too_many_parts() {
        let mut tiles = vec![Sorted::default(); 40];
        for (tile, sorted) in tiles.iter_mut().enumerate() {
            sorted.sort(1, (0..1000 * tile as u32).map(|triangle| (0, triangle)));
        }
        let mut crowded = Crowded::default();
        for most in [1, 100, 2000, 1 << 20] {
            crowded.divide(&tiles, NonZeroU32::new(most));
            assert!(crowded.parts.len() <= 2 * Crowded::ENOUGH_PARTS, "{most}: {}", crowded.parts.len());
            assert_eq!(crowded.parts.is_empty(), most == 1 << 20);
        }
    }

    #[test]
    fn parts_of_a_list_are_all_of_it_once() {
        for length in [0_u32, 1, 2, 7, 64, 1000] {
            let listed: Vec<u32> = (0..length).collect();
            for of in [1, 2, 3, 7, 100] {
                let parts: Vec<u32> =
                    (0..of).flat_map(|number| ListShare { number, of }.of(&listed).to_vec()).collect();
                assert_eq!(parts, listed, "{length} in {of}");
            }
        }
    }
}
