use rayon::prelude::*;
use umbrage_rays::Triangles;
use umbrage_rays::camera_grid::ImageTooLarge;
use umbrage_rays::camera_grid::pixel_space::{PixelSpace, Vertex};
use umbrage_rays::parallel::Parallel;
use umbrage_rays::shot::{Seconds, Shot};
use umbrage_rays::{SimdLevel, dispatch, vectorized};
use web_time::Instant;

use super::drop::{Drop, UnsortedRange};
use super::list::List;
use super::{ListedGrid, Slices};
use crate::listed::sorted::Sorted;

impl ListedGrid {
    /// Replaces the grid by one for the triangles of `shot` and its pixels' rays; returns the times of the stages. Runs on
    /// all threads of the current pool.
    ///
    /// # Errors
    /// If a side of the image is longer than [`ImageTooLarge::LARGEST_SIDE`].
    pub(crate) fn build(&mut self, shot: &Shot<'_>) -> Result<Seconds, ImageTooLarge> {
        ImageTooLarge::check(&shot.view)?;
        let space = PixelSpace::new(shot);
        self.space = Some(space);
        self.triangle_count = shot.triangles.len();
        let start = Instant::now();
        project(self.level, &space, shot.triangles, &mut self.vertices);
        let projected = Instant::now();
        self.facing = space.facing(shot.sides);
        self.drop(&space, shot);
        self.list(&space, shot.triangles);
        let listed = Instant::now();
        self.sort();
        Ok(Seconds {
            project: (projected - start).as_secs_f64(),
            list: (listed - projected).as_secs_f64(),
            sort: listed.elapsed().as_secs_f64(),
            ..Seconds::default()
        })
    }

    /// Drops triangles that can't contain a sample. The number of ranges doesn't depend on that of threads.
    fn drop(&mut self, space: &PixelSpace, shot: &Shot<'_>) {
        const SMALLEST_RANGE: usize = 4096;
        const MOST_RANGES: usize = 64;
        let Shot { triangles, opacity, sides, .. } = *shot;
        let count = triangles.len();
        let ranges = count.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES);
        // Whole batches, and whole words of mask bits.
        let length = count.div_ceil(ranges).next_multiple_of(u64::BITS as usize).max(u64::BITS as usize);
        let words = length / u64::BITS as usize;
        let level = self.level;
        self.ranges.resize_with(ranges, UnsortedRange::default);
        self.masked.resize(words * ranges, 0);
        let (vertices, facing) = (&self.vertices, self.facing);
        let ranges = self.ranges.par_iter_mut().zip(self.masked.par_chunks_mut(words)).enumerate().with_max_len(1);
        ranges.each(|(index, (range, masked_bits))| {
            let ids = (index * length).min(count)..((index + 1) * length).min(count);
            let drop = Drop { space, triangles, vertices, opacity, facing, sides, range, masked_bits };
            dispatch!(level, simd => drop.run(simd, ids));
        });
        self.omitted.clear();
        (self.dropped, self.any_masked) = (0, false);
        let mut depths = [f32::INFINITY, 0.0];
        for range in &self.ranges {
            self.omitted.append(&range.omitted);
            self.dropped += range.dropped;
            self.any_masked |= range.any_masked;
            depths = [depths[0].min(range.depths[0]), depths[1].max(range.depths[1])];
        }
        self.slices = Slices::new(self.options.cells.slices(), depths[0], depths[1]);
    }

    /// Lists the kept triangles, and sorts each range's pairs by tile.
    fn list(&mut self, space: &PixelSpace, triangles: Triangles<'_>) {
        let (order, cells, slices) = (self.order(), self.options.cells, &self.slices);
        let (columns, rows) = order.tiles();
        self.ranges.par_iter_mut().with_max_len(1).each(|range| {
            let UnsortedRange { kept, general, unsorted, pairs, .. } = range;
            unsorted.clear();
            List { space, triangles, cells, slices, tile_columns: columns, pairs: unsorted }.run(kept, general);
            pairs.sort(columns as usize * rows as usize, unsorted.iter().map(|pair| (pair.tile(), *pair)));
        });
    }

    /// Sorts each tile's pairs by cell.
    fn sort(&mut self) {
        let (columns, rows) = self.order().tiles();
        self.tiles.resize_with(columns as usize * rows as usize, Sorted::default);
        let (ranges, cells) = (&self.ranges, self.options.cells.in_tile());
        let tiles = self.tiles.par_iter_mut().enumerate().with_max_len(1);
        tiles.each(|(tile, sorted)| {
            let pairs = ranges.iter().flat_map(|range| range.pairs.of(tile..tile + 1));
            sorted.sort(cells, pairs.map(|pair| (pair.cell_in_tile(), pair.triangle)));
        });
    }
}

/// Projects each vertex once, and adds one more for all indices that are out of range.
fn project(level: SimdLevel, space: &PixelSpace, triangles: Triangles<'_>, vertices: &mut Vec<Vertex>) {
    const CHUNK: usize = 4096;
    vertices.resize(triangles.positions.len() + 1, Vertex::AWKWARD);
    if let Some(last) = vertices.last_mut() {
        *last = Vertex::AWKWARD;
    }
    let chunks = vertices.par_chunks_mut(CHUNK).zip(triangles.positions.par_chunks(CHUNK));
    chunks.each(|(vertices, positions)| {
        dispatch!(level, simd => vectorized!(simd => space.project(simd, positions, vertices)));
    });
}
