use std::ops::Range;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::boxes::SplatBox;
use super::candidates::{BATCH_PARTS, CandidateBatch, bits_of_parts};
use super::face::{Face, HALF_ULP, VertexErrors};
use super::filter::{FilterResult, QUEUE, TilePoints, Untested, enqueue, may_touch};
use super::parts::TilePart;
use super::pixel_map::PixelMap;
use super::point_set::PointSet;
use super::points::{GROUPS, TILE_BLOCKS, TileMap, origin};
use super::project::FacePatches;
use super::set_up::{Extent, Record, SetUp};
use super::settle::Settler;
use super::worker::{ShadowTile, ShadowWorker};
use crate::patches::Patches;
use crate::shot::{Counts, MaskAnswers, MaskPoints, Sides, TileOrder};
use crate::simd::lanes::bits_of;
use crate::simd::vectors::{LANES, splat};
use crate::vectorized;

/// The number of undecided pairs at which they are settled.
const MOST_UNDECIDED: usize = 1 << 12;

/// The inputs of tracing a face's tiles.
pub(crate) struct Tracer<'a> {
    pub(crate) face: &'a Face,
    pub(crate) vertex_errors: VertexErrors,
    /// Has no meaning where points are listed.
    pub(crate) pixels: PixelMap,
    pub(crate) patches: &'a Patches,
    pub(crate) on_face: &'a FacePatches,
    pub(crate) settler: &'a Settler<'a>,
    /// The area of a face over the number of blocks.
    pub(crate) average: f32,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(
        face: &'a Face,
        patches: &'a Patches,
        on_face: &'a FacePatches,
        settler: &'a Settler<'a>,
    ) -> Self {
        Self {
            face,
            vertex_errors: VertexErrors::new(face),
            pixels: match &settler.points {
                PointSet::Seen(_, rays) => PixelMap::new(face, rays),
                PointSet::Listed(_) => PixelMap::default(),
            },
            patches,
            on_face,
            settler,
            average: 4.0 / (settler.points.own().len() / TileOrder::BLOCK_PIXELS).max(1) as f32,
        }
    }
}

