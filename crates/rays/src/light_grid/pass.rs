use std::time::Instant;

use rayon::prelude::*;

use super::block::{Block, BlockErrors};
use super::cells::Cells;
use super::choose;
use super::face::Face;
use super::map::Slab;
use super::settle::Settler;
use super::survey::Survey;
use super::worker::Worker;
use crate::LightSource;
use crate::shot::{Bytes, Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, TileOrder, Work};
use crate::simd::SimdLevel;

/// One light's way from what a camera sees to a mask: everything but how triangles find the points that they shadow.
///
/// Both forms of the light grid do it this way, face by face, and bring a `trace` of their own.
#[derive(Default)]
pub(crate) struct LightPass {
    pub(crate) level: SimdLevel,
    pub(crate) survey: Survey,
    faces: Vec<Face>,
    /// The face that the rest is about.
    pub(crate) face: Face,
    pub(crate) slabs: Vec<Slab>,
    pub(crate) cells: Cells,
    /// How many of some points are in each strip of the axes.
    pub(crate) samples: [Vec<u32>; 2],
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
            let points: u64 = pass.slabs.iter().map(|slab| u64::from(slab.points)).sum();
            if points == 0 {
                return;
            }
            pass.counts.points += points;
            pass.counts.refined += pass.slabs.iter().map(|slab| u64::from(slab.refined)).sum::<u64>();
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
            self.settle_outliers(shot, seen, light);
        }
        self.light_the_rest(seen, mask.blocks_mut());
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
        self.seconds = Seconds { survey: self.seconds.survey, ..Seconds::default() };
        self.outliers.clear();
        let image = SeenImage { shot, seen };
        let settler = Settler { image, rays: self.survey.rays, light, level: self.level };
        let mut faces = std::mem::take(&mut self.faces);
        let is_light = choose::choose(light, &self.survey.rays, &self.survey.tiles, &mut faces).is_some();
        for face in &faces {
            let start = Instant::now();
            self.face = *face;
            self.face.choose_point_error(&self.survey.rays, &self.survey.tiles);
            self.spread(&image);
            self.map(&image);
            self.slabs.iter().for_each(|slab| self.outliers.extend_from_slice(&slab.outliers));
            self.seconds.map += start.elapsed().as_secs_f64();
            visit(self, &settler);
        }
        self.faces = faces;
        is_light
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

    /// Writes the bits of the pixels that show a lit point.
    fn light_the_rest(&self, seen: &SeenPixels, lit: &mut [u16]) {
        const CHUNK: usize = 1024;
        let words = lit.par_chunks_mut(CHUNK).zip(self.shadowed.par_chunks(CHUNK)).enumerate();
        words.for_each(|(chunk, (lit, shadowed))| {
            let pixels = &seen.triangle[chunk * CHUNK * TileOrder::BLOCK_PIXELS..];
            let blocks = pixels.chunks_exact(TileOrder::BLOCK_PIXELS);
            for ((lit, shadowed), block) in lit.iter_mut().zip(shadowed).zip(blocks) {
                *lit = SeenPixels::shown_of(block) & !shadowed;
            }
        });
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> Bytes {
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
        Bytes { triangles: self.vertices.capacity() * size_of::<[f32; 4]>(), points }
    }
}
