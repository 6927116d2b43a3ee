//! The perspective grid: camera rays (Guntury and Narayanan 2010, §3).
//!
//! The direct form: vertices are projected to pixel space once. Triangles of at most 2×2 samples are tested during setup,
//! and leave fragments in tiles of 64×64 samples. Larger ones are listed in the tiles, by a coarse rasterization where they
//! may overlap many, and tested there against blocks of 4×4 samples. A filter in f32 with a certified error bound decides
//! nearly all samples, and the [predicate](crate::predicate) settles the rest, so that the answer is its own.

pub mod bins;
pub(crate) mod build;
mod cull;
mod depth_order;
pub mod homogeneous;
pub mod lanes;
mod list_large;
pub mod pixel_space;
pub mod samples;
mod small_patches;
pub mod tile;
pub mod trace;
mod two_by_two;
mod validate;

use std::sync::Mutex;

use crate::View;
use crate::shot::TileOrder;
use crate::simd::SimdLevel;
use bins::{Bin, Bins, bytes_of};
use cull::PixelBox;
use pixel_space::{PixelSpace, Vertex};
use tile::TileHits;

/// The triangles of a frame, sorted into screen tiles for one ray through each pixel.
///
/// 16 bytes a vertex of a patch. Eight bytes for each pair of a tile and a patch, or for large patches a triangle; 16 for
/// each sample that a tiny triangle of a large patch hits; and 144 for each pair of a tile and a range of patches. Keep it
/// and rebuild it: its memory is reused.
#[derive(Default)]
pub struct PerspectiveGrid {
    level: SimdLevel,
    /// `None` before the first build.
    space: Option<PixelSpace>,
    triangle_count: usize,
    /// Vertices of the patches whose triangles are listed one by one, in the patches' order.
    vertices: Vec<Vertex>,
    /// The pixels of the patches that are listed whole.
    boxes: Vec<PixelBox>,
    /// Ranges of patches, in their order.
    ranges: Vec<Bins>,
    /// A tile for each thread.
    scratch: Vec<Mutex<Box<TileHits>>>,
}

debug_some!(PerspectiveGrid as grid: "triangles" => grid.triangle_count);

/// The error for an image with a side too long for the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an image of {width} × {height} pixels has a side above {} pixels", Self::LARGEST_SIDE)]
pub struct ImageTooLarge {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
}

impl ImageTooLarge {
    /// The largest side in pixels.
    pub const LARGEST_SIDE: u32 = 1 << 16;

    pub fn check(view: &View) -> Result<(), Self> {
        let &View { width, height, .. } = view;
        if width.max(height) > Self::LARGEST_SIDE { Err(Self { width, height }) } else { Ok(()) }
    }
}

impl PerspectiveGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// The image's order of tiles.
    pub(crate) fn order(&self) -> TileOrder {
        let (width, height) = self.space.as_ref().map_or((0, 0), PixelSpace::size);
        TileOrder::new(width, height)
    }

    /// Columns and rows of tiles.
    fn tiles(&self) -> (u32, u32) {
        self.order().tiles()
    }

    /// Bytes held for the last frame, without the pixels.
    pub(crate) fn bytes(&self) -> usize {
        let bins = self.ranges.iter().flat_map(|range| &range.bins);
        bytes_of(&self.vertices)
            + bytes_of(&self.boxes)
            + bins.map(|bin| size_of::<Bin>() + bin.bytes()).sum::<usize>()
            + self.scratch.len() * size_of::<TileHits>()
    }
}
