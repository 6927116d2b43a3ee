//! The light grid: which points, seen by a camera or listed by a caller, does a light reach?
//!
//! The light takes the camera's role (Guntury and Narayanan 2010, §4): the points that the camera sees are mapped to the
//! light's perspective, clamped to the extent that they fill there. Unlike in the paper, neither triangles nor points are
//! listed in cells. Triangles come in patches, which are culled as one. Points stay in the image's tiles,
//! and a thread takes a tile from its points to its bits before it takes another. Nothing but these bits leaves the tile.
//! The f32 filter knows its error; undecided cases are settled in f64, and by the [predicate](crate::predicate) where f64
//! can't tell. Points in no image are sorted to tiles first, and these are traced in the same way.
//!
//! `point_set` has the points. One verb a file: `survey` finds the distances of the image's tiles, `choose` chooses the
//! light's faces, `project` projects patches to a face, `points` maps a tile's points to it, `parts` groups points that are
//! near each other for the light, and `trace` goes through a tile: it finds the `candidates` that may shadow a part, searches
//! the `batch` of parts for points in the box of each sixteen of their triangles, has these `set_up` where there are any, and
//! has the `filter` test them. `large_triangles` has those that f32 can't hold; `settle` decides
//! undecided pairs. `cells` gives callers the cell of each point on a face.

mod batch;
mod boxes;
mod candidates;
mod cells;
pub mod choose;
pub mod face;
mod filter;
pub mod large_triangles;
mod parts;
pub mod pixel_map;
pub mod point_set;
pub mod points;
pub mod project;
mod refine;
mod set_up;
pub mod settle;
mod settle_eight;
pub mod survey;
mod trace;
mod validate;
mod worker;

use std::sync::Mutex;

use crate::dispatch;
use crate::parallel::Parallel;
use rayon::prelude::*;
use web_time::Instant;

use crate::LightSource;
use crate::patches::Patches;
use crate::shot::{Bytes, Cone, Counts, LightMask, OpacityOfSides, Seconds, SeenImage, TileOrder, Work};
use crate::simd::SimdLevel;
pub use cells::{LightCell, LightCells, LightFace};
use face::Face;
pub(crate) use point_set::PointList;
use point_set::PointSet;
use points::TILE_BLOCKS;
use project::FacePatches;
use settle::Settler;
use survey::{Survey, SurveyedTile};
use trace::Tracer;
use worker::{ShadowWorker, share_evenly};

/// Finds the seen points that a light reaches; rebuilt for every frame and light.
///
/// The projected patches take about 12 bytes a triangle, each thread's tile a fifth to a half of a megabyte, for any image
/// size. Keep it and use it again: its memory is reused.
#[derive(Default)]
pub struct LightGrid {
    level: SimdLevel,
    survey: Survey,
    faces: Vec<Face>,
    on_face: FacePatches,
    workers: Vec<ShadowWorker>,
    /// For each worker, the range of tiles that no worker has begun: the first, and one more than the last.
    shares: Vec<Mutex<[usize; 2]>>,
    outliers: Vec<u32>,
    counts: Counts,
    seconds: Seconds,
}

debug_some!(LightGrid as grid: "counts" => grid.counts);

impl LightGrid {
    /// An empty grid that uses the instructions of `level`.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Projects the patches to each face of a light and calls `visit` with the face; returns false if the light is none at
    /// all.
    ///
    /// # Panics
    /// If `survey` wasn't called for these pixels.
    fn visit_faces(
        &mut self,
        patches: &Patches,
        settler: &Settler<'_>,
        tiles: &[SurveyedTile],
        mut visit: impl FnMut(&mut Self, &Face),
    ) -> bool {
        let Settler { points, light, .. } = settler;
        assert!(tiles.len() * TileOrder::TILE_PIXELS == points.own().len(), "another image was surveyed");
        self.counts = Counts::default();
        self.seconds = Seconds::default();
        self.outliers.clear();
        let mut faces = std::mem::take(&mut self.faces);
        let is_light = choose::choose(light, points.along(), tiles, &mut faces).is_some();
        for face in &mut faces {
            let start = Instant::now();
            face.choose_point_error(points, tiles);
            let farthest = face.farthest(tiles);
            self.on_face.project(face, farthest, patches, settler);
            self.seconds.project += start.elapsed().as_secs_f64();
            visit(self, face);
        }
        self.counts.faces = faces.len() as u64;
        self.faces = faces;
        is_light
    }

    /// Marks tiles outside every face of the spot's cone as shadowed, so they are never tested.
    fn leave_out(&self, tiles: &[SurveyedTile], shadowed: &mut [u16]) {
        let is_on_none = |tile: &SurveyedTile| !self.faces.iter().any(|face| face.may_own(tile));
        let tiles = tiles.iter().zip(shadowed.chunks_exact_mut(TILE_BLOCKS));
        for (_, blocks) in tiles.filter(|(tile, _)| !tile.has_unknown && is_on_none(tile)) {
            blocks.fill(u16::MAX);
        }
    }

