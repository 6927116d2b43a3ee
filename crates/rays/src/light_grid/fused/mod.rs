//! (draft)
mod boxes;
mod large;
mod parts;
mod points;
mod project;
mod set_up;
mod trace;

use std::sync::Mutex;
use std::time::Instant;

use fearless_simd::dispatch;
use rayon::prelude::*;

use crate::LightSource;
use crate::light_grid::choose;
use crate::light_grid::face::{Face, VertexErrors};
use crate::light_grid::pixel_map::PixelMap;
use crate::light_grid::settle::Settler;
use crate::light_grid::survey::Survey;
use crate::predicate::settle;
use crate::patches::Patches;
use crate::shot::{Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, TileOrder, Work};
use crate::simd::SimdLevel;
use points::TILE_BLOCKS;
use project::FacePatches;
use trace::{Tracer, Worker};

/// Which points that the camera sees a light reaches.
#[derive(Debug, Default)]
pub(crate) struct Fused {
    level: SimdLevel,
    faces: Vec<Face>,
    on_face: FacePatches,
    workers: Vec<Worker>,
    /// For each worker the tiles that nobody has begun: the first, and the last but one.
    shares: Vec<Mutex<[usize; 2]>>,
    outliers: Vec<u32>,
    pub(crate) counts: Counts,
    pub(crate) seconds: Seconds,
}

impl Fused {
    pub(crate) fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    pub(crate) fn shadow(
        &mut self,
        survey: &Survey,
        patches: &Patches,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
    ) -> Work {
        assert!(survey.slots == seen.triangle.len(), "another image was surveyed");
        self.counts = Counts::default();
        self.seconds = Seconds::default();
        self.outliers.clear();
        mask.resize(seen.order());
        let shadowed = mask.blocks_mut();
        shadowed.fill(0);
        let settler = Settler { image: SeenImage { shot, seen }, rays: survey.rays, light, level: self.level };
        let mut faces = std::mem::take(&mut self.faces);
        let is_light = choose::choose(light, &survey.rays, &survey.tiles, &mut faces).is_some();
        for face in &mut faces {
            face.choose_point_error(&survey.rays, &survey.tiles);
            let start = Instant::now();
            let farthest = face.farthest(&survey.tiles);
            self.on_face.project(face, farthest, patches, shot.triangles, self.level);
            let projected = Instant::now();
            self.seconds.project += (projected - start).as_secs_f64();
            self.trace(face, survey, patches, &settler, shadowed);
            self.seconds.trace += projected.elapsed().as_secs_f64();
        }
        let start = Instant::now();
        self.counts.faces = faces.len() as u64;
        self.faces = faces;
        if is_light {
            self.outliers.extend_from_slice(&survey.unknown);
            self.counts.outliers = settle_outliers(&mut self.outliers, shot, seen, light, shadowed);
        }
        shadowed.iter_mut().zip(seen.shown()).for_each(|(word, shown)| *word = shown & !*word);
        self.seconds.settle = start.elapsed().as_secs_f64();
        Work { counts: self.counts, seconds: self.seconds }
    }

    /// Finds which of the points of a face are in shadow.
    fn trace(
        &mut self,
        face: &Face,
        survey: &Survey,
        patches: &Patches,
        settler: &Settler<'_>,
        shadowed: &mut [u16],
    ) {
        let Self { on_face, workers, shares, outliers, counts, .. } = self;
        let threads = rayon::current_num_threads();
        workers.resize_with(threads, Worker::default);
        let tiles = &survey.tiles;
        shares.clear();
        shares.extend((0..threads).map(|worker| Mutex::new([worker, worker + 1].map(|of| of * tiles.len() / threads))));
        let tracer = Tracer {
            face,
            vertex_errors: VertexErrors::new(face),
            pixels: PixelMap::new(face, &survey.rays),
            patches,
            on_face,
            settler,
            average: 4.0 / (survey.slots / TileOrder::BLOCK_PIXELS).max(1) as f32,
        };
        let level = settler.level.0;
        workers.par_iter_mut().with_max_len(1).enumerate().for_each(|(number, worker)| {
            worker.start();
            while let Some(tile) = next_tile(shares, number) {
                if face.may_own(&tiles[tile]) {
                    dispatch!(level, simd => tracer.trace(simd, worker, tile));
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

/// Tests the points that no face could map against every triangle; how many there are.
fn settle_outliers(
    outliers: &mut Vec<u32>,
    shot: &Shot<'_>,
    seen: &SeenPixels,
    light: &LightSource,
    shadowed: &mut [u16],
) -> u64 {
    outliers.sort_unstable();
    outliers.dedup();
    let count = shot.triangles.len() as u32;
    for index in outliers.iter().map(|&index| index as usize) {
        let Some(ray) = shot.shadow_ray(seen, index, light) else { continue };
        let own = seen.triangle[index];
        let triangles = (0..count).into_par_iter().with_min_len(1024);
        if triangles.filter(|&id| id != own).any(|id| settle::is_blocked(shot, &ray, id)) {
            shadowed[index / TileOrder::BLOCK_PIXELS] |= 1 << (index % TileOrder::BLOCK_PIXELS);
        }
    }
    outliers.len() as u64
}
