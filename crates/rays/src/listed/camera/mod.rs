//! The paper's own form of the perspective grid (Guntury and Narayanan 2010, §3): what the direct form is compared with.
//!
//! Triangles that can't contain a sample are dropped, the others are listed in cells (sorting tiles × depth slices) by
//! a counting sort, and each tile's cells are searched front to back until nothing can be nearer than what is found.

mod build;
mod cells;
mod drop;
mod list;
mod samples;
mod settle;
mod slices;
mod sort;
mod trace;
mod validate;

use std::sync::Mutex;

use crate::camera_grid::bins::bytes_of;
use crate::camera_grid::pixel_space::{PixelSpace, Vertex};
use crate::{Hit, Omitted, SeenPixels, Triangles};
use crate::{SimdLevel, TileOrder};
pub use cells::{Cells, ImpossibleCells};
use drop::Range;
use samples::Samples;
use slices::Slices;
use sort::TileCells;

/// The triangles of a frame, listed by cell, for one ray through each pixel.
///
/// 16 bytes a vertex and 36 for each triangle that is in sight: 16 where it is kept, then 8 + 8 + 4 for each pair of a
/// triangle and a sorting tile on the way to its cell. Keep it and rebuild it: its memory is reused.
#[derive(Default)]
pub struct ListedGrid {
    level: SimdLevel,
    /// Those of the last build.
    options: ListedOptions,
    /// None before the first build.
    space: Option<PixelSpace>,
    triangle_count: usize,
    vertices: Vec<Vertex>,
    /// A bit for each triangle.
    masked: Vec<u64>,
    any_masked: bool,
    /// The sign of the area in pixel space of triangles that show their front; zero where both sides count.
    facing: f32,
    slices: Slices,
    /// In order of triangle ids.
    ranges: Vec<Range>,
    /// One for each tile of the [`TileOrder`].
    tiles: Vec<TileCells>,
    omitted: Omitted,
    dropped: u64,
    seconds: ListedSeconds,
    /// One for each thread.
    scratch: Vec<Mutex<Box<Samples>>>,
}

impl std::fmt::Debug for ListedGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ListedGrid").field("triangles", &self.triangle_count).finish_non_exhaustive()
    }
}

/// The parameters of a [`ListedGrid`]. They change how fast it is, and `culls_back_faces` alone what it finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListedOptions {
    /// How the view is cut into cells.
    pub cells: Cells,
    /// Whether triangles whose corners are seen clockwise are not there.
    pub culls_back_faces: bool,
    /// Whether triangles are tested only in those blocks of 4×4 pixels that they can be the nearest in, by their bounds
    /// and their nearest corner. Otherwise all pixels of a sorting tile that may still find something nearer test all
    /// of a cell's triangles, as in the paper.
    pub skips_blocks: bool,
}

impl ListedOptions {
    /// What measured best.
    pub const DEFAULT: Self = Self { cells: Cells::DEFAULT, culls_back_faces: false, skips_blocks: true };
}

impl Default for ListedOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How much work a frame was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListedCounts {
    /// Triangles that could be hit by no sample's ray, and weren't listed.
    pub dropped: u64,
    /// Pairs of a triangle and a cell.
    pub pairs: u64,
    /// Cells with triangles that were searched.
    pub cells: u64,
    /// Pairs of a triangle and a block of 4×4 samples that were tested.
    pub tests: u64,
    /// Pairs of a triangle and a sample that the filter left undecided.
    pub undecided: u64,
    /// Those of them that were handed to the predicate, since nothing nearer was found.
    pub referred: u64,
    /// Pixels whose depth was found again in f64, since the filter's wasn't good enough.
    pub refined: u64,
}

/// What each stage of the last frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ListedSeconds {
    /// Vertices to pixel space.
    pub project: f64,
    /// Triangles dropped or listed.
    pub list: f64,
    /// Pairs sorted by cell.
    pub sort: f64,
    /// Cells searched.
    pub trace: f64,
}

impl ListedGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// The triangles that were left out because no ray can hit them.
    #[must_use]
    pub fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// What each stage of the last build and trace took.
    #[must_use]
    pub fn seconds(&self) -> ListedSeconds {
        self.seconds
    }

    /// What the camera's ray through the pixel in column `x` and row `y` hits; `None` for a miss.
    ///
    /// `triangles` and `seen` are those of the last build and trace.
    #[must_use]
    pub fn hit(&self, triangles: Triangles<'_>, seen: &SeenPixels, (x, y): (u32, u32)) -> Option<Hit> {
        let space = self.space.as_ref()?;
        let triangle = Some(seen.triangle_at(x, y)).filter(|&triangle| triangle != SeenPixels::NONE)?;
        crate::predicate::hit(&space.ray(x, y), triangles, triangle)
    }

    /// Bytes held for the last frame, without the pixels'.
    #[must_use]
    pub fn bytes(&self) -> usize {
        bytes_of(&self.vertices)
            + bytes_of(&self.masked)
            + self.ranges.iter().map(Range::bytes).sum::<usize>()
            + self.tiles.iter().map(TileCells::bytes).sum::<usize>()
            + self.scratch.len() * size_of::<Samples>()
    }

    /// The image's order of tiles.
    fn order(&self) -> TileOrder {
        let (width, height) = self.space.as_ref().map_or((0, 0), PixelSpace::size);
        TileOrder::new(width, height)
    }
}
