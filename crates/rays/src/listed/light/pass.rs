use std::sync::Mutex;
use std::time::Instant;

use fearless_simd::dispatch;
use rayon::prelude::*;

use super::worker::Worker;
use crate::LightSource;
use crate::light_grid::block::{Block, BlockErrors};
use crate::light_grid::choose;
use crate::light_grid::face::Face;
use crate::light_grid::pixel_map::PixelMap;
use crate::light_grid::points::{GROUPS, TILE_BLOCKS, TileMap, block_of};
use crate::light_grid::settle::{Settler, settle_outliers};
use crate::light_grid::survey::Survey;
use crate::shot::{Bytes, Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, TileOrder, Work};
use crate::simd::SimdLevel;
use crate::simd::vectors::LANES;

/// One light's way from what a camera sees to a mask: everything but how triangles find the points that they shadow.
#[derive(Default)]
pub(crate) struct LightPass {
    pub(crate) level: SimdLevel,
    pub(crate) survey: Survey,
    faces: Vec<Face>,
    /// The face that the rest is about.
    pub(crate) face: Face,
    pub(crate) blocks: Vec<Block>,
    pub(crate) errors: Vec<BlockErrors>,
    /// Which lanes of each block hold a point of the face.
    pub(crate) members: Vec<u16>,
    pub(crate) vertices: Vec<[f32; 4]>,
    pub(crate) workers: Vec<Worker>,
    pub(crate) undecided: Vec<[u32; 2]>,
    /// For each block which points are in shadow, as far as is known.
    pub(crate) shadowed: Vec<u16>,
    pub(crate) outliers: Vec<u32>,
    pub(crate) counts: Counts,
    pub(crate) seconds: Seconds,
}