impl Tracer<'_> {
    /// Finds which of the face's points in a tile are in shadow.
    #[inline(always)]
    pub(crate) fn trace<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, number: usize) {
        self.begin(simd, worker, number);
        let count = worker.parts.parts.len();
        for first in (0..count).step_by(BATCH_PARTS) {
            let parts = first..(first + BATCH_PARTS).min(count);
            self.find_candidates(simd, worker, parts.clone());
            self.test_batch(simd, worker, parts);
        }
        let ShadowWorker { tile, undecided, counts, .. } = worker;
        self.settle(tile.first, undecided, &mut tile.shadowed, counts);
    }

    /// Maps a tile's points and divides them into parts.
    #[inline(always)]
    pub(crate) fn begin<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, number: usize) {
        let points = &self.settler.points;
        let origin = match points {
            PointSet::Seen(image, _) => origin(image, &self.pixels, number),
            PointSet::Listed(_) => [0.0; 3],
        };
        let map = TileMap::new(points, self.face, &self.pixels, number, origin);
        worker.tile.first = number * TILE_BLOCKS * LANES;
        worker.tile.shadowed.fill(0);
        self.map(simd, &map, worker);
    }

    #[inline(never)]
    fn settle(
        &self,
        first: usize,
        undecided: &mut Vec<[u32; 2]>,
        shadowed: &mut [u16; TILE_BLOCKS],
        counts: &mut Counts,
    ) {
        counts.undecided += undecided.len() as u64;
        counts.settled += self.settler.settle(undecided, first, shadowed);
        undecided.clear();
    }

    #[inline(never)]
    fn map<S: Simd>(&self, simd: S, map: &TileMap<'_>, worker: &mut ShadowWorker) {
        vectorized!(simd => self.map_with(simd, map, worker));
    }

    #[inline(always)]
    fn map_with<S: Simd>(&self, simd: S, map: &TileMap<'_>, worker: &mut ShadowWorker) {
        let ShadowWorker { tile, parts, outliers, counts, .. } = worker;
        parts.clear();
        tile.extent = map.extent();
        for number in 0..GROUPS {
            let group = map.map_group(simd, number, &mut tile.blocks, outliers, &mut counts.refined);
            let Some(group) = group else { continue };
            counts.points += group.members.iter().map(|members| u64::from(members.count_ones())).sum::<u64>();
            for (error, of_group) in tile.extent.errors.iter_mut().zip(group.errors) {
                *error = error.max(of_group);
            }
            parts.divide(simd, number, &group, &tile.blocks, self.average);
        }
        parts.finish(simd, &mut tile.extent);
        counts.parts += parts.parts.len() as u64;
    }

    /// Tests the points of a batch's parts against the candidates.
    #[inline(never)]
    fn test_batch<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, parts: Range<usize>) {
        vectorized!(simd => self.test_batch_with(simd, worker, parts));
    }

    /// Takes candidates one after the other, so that only one is set up at a time: its triangles stay in the fastest cache
    /// while all parts that it may reach are tested against them.
    #[inline(always)]
    fn test_batch_with<S: Simd>(&self, simd: S, worker: &mut ShadowWorker, parts: Range<usize>) {
        let ShadowWorker { tile, parts: all, batch, undecided, counts, .. } = worker;
        let parts = &all.parts[parts];
        let CandidateBatch { candidates, order, large, .. } = batch;
        let ShadowTile { first, extent, blocks, shadowed } = tile;
        let points = TilePoints::new(*first, blocks, self.settler.points.own());
        let mut rests = [Untested::NOTHING; BATCH_PARTS];
        for (rest, part) in rests.iter_mut().zip(parts) {
            *rest = Untested::of(part, shadowed);
        }
        for (record, reached) in large.iter() {
            for index in bits_of_parts(reached) {
                self.test_large(simd, record, &parts[index], &points, &mut rests[index], undecided, counts);
            }
            if undecided.len() >= MOST_UNDECIDED {
                self.settle(*first, undecided, shadowed, counts);
            }
        }
        let (mut set_up, mut queue) = (SetUp::EMPTY, [0; QUEUE]);
        for &index in order.iter() {
            let candidate = &candidates[index as u32 as usize];
            let around = SplatBox::new(simd, &candidate.around);
            let mut is_set_up = false;
            for index in bits_of_parts(&candidate.parts) {
                let (part, rest) = (&parts[index], &mut rests[index]);
                if part.boxes.reached(simd, &around).to_bitmask() as u16 & rest.alive == 0 {
                    continue;
                }
                if !is_set_up {
                    is_set_up = true;
                    self.set_up(simd, &mut set_up, candidate.number, extent);
                    counts.small_triangles += u64::from(set_up.count);
                }
                self.test_part(simd, &set_up, part, &points, rest, &mut queue, undecided, counts);
            }
            if undecided.len() >= MOST_UNDECIDED {
                self.settle(*first, undecided, shadowed, counts);
            }
        }
        for (part, rest) in parts.iter().zip(&rests) {
            for ((&block, &members), done) in part.blocks.iter().zip(&part.points).zip(rest.done) {
                shadowed[usize::from(block)] |= members & done;
            }
        }
    }

    /// Tests the points of a part against a large triangle.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a triangle, points, and what becomes of both")]
    fn test_large<S: Simd>(
        &self,
        simd: S,
        record: &Record,
        part: &TilePart,
        points: &TilePoints<'_>,
        rest: &mut Untested,
        undecided: &mut Vec<[u32; 2]>,
        counts: &mut Counts,
    ) {
        let opacity = self.settler.opacity.opacity;
        for slot in bits_of(may_touch(simd, &record.quads, &part.boxes) & rest.alive) {
            counts.tests += 1;
            let [a, b, c] = &record.quads;
            let block = part.blocks[slot];
            let found = points.test(simd, [a, b, c], record.id, (block, rest.done[slot]));
            if found.possible != 0 {
                // Masks of these are sampled at points in f64.
                let is_opaque = opacity.are_all_opaque() || opacity.is_opaque(record.id);
                let certain = if is_opaque { found.certain(simd, record.errors) } else { 0 };
                rest.take_out(slot, certain);
                if found.possible & !certain != 0 {
                    points.list_pending(block, record.id, found.possible & !certain, undecided);
                }
            }
        }
    }

    /// Tests the points of a part against a patch's triangles.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "triangles, points, and what becomes of both")]
    fn test_part<S: Simd>(
        &self,
        simd: S,
        set_up: &SetUp,
        part: &TilePart,
        points: &TilePoints<'_>,
        rest: &mut Untested,
        queue: &mut [u32; QUEUE],
        undecided: &mut Vec<[u32; 2]>,
        counts: &mut Counts,
    ) {
        let opacity = self.settler.opacity.opacity;
        let all_opaque = opacity.are_all_opaque();
        let whole = SplatBox::new(simd, &part.whole);
        let end = enqueue(simd, set_up, part, &whole, rest.alive, queue);
        counts.tests += end as u64;
        let ids = self.patches.get(set_up.number as usize).ids;
        for &pair in &queue[..end] {
            let (triangle, slot) = (pair as usize / LANES, pair as usize % LANES);
            let (id, block) = (ids[triangle], part.blocks[slot]);
            let found = points.test(simd, set_up.quads(triangle), id, (block, rest.done[slot]));
            if found.possible != 0 {
                let (mut certain, mut possible) = (found.certain(simd, set_up.errors(triangle)), found.possible);
                if !all_opaque && certain != 0 && !opacity.is_opaque(id) {
                    counts.masked += u64::from(possible.count_ones());
                    let answers = self.ask_mask(simd, set_up, triangle, points, (block, !possible));
                    (certain, possible) = (certain & answers.opaque, possible & !answers.cut);
                }
                rest.take_out(slot, certain);
                if possible & !certain != 0 {
                    points.list_pending(block, id, possible & !certain, undecided);
                }
            }
        }
    }

    /// Sets up a patch's triangles for a tile's points.
    #[inline(never)]
    pub(crate) fn set_up<S: Simd>(&self, simd: S, set_up: &mut SetUp, number: u32, extent: &Extent) {
        set_up.number = number;
        let patch = self.patches.get(number as usize);
        let vertices = &self.on_face.vertices[self.patches.vertex_range(number as usize)];
        let sides = self.settler.opacity.sides;
        let one_sided = match sides {
            Sides::Both => 0,
            Sides::Front => u64::MAX,
            Sides::Each(_) => {
                let ids = patch.ids[..patch.count].iter().enumerate();
                ids.fold(0, |bits, (slot, &id)| bits | u64::from(!sides.has_back(id)) << slot)
            }
        };
        vectorized!(simd => set_up.fill(simd, self.face, &self.vertex_errors, &patch, vertices, extent, one_sided));
    }

    /// Asks the mask of a patch's triangle about points of a block: those that it may shadow and that aren't `done`. It tests
    /// them again, since a result that were passed on would be stored after every test of any triangle.
    #[inline(never)]
    fn ask_mask<S: Simd>(
        &self,
        simd: S,
        set_up: &SetUp,
        triangle: usize,
        points: &TilePoints<'_>,
        (block, done): (u8, u16),
    ) -> MaskAnswers {
        let id = self.patches.get(set_up.number as usize).ids[triangle];
        let points = vectorized!(simd => {
            let found = points.test(simd, set_up.quads(triangle), id, (block, done));
            self.weights(simd, set_up, triangle, &found)
        });
        self.settler.opacity.opacity.which_stop(id, &points)
    }

    /// The positions where rays of the points that a triangle may shadow cross it, if they do, as weights of its corners.
    ///
    /// The predicate's weight of a corner is Eᵢ Wᵢ / D, with D the sum of all Eⱼ Wⱼ; in parallel light W is one there. If
    /// each E is wrong by at most δ, a weight from 0 to 1 is by at most 2 δ W / D, W being the largest, taken as 3. The
    /// nearness of a corner is wrong by 4 ε of itself, and with products, sums, quotient and the predicate's own rounding
    /// that makes 15 ε, taken as 24.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, set_up: &SetUp, triangle: usize, found: &FilterResult<S>) -> MaskPoints {
        let number = set_up.number as usize;
        let vertices = &self.on_face.vertices[self.patches.vertex_range(number)];
        let [a, b, c, _] = self.patches.get(number).corners[triangle];
        let [w0, w1, w2] =
            [a, b, c].map(|corner| if self.face.is_parallel { 1.0 } else { vertices[usize::from(corner)][2] });
        let edge_error = 0.5 * set_up.errors(triangle)[0];
        let grown = splat(simd, edge_error);
        let [e0, e1, e2] = found.edges;
        let (e0, e1, e2) = (e0 - grown, e1 - grown, e2 - grown);
        let (e1, e2) = (e1 * splat(simd, w1), e2 * splat(simd, w2));
        let inverse = splat(simd, 1.0) / (e0 * splat(simd, w0) + (e1 + e2));
        let [constant, per_nearness] = self.vertex_errors.of_weights;
        let largest = w0.max(w1).max(w2);
        let of_predicate = if self.face.is_parallel {
            let nearness = [a, b, c].map(|corner| vertices[usize::from(corner)][2].abs());
            nearness[0].max(nearness[1]).max(nearness[2]).max(1.0) * per_nearness + constant
        } else {
            largest * per_nearness + constant
        };
        let error = (edge_error + of_predicate * of_predicate) * (3.01 * largest);
        let error = inverse.abs() * splat(simd, error) + splat(simd, 24.0 * HALF_ULP as f32);
        MaskPoints {
            barycentric: [(e1 * inverse).into(), (e2 * inverse).into()],
            error: error.into(),
            lanes: found.possible,
        }
    }
}
