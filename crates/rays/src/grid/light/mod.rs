//! The light grid: which of the points that a camera sees does a light reach?
//!
//! The light takes the camera's role (Guntury and Narayanan 2010, §4): what the camera sees is mapped to the light's
//! perspective, clamped to the rectangle that it fills there, and sorted into the rectangle's cells. Other than in the
//! paper triangles are not listed: each visits the cells that it covers and is tested where it is set up, 16 points at
//! a time. The f32 test knows its error; what it can't decide goes to the [predicate](crate::predicate).
//!
//! One verb a file: `locate` finds the points, `choose` the light's faces, `map` and `sort` bring the points into
//! cells, `project` the vertices to the face, `small` and `large` test triangles against points, `decide` asks the
//! predicate.

mod block;
mod choose;
mod decide;
mod face;
mod lanes;
mod large;
mod locate;
mod map;
mod project;
mod small;
mod sort;
mod trace;
mod validate;

use std::sync::atomic::AtomicU8;

use glam::DVec2;

use crate::grid::{SeenPixels, SimdLevel};
use crate::{Triangles, View};
use block::{Block, Cells};
use face::{Face, Layer};
use locate::Points;
use map::Slab;
use trace::Worker;

/// What a camera sees: the points that a [`LightGrid`] decides about.
#[derive(Clone, Copy, Debug)]
pub struct SeenImage<'a> {
    /// The scene.
    pub triangles: Triangles<'a>,
    /// The camera.
    pub view: View,
    /// Where in each pixel its ray goes through, from (0, 0) for the upper left corner to (1, 1).
    pub offset_pixels: DVec2,
    /// What the ray through each pixel hits.
    pub seen: &'a SeenPixels,
}

/// What the last [`LightGrid::shadow`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightGridCounts {
    /// Points that were sorted into cells.
    pub points: u64,
    /// Points that no face of the light could hold, tested against every triangle.
    pub outliers: u64,
    /// Faces of the light, times the classes of exactness of the points on them.
    pub layers: u64,
    /// Triangles that were tested, once for each layer, in local coordinates.
    pub small_triangles: u64,
    /// Triangles that were tested, once for each layer, row by row.
    pub large_triangles: u64,
    /// Tests of a triangle against 16 points.
    pub block_tests: u64,
    /// Pairs of a triangle and a point that went to the predicate because the fast test couldn't decide them.
    pub undecided: u64,
    /// Pairs that went to the predicate because the triangle isn't opaque.
    pub masked: u64,
}

/// Seconds that each stage of the last [`LightGrid::locate`] and [`LightGrid::shadow`] took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightGridSeconds {
    /// Distances of the points from the camera; once for all lights.
    pub locate: f64,
    /// The points to the light's faces.
    pub map: f64,
    /// The points to cells.
    pub sort: f64,
    /// The vertices to the light's faces.
    pub project: f64,
    /// Triangles against points.
    pub trace: f64,
    /// What the predicate decides, and the bits in pixel order.
    pub decide: f64,
}

/// Which points that the camera sees a light reaches, rebuilt for every frame and light.
///
/// For each pixel 8 bytes of distance, 20 bytes of mapped point, 20 bytes of sorted point and a byte of shadow; for
/// each vertex 16 bytes. Keep it and use it again: its memory is reused.
#[derive(Default)]
pub struct LightGrid {
    level: SimdLevel,
    points: Points,
    faces: Vec<Face>,
    slabs: Vec<Slab>,
    layer: Layer,
    cells: Cells,
    blocks: Vec<Block>,
    vertices: Vec<[f32; 4]>,
    workers: Vec<Worker>,
    huge: Vec<u32>,
    shadowed: Vec<AtomicU8>,
    outliers: Vec<u32>,
    counts: LightGridCounts,
    seconds: LightGridSeconds,
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

    /// How long the stages of the last [`LightGrid::locate`] and [`LightGrid::shadow`] took.
    #[must_use]
    pub fn seconds(&self) -> LightGridSeconds {
        self.seconds
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let slabs: usize = self.slabs.iter().map(Slab::bytes).sum();
        let workers: usize = self.workers.iter().map(Worker::bytes).sum();
        self.points.bytes()
            + slabs
            + workers
            + self.cells.bytes()
            + self.blocks.capacity() * size_of::<Block>()
            + self.vertices.capacity() * size_of::<[f32; 4]>()
            + self.shadowed.capacity()
            + (self.outliers.capacity() + self.huge.capacity()) * size_of::<u32>()
    }
}
