//! The uniform grid: cubic cells for all rays, rebuilt for every frame (Wald et al., *Ray Tracing Animated Scenes using
//! Coherent Grid Traversal*, 2006).
//!
//! `lattice` has the layout of cells and the proof that no hit is missed, `build` lists triangles in cells, `macrocells`
//! marks empty regions, `trace` follows single rays. `slices` leads packets of rays through the cells, and `frustum` rules
//! out triangles beside them; `see` traces those of a camera and `shadow` those of a light, in groups of a `bundle`. Cells
//! may hold grids of their own, which are `nested`; both traversals see one grid as its `cells`.

#[cfg(feature = "experiments")]
pub mod any_rays;
mod build;
mod bundle;
mod cells;
mod frustum;
mod lattice;
mod macrocells;
mod nested;
mod overlap;
mod see;
mod shadow;
mod slices;
mod trace;
mod validate;

use std::sync::Mutex;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use crate::statistics::Tally;
use build::Chunk;
pub use bundle::PacketSide;
use bundle::PacketWorker;
use lattice::{CellBox, Lattice, VertexCells};
use macrocells::Macrocells;
use nested::Nested;
use umbrage_rays::shot::{Bytes, Counts, LightMask, Seconds, SeenPixels, Shot, Work};
use umbrage_rays::{Bounds, ImageTooLarge, LightSource, Omitted, SimdLevel, SingleRays, Structure, Triangles};
use umbrage_rays::{choices, debug_some};

/// The insertion of triangles into cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Insertion {
    /// Into each cell that their bounding box overlaps: the faster way overall, according to the paper.
    #[default]
    Boxes,
    /// Into each cell that the triangle itself overlaps: fewer references, and more work for each.
    Exact,
}

choices! { Insertion, "insertion":
    "boxes" => Boxes, "into each cell that a triangle's bounding box overlaps";
    "exact" => Exact, "into each cell that the triangle itself overlaps";
}

/// The options of a [`UniformGrid`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformOptions {
    /// Cells per triangle: λ of the paper's §3.
    pub cells_per_triangle: f64,
    /// Cells along an edge of a macrocell: M of the paper's §2.4. 1 disables macrocells.
    pub macrocell: u32,
    /// Insertion of triangles into cells (§3).
    pub insertion: Insertion,
    /// Number of rays traced together.
    pub packet: PacketSide,
    /// Cells that list more triangles than this hold grids of their own where that pays, and so may those grids' cells: for
    /// scenes of very uneven density. `None` disables such grids.
    pub nested_above: Option<u32>,
    /// The largest relative difference of inverse distances from the camera among points whose shadow rays are traced
    /// together (§4.6): packets are split at silhouettes.
    ///
    /// From 1/50 to 1/16 is about the best in all scenes of the gallery: 1/4 takes 1.3 times as long in `demo:cloth` and 2.4
    /// times in `demo:shatter`, 1 up to eleven times.
    pub shadow_spread: f32,
}

impl UniformOptions {
    /// The paper's options, with larger packets.
    pub const DEFAULT: Self = Self {
        cells_per_triangle: 6.0,
        macrocell: 6,
        insertion: Insertion::Boxes,
        packet: PacketSide::ThirtyTwo,
        nested_above: None,
        shadow_spread: 0.05,
    };

    /// The default options, with grids inside of crowded cells.
    ///
    /// Of 16 to 256 triangles, 64 was about the best for balls of 100,000 triangles in rooms of 1000 times their size: on
    /// two busy cores packets of 512² rays to such a ball took 40 ms instead of 7800 ms, single rays 3.8 µs instead of 6500
    /// µs and builds 47 ms instead of 10 ms, with 146 bytes a triangle instead of 51. Scenes of even density have no such
    /// cells.
    pub const NESTED: Self = Self { nested_above: Some(64), ..Self::DEFAULT };

    /// The largest number of cells along an edge of a macrocell.
    pub const LARGEST_MACROCELL: u32 = 64;
}

impl UniformOptions {
    /// Checks that a grid can have these options.
    ///
    /// # Errors
    /// If λ or the spread isn't positive and finite, if macrocells don't have 1 to 64 cells along an edge, or if cells with
    /// a single triangle should hold grids.
    pub fn check(self) -> Result<(), ImpossibleUniformOptions> {
        let Self { cells_per_triangle, macrocell, nested_above, shadow_spread, .. } = self;
        let is_positive = |number: f64| number > 0.0 && number.is_finite();
        let is_possible = is_positive(cells_per_triangle)
            && is_positive(shadow_spread.into())
            && (1..=Self::LARGEST_MACROCELL).contains(&macrocell)
            && nested_above != Some(0);
        if is_possible { Ok(()) } else { Err(ImpossibleUniformOptions(self)) }
    }
}

impl Default for UniformOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Options that no uniform grid can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a uniform grid can't have {} cells a triangle, macrocells of {}³ cells and shadow packets of spread {}{}",
    .0.cells_per_triangle, .0.macrocell, .0.shadow_spread,
    .0.nested_above.map_or(String::new(), |above| format!(", and grids inside of cells of more than {above} triangles"))
)]
pub struct ImpossibleUniformOptions(pub UniformOptions);