    /// Finds which listed points are in the shadow of a light, on `threads` threads: a word for each block. A point outside
    /// of a spot's cone may be in either state.
    ///
    /// # Panics
    /// If `patches` are of another number of triangles.
    pub(crate) fn shadow_list(
        &mut self,
        opacity: OpacityOfSides<'_>,
        patches: &Patches,
        list: &PointList,
        (light, threads): (&LightSource, usize),
        shadowed: &mut Vec<u16>,
    ) {
        shadowed.clear();
        shadowed.resize(list.slots() / TileOrder::BLOCK_PIXELS, 0);
        patches.expect(opacity.triangles);
        let settler = Settler { points: PointSet::Listed(list), light, opacity, level: self.level };
        let tiles = (&*list.tiles, threads);
        self.visit_faces(patches, &settler, tiles.0, |grid, face| {
            grid.trace(face, tiles, patches, &settler, shadowed);
        });
        let mut outliers = std::mem::take(&mut self.outliers);
        settler.settle_outliers(&mut outliers, shadowed);
        self.outliers = outliers;
    }

    /// Finds which points of a face are in shadow, on `threads` threads: a word for each block.
    fn trace(
        &mut self,
        face: &Face,
        (tiles, threads): (&[SurveyedTile], usize),
        patches: &Patches,
        settler: &Settler<'_>,
        shadowed: &mut [u16],
    ) {
        let start = Instant::now();
        let Self { on_face, workers, shares, outliers, counts, .. } = self;
        workers.resize_with(threads, ShadowWorker::default);
        share_evenly(workers);
        shares.clear();
        shares.extend((0..threads).map(|worker| Mutex::new([worker, worker + 1].map(|of| of * tiles.len() / threads))));
        let tracer = Tracer::new(face, patches, on_face, settler);
        workers.par_iter_mut().with_max_len(1).enumerate().each(|(number, worker)| {
            worker.start();
            while let Some(tile) = next_tile(shares, number) {
                if face.may_own(&tiles[tile]) {
                    dispatch!(settler.level, simd => tracer.trace(simd, worker, tile));
                    worker.keep(tile);
                }
            }
        });
        for worker in workers {
            outliers.extend_from_slice(&worker.outliers);
            *counts += worker.counts;
            for (tile, found) in worker.found() {
                let of_tile = &mut shadowed[tile * TILE_BLOCKS..(tile + 1) * TILE_BLOCKS];
                of_tile.iter_mut().zip(found).for_each(|(word, found)| *word |= found);
            }
        }
        self.seconds.trace += start.elapsed().as_secs_f64();
    }

    /// Measures the distances of the points, once for all lights.
    pub(crate) fn survey(&mut self, SeenImage { shot, seen }: SeenImage<'_>) {
        self.survey.find(shot, seen, self.level);
    }

    /// Finds which points `light` reaches; after a survey.
    ///
    /// # Panics
    /// If it was built for another number of triangles.
    pub(crate) fn shadow(
        &mut self,
        image: SeenImage<'_>,
        patches: &Patches,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work {
        let SeenImage { shot, seen } = image;
        mask.resize(seen.order());
        let shadowed = mask.blocks_mut();
        shadowed.fill(0);
        patches.expect(shot.triangles);
        let survey = std::mem::take(&mut self.survey);
        let settler = Settler::of_image(image, survey.rays, light, self.level);
        let tiles = (&*survey.tiles, rayon::current_num_threads());
        let is_light = self.visit_faces(patches, &settler, tiles.0, |grid, face| {
            grid.trace(face, tiles, patches, &settler, shadowed);
        });
        self.seconds.survey = survey.seconds;
        if Cone::of(light).is_some() {
            self.leave_out(&survey.tiles, shadowed);
        }
        let start = Instant::now();
        if is_light {
            self.outliers.extend_from_slice(&survey.unknown);
            self.counts.outliers = settler.settle_outliers(&mut self.outliers, shadowed);
        }
        self.survey = survey;
        seen.light_the_rest(shadowed, self.level);
        mask.keep_in_cone(light, shot, seen, self.level);
        self.seconds.settle = start.elapsed().as_secs_f64();
        Work { counts: self.counts, seconds: self.seconds }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> Bytes {
        let workers: usize = self.workers.iter().map(ShadowWorker::bytes).sum();
        Bytes {
            triangles: self.on_face.bytes(),
            points: self.survey.bytes() + workers + self.outliers.capacity() * size_of::<u32>(),
        }
    }

    /// As [`Structure::validate`](crate::Structure::validate), for one light; after a survey.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(crate) fn validate(
        &mut self,
        image: SeenImage<'_>,
        patches: &Patches,
        light: &LightSource,
    ) -> Result<(), String> {
        patches.validate(image.shot.triangles)?;
        validate::validate(self, image, patches, light)
    }
}

/// The next tile for a worker: the first of its own share, or the last of another's.
fn next_tile(shares: &[Mutex<[usize; 2]>], worker: usize) -> Option<usize> {
    (0..shares.len()).find_map(|other| {
        let mut share = shares[(worker + other) % shares.len()].lock().ok()?;
        let [first, end] = *share;
        if first >= end {
            None
        } else if other == 0 {
            share[0] += 1;
            Some(first)
        } else {
            share[1] -= 1;
            Some(end - 1)
        }
    })
}
