use std::time::Instant;

use fearless_simd::dispatch;
use glam::DVec2;
use rayon::prelude::*;

use super::drop::{Drop, Range};
use super::list::List;
use super::sort::TileCells;
use super::{ListedGrid, ListedOptions, ListedSeconds, Slices};
use crate::camera_grid::ImageTooLarge;
use crate::camera_grid::pixel_space::{PixelSpace, Vertex};
use crate::{Triangles, View};

impl ListedGrid {
    /// Replaces the grid by one of `triangles` for the rays of `view` through `offset_pixels` in each pixel, which is
    /// (0, 0) at its upper left and (1, 1) at its lower right. Runs on all threads of the current pool.
    ///
    /// Hits on triangles that are `masked` are put in question by [`trace`](Self::trace).
    ///
    /// # Errors
    /// If a side of the image is longer than [`ImageTooLarge::LARGEST_SIDE`].
    pub fn build(
        &mut self,
        triangles: Triangles<'_>,
        view: &View,
        offset_pixels: DVec2,
        options: ListedOptions,
        masked: impl Fn(u32) -> bool + Sync,
    ) -> Result<(), ImageTooLarge> {
        if view.width.max(view.height) > ImageTooLarge::LARGEST_SIDE {
            return Err(ImageTooLarge { width: view.width, height: view.height });
        }
        let space = PixelSpace::new(view, offset_pixels);
        self.space = Some(space);
        self.options = options;
        self.triangle_count = triangles.len();
        let start = Instant::now();
        self.project(&space, triangles);
        let projected = Instant::now();
        self.facing = if self.options.culls_back_faces { space.front_sign() } else { 0.0 };
        self.drop(&space, triangles, &masked);
        self.list(&space, triangles);
        let listed = Instant::now();
        self.sort();
        self.seconds = ListedSeconds {
            project: (projected - start).as_secs_f64(),
            list: (listed - projected).as_secs_f64(),
            sort: listed.elapsed().as_secs_f64(),
            trace: 0.0,
        };
        Ok(())
    }

    /// Transforms each vertex once.
    fn project(&mut self, space: &PixelSpace, triangles: Triangles<'_>) {
        const CHUNK: usize = 4096;
        let level = self.level.0;
        // The last one stands for those that are out of range.
        self.vertices.resize(triangles.positions.len() + 1, Vertex::AWKWARD);
        if let Some(last) = self.vertices.last_mut() {
            *last = Vertex::AWKWARD;
        }
        let chunks = self.vertices.par_chunks_mut(CHUNK).zip(triangles.positions.par_chunks(CHUNK));
        chunks.for_each(|(vertices, positions)| dispatch!(level, simd => space.project(simd, positions, vertices)));
    }

    /// Drops triangles that can't contain a sample, in ranges whose number doesn't depend on that of threads.
    fn drop(&mut self, space: &PixelSpace, triangles: Triangles<'_>, masked: &(impl Fn(u32) -> bool + Sync)) {
        const SMALLEST_RANGE: usize = 4096;
        const MOST_RANGES: usize = 64;
        let count = triangles.len();
        let ranges = count.div_ceil(SMALLEST_RANGE).clamp(1, MOST_RANGES);
        // Whole batches, and whole words of mask bits.
        let length = count.div_ceil(ranges).next_multiple_of(u64::BITS as usize).max(u64::BITS as usize);
        let words = length / u64::BITS as usize;
        let level = self.level.0;
        self.ranges.resize_with(ranges, Range::default);
        self.masked.resize(words * ranges, 0);
        let (vertices, facing) = (&self.vertices, self.facing);
        let ranges = self.ranges.par_iter_mut().zip(self.masked.par_chunks_mut(words)).enumerate().with_max_len(1);
        ranges.for_each(|(place, (range, masked_bits))| {
            let ids = (place * length).min(count)..((place + 1) * length).min(count);
            let drop = Drop { space, triangles, vertices, masked, facing, range, masked_bits };
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

    /// Lists what was kept, and sorts each range's pairs by tile.
    fn list(&mut self, space: &PixelSpace, triangles: Triangles<'_>) {
        let (order, cells, slices) = (self.order(), self.options.cells, &self.slices);
        let (columns, rows) = order.tiles();
        self.ranges.par_iter_mut().with_max_len(1).for_each(|range| {
            let Range { kept, general, unsorted, .. } = range;
            unsorted.clear();
            List { space, triangles, cells, slices, tile_columns: columns, pairs: unsorted }.run(kept, general);
            range.sort_by_tile(columns as usize * rows as usize);
        });
    }

    /// Sorts each tile's pairs by cell.
    fn sort(&mut self) {
        let (columns, rows) = self.order().tiles();
        self.tiles.resize_with(columns as usize * rows as usize, TileCells::default);
        let (ranges, cells) = (&self.ranges, self.options.cells.in_tile());
        let tiles = self.tiles.par_iter_mut().enumerate().with_max_len(1);
        tiles.for_each(|(tile, sorted)| sorted.sort(ranges, tile, cells));
    }
}