/// The triangles of a frame, listed in cubic cells.
///
/// With λ = 6, it holds about 24 bytes of cells per triangle, and during the build 12 more, plus 8 for each shared vertex.
/// Each reference takes four bytes; there are at most [`UniformGrid::MOST_REFERENCES`] a triangle. Grids inside of cells may
/// take as much again for references and about twice as much for cells, plus 12 bytes for each reference of a crowded cell
/// during their build. Keep it and rebuild it: its memory is reused.
#[derive(Default)]
pub struct UniformGrid {
    level: SimdLevel,
    options: UniformOptions,
    /// `None` before the first build.
    lattice: Option<Lattice>,
    triangle_count: usize,
    /// The start of each cell's ids, and finally the end of the last cell's; a zero from counting follows.
    starts: Vec<AtomicU32>,
    /// The number of references before each thread's part of the cells.
    sums: Vec<u32>,
    /// Triangle ids, cell after cell, ascending in each.
    ids: Vec<AtomicU32>,
    macrocells: Macrocells,
    nested: Nested,
    /// The cells of each triangle, in order of ids.
    boxes: Vec<CellBox>,
    /// The cells of each vertex; empty where triangles don't share many.
    vertices: Vec<VertexCells>,
    chunks: Vec<Chunk>,
    bounds: Bounds,
    omitted: Omitted,
    /// The work of single rays.
    visits: Tally,
    /// Memory for each thread.
    workers: Vec<Mutex<Box<PacketWorker>>>,
}

debug_some!(
    UniformGrid as grid:
    "triangles" => grid.triangle_count,
    "cells" => grid.cells(),
    "references" => grid.references(),
    "nested_grids" => grid.nested_grids()
);

impl UniformGrid {
    /// The layout of the cells; `None` before the first build.
    #[doc(hidden)]
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        self.lattice
    }

    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Sets the options, from the next build on.
    ///
    /// # Errors
    /// As [`UniformOptions::check`].
    pub fn set_options(&mut self, options: UniformOptions) -> Result<(), ImpossibleUniformOptions> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Cells along x, y and z; zeros before the first build.
    #[must_use]
    pub fn cells(&self) -> [u32; 3] {
        self.lattice.map_or([0; 3], |lattice| lattice.cells.to_array())
    }

    /// The number of references to triangles in all cells, without grids inside of cells.
    #[must_use]
    pub fn references(&self) -> usize {
        self.ids.len()
    }

    /// The number of grids inside of cells, at any depth.
    #[must_use]
    pub fn nested_grids(&self) -> usize {
        self.nested.len()
    }

    /// The number of references to triangles in the grids inside of cells.
    #[must_use]
    pub fn nested_references(&self) -> usize {
        self.nested.references()
    }

    /// Returns the work of single rays since the last call and resets it. All zeros without the feature `statistics`.
    #[must_use]
    pub fn take_visits(&self) -> Counts {
        self.visits.take()
    }

    /// Whether two grids list the same triangles in the same cells, in the same order.
    #[must_use]
    pub fn is_same_as(&self, other: &Self) -> bool {
        let same =
            |a: &[AtomicU32], b: &[AtomicU32]| a.iter().map(|a| a.load(Relaxed)).eq(b.iter().map(|b| b.load(Relaxed)));
        self.lattice == other.lattice
            && same(&self.starts, &other.starts)
            && same(&self.ids, &other.ids)
            && self.nested.is_same_as(&other.nested)
    }
}

impl Structure for UniformGrid {
    fn build(&mut self, triangles: Triangles<'_>) {
        Self::build(self, triangles);
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        Ok(Work { counts: Self::see(self, shot, seen), seconds: Seconds::default() })
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        shot.expect_masks(seen, lights, masks);
        let mut counts = Counts::default();
        for (light, mask) in lights.iter().zip(masks) {
            counts += Self::shadow(self, shot, seen, light, mask);
            mask.keep_in_cone(light, shot, seen, self.level);
        }
        Work { counts, seconds: Seconds::default() }
    }

    fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    fn bytes(&self) -> Bytes {
        let triangles = (self.starts.capacity() + self.ids.capacity()) * size_of::<AtomicU32>()
            + self.macrocells.bytes()
            + self.nested.bytes()
            + self.boxes.capacity() * size_of::<CellBox>()
            + self.vertices.capacity() * size_of::<VertexCells>()
            + self.chunks.capacity() * size_of::<Chunk>()
            + self.sums.capacity() * size_of::<u32>()
            + self.workers.iter().map(worker_bytes).sum::<usize>();
        Bytes { triangles, points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        self.check(shot.triangles)
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}

fn worker_bytes(worker: &Mutex<Box<PacketWorker>>) -> usize {
    worker.lock().unwrap_or_else(std::sync::PoisonError::into_inner).bytes()
}
