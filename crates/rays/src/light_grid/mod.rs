//! The light grid: which of the points that a camera sees does a light reach?
//!
//! The light takes the camera's role (Guntury and Narayanan 2010, §4): what the camera sees is mapped to the light's
//! perspective, clamped to the rectangle that it fills there. Other than in the paper neither triangles nor single
//! points are listed in cells: the points of 4×4 pixels, which are mostly near each other for the light too, stay
//! together, and only their bounds are sorted. Each triangle looks up the bounds that it overlaps and is tested where it
//! is set up, 16 points at a time. The f32 test knows its error; what it can't decide is tested in f64, and what that
//! can't goes to the [predicate](crate::predicate).
//!
//! One verb a file: `survey` finds how far the image's tiles reach, `choose` the light's faces, `spread` cells over
//! where the points are, `map` brings points to a face, `refine` those that need f64, `sort` brings their bounds into
//! cells, `project` the vertices to the face, `small` and `large` test triangles against points, `settle` and `filter`
//! what they leave open. `locate` says in which cells points are, for whoever wants to see it.

pub(crate) mod block;
pub(crate) mod cells;
pub(crate) mod choose;
pub(crate) mod face;
mod filter;
pub(crate) mod large;
mod locate;
mod map;
mod pixel_map;
mod project;
mod queue;
mod refine;
pub(crate) mod settle;
pub(crate) mod small;
mod sort;
mod spread;
mod survey;
pub(crate) mod trace;
mod validate;

use crate::LightSource;
use crate::grids::LightsGrid;
use crate::shot::{Bytes, Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, Work};
use crate::simd::SimdLevel;
use block::{Block, BlockErrors};
use cells::Cells;
use face::Face;
pub use locate::{LightCell, LightCells, LightFace};
use map::Slab;
use survey::Survey;
use trace::Worker;

/// Which points that the camera sees a light reaches, rebuilt for every frame and light.
///
/// For each pixel 12 bytes, for each block of 16 another 12, for each of its clusters and each row of cells that it is in
/// 52, mostly once; for each vertex 16 bytes. Keep it and use it again: its memory is reused.
#[derive(Default)]
pub struct LightGrid {
    pub(crate) level: SimdLevel,
    pub(crate) survey: Survey,
    pub(crate) faces: Vec<Face>,
    /// The face that the rest is about.
    pub(crate) face: Face,
    pub(crate) slabs: Vec<Slab>,
    pub(crate) cells: Cells,
    /// How many of some points are in each strip of the axes.
    pub(crate) samples: [Vec<u32>; 2],
    pub(crate) blocks: Vec<Block>,
    pub(crate) errors: Vec<BlockErrors>,
    /// Which places of each block show a point of the face.
    pub(crate) members: Vec<u16>,
    pub(crate) vertices: Vec<[f32; 4]>,
    pub(crate) workers: Vec<Worker>,
    pub(crate) huge: Vec<u32>,
    pub(crate) undecided: Vec<[u32; 2]>,
    /// For each block which points are in shadow, as far as is known.
    pub(crate) shadowed: Vec<u16>,
    pub(crate) outliers: Vec<u32>,
    pub(crate) counts: Counts,
    pub(crate) seconds: Seconds,
}

impl std::fmt::Debug for LightGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LightGrid").field("blocks", &self.blocks.len()).field("counts", &self.counts).finish()
    }
}

impl LightGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }
}

impl LightsGrid for LightGrid {
    fn survey(&mut self, shot: &Shot<'_>, seen: &SeenPixels) {
        Self::survey(self, shot, seen);
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) -> Work {
        Self::shadow(self, shot, seen, light, mask);
        Work { counts: self.counts, seconds: self.seconds }
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        Self::locate(self, shot, seen, light, cells);
    }

    fn bytes(&self) -> Bytes {
        let triangles = self.vertices.capacity() * size_of::<[f32; 4]>() + self.huge.capacity() * size_of::<u32>();
        let slabs: usize = self.slabs.iter().map(Slab::bytes).sum();
        let workers: usize = self.workers.iter().map(Worker::bytes).sum();
        let points = self.survey.bytes()
            + slabs
            + workers
            + self.cells.bytes()
            + self.samples.iter().map(Vec::capacity).sum::<usize>() * size_of::<u32>()
            + self.blocks.capacity() * size_of::<Block>()
            + self.errors.capacity() * size_of::<BlockErrors>()
            + (self.members.capacity() + self.shadowed.capacity()) * size_of::<u16>()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
            + self.outliers.capacity() * size_of::<u32>();
        Bytes { triangles, points }
    }

    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource) -> Result<(), String> {
        Self::validate(self, shot, seen, light)
    }
}
