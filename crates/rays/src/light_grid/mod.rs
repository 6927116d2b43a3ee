//! The light grid: which of the points that a camera sees does a light reach?
//!
//! The light takes the camera's role (Guntury and Narayanan 2010, §4): what the camera sees is mapped to the light's
//! perspective, clamped to the extent that it fills there. Unlike in the paper, neither triangles nor single points are
//! listed in cells. The points of 4×4 pixels, which are mostly near each other for the light too, stay together as a block,
//! and only the blocks' bounds are sorted. Each triangle looks up the bounds that it overlaps and is tested as soon as it
//! is set up, 16 points at a time. The f32 filter knows its error; what it leaves undecided is settled in f64, and what
//! f64 can't tell by the [predicate](crate::predicate).
//!
//! One verb a file: `survey` finds how far away the image's tiles are, `choose` chooses the light's faces, `spread` spreads
//! cells over where the points are, `map` brings points to a face, `refine` those that need f64, `sort` brings their bounds
//! into cells, `project` the vertices to the face, `trace` tests triangles against points (`small` those that cover few
//! cells, `large` the others), `settle` decides what these leave undecided. `pass` goes through these steps. `locate` says
//! in which cells points are, for whoever wants to see it.

pub(crate) mod block;
pub(crate) mod cells;
pub(crate) mod choose;
pub(crate) mod face;
mod fused;
pub(crate) mod large;
mod locate;
mod map;
pub(crate) mod pass;
pub(crate) mod pixel_map;
pub(crate) mod project;
mod queue;
pub(crate) mod refine;
pub(crate) mod settle;
mod settle_eight;
pub(crate) mod small;
mod sort;
mod spread;
pub(crate) mod survey;
mod trace;
mod validate;
pub(crate) mod worker;

use std::time::Instant;

pub static MODE: std::sync::atomic::AtomicU8 = std::sync::atomic::AtomicU8::new(0);

use crate::LightSource;
use crate::grids::LightsGrid;
use crate::shot::{Bytes, LightMask, SeenPixels, Shot, Work};
use crate::simd::SimdLevel;
pub use locate::{LightCell, LightCells, LightFace};
use pass::LightPass;

/// Which points that the camera sees a light reaches, rebuilt for every frame and light.
///
/// For each pixel 12 bytes, for each block of 16 another 12, for each of its clusters and each row of cells that it is in
/// 52, mostly once; for each vertex 16 bytes. Keep it and use it again: its memory is reused.
#[derive(Default)]
pub struct LightGrid {
    pass: LightPass,
    fused: fused::Fused,
    patches: crate::patches::Patches,
    /// Triangles that cover much of the face.
    huge: Vec<u32>,
}

debug_some!(LightGrid as grid: "counts" => grid.pass.counts);

impl LightGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { pass: LightPass::new(level), fused: fused::Fused::with_level(level), ..Self::default() }
    }
}

impl LightsGrid for LightGrid {
    fn survey(&mut self, shot: &Shot<'_>, seen: &SeenPixels) {
        self.pass.survey(shot, seen);
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) -> Work {
        let Self { pass, huge, fused, patches } = self;
        let mode = MODE.load(std::sync::atomic::Ordering::Relaxed);
        if mode != 1 {
            let start = Instant::now();
            patches.update(shot.triangles, pass.level);
            let map = start.elapsed().as_secs_f64();
            let mut work = fused.shadow(&pass.survey, patches, shot, seen, light, mask);
            work.seconds.map = map;
            if mode == 0 {
                return work;
            }
        }
        let found = mask.clone();
        let work = pass.shadow(shot, seen, light, mask, |pass, settler| {
            let start = Instant::now();
            pass.sort_clusters();
            pass.counts.clusters += pass.cells.rows().iter().map(|row| row.len() as u64).sum::<u64>();
            let sorted = Instant::now();
            trace::test_triangles(pass, huge, settler);
            pass.seconds.sort += (sorted - start).as_secs_f64();
            pass.seconds.trace += sorted.elapsed().as_secs_f64();
        });
        if mode == 2 {
            let (mut lit, mut dark) = (0, 0);
            for (old, new) in mask.blocks().iter().zip(found.blocks()) {
                lit += (new & !old).count_ones();
                dark += (old & !new).count_ones();
            }
            eprintln!("wrongly lit {lit}, wrongly dark {dark}");
        }
        work
    }

    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells) {
        self.pass.locate(shot, seen, light, cells, LightPass::add_located);
    }

    fn bytes(&self) -> Bytes {
        let Bytes { triangles, points } = self.pass.bytes();
        Bytes { triangles: triangles + self.huge.capacity() * size_of::<u32>(), points }
    }

    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource) -> Result<(), String> {
        validate::validate(&mut self.pass, shot, seen, light)
    }
}
