//! The part of each pixel that each object covers.

use std::collections::BTreeMap;

use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

/// An object's part of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered {
    /// The object, as an index into [`FilmLayers::objects`](crate::FilmLayers);
    /// [`Film::NO_TRIANGLE`](crate::Film::NO_TRIANGLE) for none.
    pub object: u32,
    /// The part of the pixel's samples that see it, from 0 to 1.
    pub part: f32,
}

impl Covered {
    const NOTHING: Self = Self { object: u32::MAX, part: 0.0 };
}

/// The objects in each pixel, with the parts of its samples that see them.
///
/// While samples are added, parts are counts, and objects are in the order of their first samples.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    pixels: Vec<[Covered; Coverage::RANKS]>,
    /// For each row, the counts of further objects, by column and object.
    further: Vec<BTreeMap<(u32, u32), f32>>,
}

/// A row of the film.
pub(crate) struct CoverageRow<'a> {
    pixels: &'a mut [[Covered; Coverage::RANKS]],
    further: &'a mut BTreeMap<(u32, u32), f32>,
}

impl Coverage {
    /// Maximum number of objects of a pixel: the ones that cover most of it.
    pub const RANKS: usize = 6;

    /// For each pixel, in rows from the upper left corner, the objects that cover most of it: the greatest part first, of
    /// equal parts the lowest number. Empty unless asked for.
    #[must_use]
    pub fn pixels(&self) -> &[[Covered; Self::RANKS]] {
        &self.pixels
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.pixels.as_slice()) + size_of_val(self.further.as_slice())
    }

    pub(super) fn clear(&mut self, pixels: usize, rows: usize) {
        super::refill(&mut self.pixels, pixels, [Covered::NOTHING; Self::RANKS]);
        self.further.clear();
        self.further.resize(rows, BTreeMap::new());
    }

    pub(super) fn reserve(&mut self, pixels: usize) -> Result<(), std::collections::TryReserveError> {
        self.pixels.try_reserve_exact(pixels.saturating_sub(self.pixels.len()))
    }

    /// The rows of a film that is `width` pixels wide.
    pub(crate) fn rows_mut(&mut self, width: usize) -> impl IndexedParallelIterator<Item = CoverageRow<'_>> {
        let rows = self.pixels.par_chunks_mut(width).zip(&mut self.further);
        rows.map(|(pixels, further)| CoverageRow { pixels, further })
    }

    /// Turns counts into parts, of `weight` for each sample, and sorts them.
    pub(super) fn finish(&mut self, width: usize, weight: f32) {
        if self.pixels.is_empty() {
            return;
        }
        self.rows_mut(width).each(|row| {
            let mut all = Vec::new();
            for (x, ranks) in (0..).zip(row.pixels) {
                all.clear();
                all.extend(ranks.iter().filter(|covered| covered.part > 0.0));
                let further = row.further.range((x, 0)..=(x, u32::MAX));
                all.extend(further.map(|(&(_, object), &part)| Covered { object, part }));
                all.sort_unstable_by(|a, b| b.part.total_cmp(&a.part).then(a.object.cmp(&b.object)));
                *ranks = [Covered::NOTHING; Self::RANKS];
                for (rank, covered) in ranks.iter_mut().zip(&all) {
                    *rank = Covered { part: covered.part * weight, ..*covered };
                }
            }
            row.further.clear();
        });
    }
}

impl CoverageRow<'_> {
    /// Counts a sample of the pixel in a column that sees an object.
    pub(crate) fn add(&mut self, column: usize, object: u32) {
        let is_its = |covered: &&mut Covered| covered.object == object || covered.part == 0.0;
        match self.pixels[column].iter_mut().find(is_its) {
            Some(covered) => *covered = Covered { object, part: covered.part + 1.0 },
            None => *self.further.entry((column as u32, object)).or_default() += 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_objects_that_cover_most_stay() {
        let mut coverage = Coverage::default();
        coverage.clear(4, 2);
        // Object n is seen n times, the largest ones last, in one pixel.
        let order: Vec<u32> = (1..=9).flat_map(|object| vec![object; object as usize]).collect();
        let samples = order.len() as f32;
        coverage.rows_mut(2).enumerate().each(|(y, mut row)| {
            if y == 1 {
                order.iter().for_each(|&object| row.add(1, object));
                row.add(0, 5);
                row.add(0, 3);
            }
        });
        coverage.finish(2, 1.0 / samples);
        let ranks = |pixel: usize| coverage.pixels()[pixel].map(|covered| (covered.object, covered.part * samples));
        assert_eq!(ranks(3).map(|(object, _)| object), [9, 8, 7, 6, 5, 4]);
        assert!(ranks(3).iter().all(|&(object, part)| (part - object as f32).abs() < 1e-5));
        assert_eq!(ranks(2).map(|(object, _)| object)[..3], [3, 5, u32::MAX], "of equal parts the lowest number");
        assert_eq!(coverage.pixels()[0], [Covered::NOTHING; Coverage::RANKS]);
    }
}