impl LightPass {
    pub(crate) fn new(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Finds which of the points that the pixels of `shot` have `seen` are lit by `light`. `trace` tests all triangles
    /// against the points of a face whose vertices are projected.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn shadow(
        &mut self,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        mask: &mut LightMask,
        mut trace: impl FnMut(&mut Self, &Settler<'_>),
    ) -> Work {
        mask.resize(seen.order());
        self.shadowed.clear();
        self.shadowed.resize(seen.triangle.len() / TileOrder::BLOCK_PIXELS, 0);
        let is_light = self.visit_faces(shot, seen, light, |pass, settler| {
            let points: u64 = pass.members.iter().map(|members| u64::from(members.count_ones())).sum();
            if points == 0 {
                return;
            }
            pass.counts.points += points;
            pass.counts.faces += 1;
            let start = Instant::now();
            pass.project(shot.triangles.positions);
            pass.seconds.project += start.elapsed().as_secs_f64();
            trace(pass, settler);
            let start = Instant::now();
            pass.settle(settler);
            pass.merge_shadows();
            pass.seconds.settle += start.elapsed().as_secs_f64();
        });
        if is_light {
            self.outliers.extend_from_slice(&self.survey.unknown);
            self.counts.outliers = settle_outliers(&mut self.outliers, shot, seen, light, &mut self.shadowed);
        }
        let lit = mask.blocks_mut();
        lit.copy_from_slice(&self.shadowed);
        seen.light_the_rest(lit, self.level);
        mask.keep_in_cone(light, shot, seen, self.level);
        Work { counts: self.counts, seconds: self.seconds }
    }

    /// Maps the points of each face of `light`, and calls `visit`; whether the light is one at all.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn visit_faces(
        &mut self,
        shot: &Shot<'_>,
        seen: &SeenPixels,
        light: &LightSource,
        mut visit: impl FnMut(&mut Self, &Settler<'_>),
    ) -> bool {
        assert!(self.survey.slots == seen.triangle.len(), "another image was surveyed");
        self.counts = Counts::default();
        self.seconds = Seconds { survey: self.survey.seconds, ..Seconds::default() };
        self.outliers.clear();
        let image = SeenImage { shot, seen };
        let settler = Settler::new(image, self.survey.rays, light, self.level);
        let mut faces = std::mem::take(&mut self.faces);
        let is_light = choose::choose(light, &self.survey.rays, &self.survey.tiles, &mut faces).is_some();
        for face in &faces {
            let start = Instant::now();
            self.face = *face;
            self.face.choose_point_error(&self.survey.rays, &self.survey.tiles);
            self.map(&image);
            self.seconds.map += start.elapsed().as_secs_f64();
            visit(self, &settler);
        }
        self.faces = faces;
        is_light
    }

    /// Maps all points of `self.face`.
    fn map(&mut self, image: &SeenImage<'_>) {
        let Self { survey, face, blocks, errors, members, outliers, counts, level, .. } = self;
        blocks.resize(survey.slots / LANES, Block::EMPTY);
        errors.resize(blocks.len(), BlockErrors::default());
        members.resize(blocks.len(), 0);
        members.fill(0);
        let pixels = PixelMap::new(face, &survey.rays);
        let (level, rays, tiles, face) = (level.0, &survey.rays, &survey.tiles, &*face);
        let outliers = Mutex::new(outliers);
        let outputs = blocks
            .par_chunks_exact_mut(TILE_BLOCKS)
            .zip(errors.par_chunks_exact_mut(TILE_BLOCKS))
            .zip(members.par_chunks_exact_mut(TILE_BLOCKS));
        let refined = outputs.enumerate().map(|(number, ((blocks, errors), members))| {
            let (mut lost, mut refined) = (Vec::new(), 0);
            let Some(blocks) = blocks.first_chunk_mut() else { return 0 };
            if face.may_own(&tiles[number]) {
                let map = TileMap::new(image, rays, face, &pixels, number, [0.0; 3]);
                for number in 0..GROUPS {
                    let group =
                        dispatch!(level, simd => map.map_group(simd, number, &mut *blocks, &mut lost, &mut refined));
                    let Some(group) = group else { continue };
                    let [position, nearness] = group.errors;
                    for (index, of_block) in group.members.into_iter().enumerate() {
                        let block = block_of(number, index);
                        members[block] = of_block;
                        errors[block] = BlockErrors { position, nearness };
                    }
                }
            }
            if let (false, Ok(mut all)) = (lost.is_empty(), outliers.lock()) {
                all.append(&mut lost);
            }
            refined
        });
        counts.refined += refined.sum::<u64>();
    }

    /// Settles what the threads couldn't decide, in equal parts, and adds up what they counted.
    fn settle(&mut self, settler: &Settler<'_>) {
        let Self { workers, undecided, counts, .. } = self;
        undecided.clear();
        for worker in workers.iter_mut() {
            undecided.append(&mut worker.undecided);
            *counts += worker.counts;
        }
        let share = undecided.len().div_ceil(workers.len()).max(8);
        let shares = workers.par_iter_mut().zip(undecided.par_chunks(share));
        counts.settled += shares.map(|(worker, pairs)| settler.settle(pairs, 0, &mut worker.shadowed)).sum::<u64>();
    }

    /// Brings together which points the threads found in shadow on a face.
    fn merge_shadows(&mut self) {
        let Self { workers, shadowed, members, .. } = self;
        const CHUNK: usize = 4096;
        let chunks = shadowed.par_chunks_mut(CHUNK).zip(members.par_chunks(CHUNK)).enumerate();
        chunks.for_each(|(chunk, (shadowed, members))| {
            for worker in workers.iter() {
                let found = &worker.shadowed[chunk * CHUNK..][..shadowed.len()];
                shadowed.iter_mut().zip(found).zip(members).for_each(|((all, found), members)| *all |= found & members);
            }
        });
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> Bytes {
        let workers: usize = self.workers.iter().map(Worker::bytes).sum();
        let points = self.survey.bytes()
            + workers
            + self.blocks.capacity() * size_of::<Block>()
            + self.errors.capacity() * size_of::<BlockErrors>()
            + (self.members.capacity() + self.shadowed.capacity()) * size_of::<u16>()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
            + self.outliers.capacity() * size_of::<u32>();
        Bytes { triangles: self.vertices.capacity() * size_of::<[f32; 4]>(), points }
    }
}
