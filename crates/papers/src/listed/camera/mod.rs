//! The paper's own form of the perspective grid (Guntury and Narayanan 2010, §3), for comparison with the direct form.
//!
//! Triangles that can't contain a sample are dropped, the others are listed in cells (sorting tiles × depth slices) by a
//! counting sort, and each tile's cells are searched front to back until nothing can be nearer than the hits.

mod build;
mod cells;
mod crowded;
mod drop;
mod list;
mod slices;
mod trace;
mod validate;

use std::num::NonZeroU32;
use std::sync::Mutex;

use umbrage_rays::camera_grid::bins::bytes_of;
use umbrage_rays::camera_grid::pixel_space::{PixelSpace, Vertex};
use umbrage_rays::camera_grid::tile::TileHits;
use umbrage_rays::{Omitted, SimdLevel, TileOrder, debug_some};

use crate::listed::sorted::Sorted;
pub use cells::{Cells, ImpossibleCells};
use crowded::Crowded;
use drop::UnsortedRange;
use slices::Slices;

/// The triangles of a frame, listed by cell, for one ray through each pixel.
///
/// 16 bytes a vertex and 36 for each triangle in sight: 16 for a kept triangle, then 8 + 8 + 4 for each pair of a triangle
/// and a sorting tile on the way to its cell. Keep it and rebuild it: its memory is reused.
#[derive(Default)]
pub(super) struct ListedGrid {
    level: SimdLevel,
    options: ListedOptions,
    /// `None` before the first build.
    space: Option<PixelSpace>,
    triangle_count: usize,
    vertices: Vec<Vertex>,
    /// A bit for each triangle, set if it has a mask.
    masked: Vec<u64>,
    any_masked: bool,
    /// The sign of the area in pixel space of triangles that show their front; zero where both sides count.
    facing: f32,
    slices: Slices,
    /// Ranges of triangles, in order of ids.
    ranges: Vec<UnsortedRange>,
    /// The triangles of each tile of the [`TileOrder`], by cell.
    tiles: Vec<Sorted<u32>>,
    omitted: Omitted,
    dropped: u64,
    /// A tile for each thread.
    scratch: Vec<Mutex<Box<TileHits>>>,
    crowded: Crowded,
}

debug_some!(ListedGrid as grid: "triangles" => grid.triangle_count);

/// The options of the camera's grid of [`ListedGrids`](super::ListedGrids). They change its speed only, not its answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListedOptions {
    /// The division of the view into cells.
    pub cells: Cells,
    /// Whether triangles are tested only in those blocks of 4×4 pixels where they can be the nearest, by their bounds and
    /// their nearest corner. Otherwise all pixels of a sorting tile that may still find something nearer test all of a
    /// cell's triangles, as in the paper.
    pub skips_blocks: bool,
    /// The largest number of triangles that one thread searches in a tile of 64×64 pixels, each counted once for each cell
    /// that lists it: tiles of more are divided among threads, and the hits of the parts are compared in the end (§5, future
    /// work). `None` divides none.
    pub most_triangles: Option<NonZeroU32>,
}

impl ListedOptions {
    /// The best by measurement.
    pub const DEFAULT: Self = Self { cells: Cells::DEFAULT, skips_blocks: true, most_triangles: None };
}

impl Default for ListedOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ListedGrid {
    /// An empty grid that uses the instructions of `level`.
    pub(super) fn new(level: SimdLevel, options: ListedOptions) -> Self {
        Self { level, options, ..Self::default() }
    }

    /// The image's order of tiles.
    pub(super) fn order(&self) -> TileOrder {
        let (width, height) = self.space.as_ref().map_or((0, 0), PixelSpace::size);
        TileOrder::new(width, height)
    }

    /// The triangles that were left out because no ray can hit them.
    pub(super) fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// Bytes held for the last frame, without the pixels.
    pub(super) fn bytes(&self) -> usize {
        bytes_of(&self.vertices)
            + bytes_of(&self.masked)
            + self.ranges.iter().map(UnsortedRange::bytes).sum::<usize>()
            + self.tiles.iter().map(|cells| size_of_val(cells) + cells.bytes()).sum::<usize>()
            + self.scratch.len() * size_of::<TileHits>()
            + self.crowded.bytes()
    }
}
