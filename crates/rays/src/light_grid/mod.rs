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

use crate::shot::SeenImage;
use crate::simd::SimdLevel;
use block::{Block, BlockErrors};
use cells::Cells;
use face::Face;
pub use locate::{LightCell, LightCells, LightFace};
use map::Slab;
use survey::Survey;
use trace::Worker;

/// What the last [`LightGrid::shadow`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightGridCounts {
    /// Points that were tested, once for each face that they are on or beside.
    pub points: u64,
    /// Of those the ones that were mapped in f64, because their depths weren't exact enough.
    pub refined: u64,
    /// Points that no face of the light could hold, tested against every triangle.
    pub outliers: u64,
    /// Faces of the light that see points.
    pub faces: u64,
    /// Groups of up to 16 points that are near each other.
    pub clusters: u64,
    /// Triangles that were tested, once for each face, in local coordinates.
    pub small_triangles: u64,
    /// Triangles that were tested, once for each face, row by row.
    pub large_triangles: u64,
    /// Tests of a triangle against the bounds of 16 clusters.
    pub cluster_tests: u64,
    /// Tests of a triangle against 16 points.
    pub block_tests: u64,
    /// Pairs of a triangle and a point that the fast test, or a mask asked by it, couldn't decide.
    pub undecided: u64,
    /// Pairs about which the fast test asked the triangle's mask.
    pub masked: u64,
    /// Pairs that the predicate was asked about, because f64 or the mask couldn't decide them.
    pub asked: u64,
}

/// Seconds that each stage of the last [`LightGrid::survey`] and [`LightGrid::shadow`] took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightGridSeconds {
    /// How far away the image's tiles are; once for all lights.
    pub survey: f64,
    /// The light's faces divided into cells, and the points to the faces.
    pub map: f64,
    /// Clusters to cells.
    pub sort: f64,
    /// The vertices to the light's faces.
    pub project: f64,
    /// Triangles against points.
    pub trace: f64,
    /// What the fast test left open, and the bits of all threads.
    pub decide: f64,
}

impl LightGridCounts {
    /// Each count with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 11] {
        let Self { points, refined, outliers, faces, clusters, .. } = *self;
        let Self { small_triangles, large_triangles, cluster_tests, block_tests, .. } = *self;
        let Self { undecided, masked, asked, .. } = *self;
        [
            ("points", points),
            ("refined", refined),
            ("outliers", outliers),
            ("faces", faces),
            ("clusters", clusters),
            ("triangles", small_triangles + large_triangles),
            ("cluster_tests", cluster_tests),
            ("block_tests", block_tests),
            ("undecided", undecided),
            ("masked", masked),
            ("asked", asked),
        ]
    }
}

impl LightGridSeconds {
    /// Each stage with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 6] {
        let Self { survey, map, sort, project, trace, decide } = *self;
        [("survey", survey), ("map", map), ("sort", sort), ("project", project), ("trace", trace), ("decide", decide)]
    }
}

/// Which points that the camera sees a light reaches, rebuilt for every frame and light.
///
/// For each place 12 bytes, for each block of 16 another 12, for each of its clusters and each row of cells that it is in
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
    pub(crate) counts: LightGridCounts,
    pub(crate) seconds: LightGridSeconds,
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

    /// What the last [`LightGrid::shadow`] did.
    #[must_use]
    pub fn counts(&self) -> LightGridCounts {
        self.counts
    }

    /// How long the stages of the last [`LightGrid::survey`] and [`LightGrid::shadow`] took.
    #[must_use]
    pub fn seconds(&self) -> LightGridSeconds {
        self.seconds
    }

    /// Bytes held for triangles: what is left of [`bytes`](Self::bytes) is held for points.
    #[must_use]
    pub fn triangle_bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<[f32; 4]>() + self.huge.capacity() * size_of::<u32>()
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let slabs: usize = self.slabs.iter().map(Slab::bytes).sum();
        let workers: usize = self.workers.iter().map(Worker::bytes).sum();
        self.triangle_bytes()
            + self.survey.bytes()
            + slabs
            + workers
            + self.cells.bytes()
            + self.samples.iter().map(Vec::capacity).sum::<usize>() * size_of::<u32>()
            + self.blocks.capacity() * size_of::<Block>()
            + self.errors.capacity() * size_of::<BlockErrors>()
            + (self.members.capacity() + self.shadowed.capacity()) * size_of::<u16>()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
            + self.outliers.capacity() * size_of::<u32>()
    }
}
