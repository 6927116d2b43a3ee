//! A frame shaded strip by strip, on all threads.

use glam::{UVec2, Vec4};
use rayon::iter::Either;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::{SimdLevel, TileOrder, View};

use super::marks::{MarkStrip, Marks};
use super::onward::Queue;
use super::samples::OneSample;
use super::shade::Shading;
use super::strip::{FirstHits, Strip};
use crate::Film;
use crate::develop::Developer;
use crate::sampling::Samples;
use crate::shade::Block;

/// A frame to be shaded in strips, rows of blocks.
pub(super) struct Strips<'a> {
    pub(super) shading: &'a Shading<'a>,
    pub(super) level: SimdLevel,
    pub(super) view: &'a View,
    pub(super) samples: &'a Samples,
    pub(super) marks: Option<&'a Marks>,
}

impl Strips<'_> {
    /// Adds all of them to the film.
    pub(super) fn shade(&self, Film { color, flat, depth, normal, triangle, .. }: &mut Film) {
        let rows = self.pixels();
        let strips = color.len().div_ceil(rows);
        let flat = match flat.is_empty() {
            true => Either::Left((0..strips).into_par_iter().map(|_| None)),
            false => Either::Right(flat.par_chunks_mut(rows).map(Some)),
        };
        let hits = match triangle.is_empty() {
            true => Either::Left((0..strips).into_par_iter().map(|_| None)),
            false => {
                let hits = depth.par_chunks_mut(rows).zip(normal.par_chunks_mut(rows));
                let hits = hits.zip(triangle.par_chunks_mut(rows));
                Either::Right(hits.map(|((depth, normal), triangle)| Some(FirstHits { depth, normal, triangle })))
            }
        };
        let planes = color.par_chunks_mut(rows).zip(flat).zip(hits);
        planes.enumerate().for_each_init(<_>::default, |memory, (number, ((color, flat), hits))| {
            self.add(number, memory, &mut Strip { color, flat, hits });
        });
    }

    /// Develops all of them, each while a fast cache has it.
    pub(super) fn develop(&self, developer: Developer, rows: &mut Vec<u8>) {
        rows.resize(3 * self.view.width as usize * self.view.height as usize, 0);
        let strips = rows.par_chunks_mut(3 * self.pixels()).enumerate();
        strips.for_each_init(<(_, [Vec<Vec4>; 2])>::default, |(memory, [color, flat]), (number, rows)| {
            let pixels = rows.len() / 3;
            color.resize(pixels, Vec4::ZERO);
            flat.resize(if self.shading.has_flat { pixels } else { 0 }, Vec4::ZERO);
            let has_flat = Some(&mut flat[..]).filter(|flat| !flat.is_empty());
            self.add(number, memory, &mut Strip { color, flat: has_flat, hits: None });
            dispatch!(self.level, simd => developer.encode_rows(simd, (color, flat), rows));
        });
    }

    /// The pixels of a strip that isn't cut.
    fn pixels(&self) -> usize {
        TileOrder::BLOCK as usize * self.view.width as usize
    }

    /// Adds a strip, in the memory of an earlier one.
    fn add(&self, number: usize, (queue, drawn): &mut (Queue, MarkStrip), film: &mut Strip<'_>) {
        let &Self { shading, level, view, samples, marks } = self;
        let y = number as u32 * TileOrder::BLOCK;
        for (which, sample) in samples.as_slice().iter().enumerate() {
            let one = OneSample::new(shading.seen.order(), samples, which);
            if let Some(marks) = marks {
                drawn.draw(marks, view, sample, y);
            }
            for x in (0..view.width).step_by(TileOrder::BLOCK as usize) {
                let block = Block { view, sample, corner: UVec2::new(x, y) };
                let before = [queue.next.len(), queue.shadows.len()];
                dispatch!(level, simd => {
                    let mut shaded = shading.shade_seen(simd, &block, &one, queue);
                    if let Some(marks) = marks {
                        let ids = one.slots(block.corner).of(&shading.seen.triangle);
                        drawn.cover(marks, shading.frame, &block, &ids, &mut shaded).take_from(queue, before);
                    }
                    film.add_block(simd, &block, &shaded);
                });
            }
            queue.follow(level, shading, marks.map(|marks| (marks, &*drawn)), film);
        }
    }
}
