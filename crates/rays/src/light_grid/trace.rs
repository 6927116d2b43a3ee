use std::ops::Range;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::batch::{BatchPoints, SlotList};
use super::candidates::{BATCH_PARTS, CandidateBatch, CandidatePatch, bits_of_parts};
use super::face::{Face, HALF_ULP, VertexErrors};
use super::filter::{FilterResult, QUEUE, TilePoints, enqueue, may_touch};
use super::pixel_map::PixelMap;
use super::point_set::PointSet;
use super::points::{GROUPS, TILE_BLOCKS, TileMap, origin};
use super::project::FacePatches;
use super::set_up::{Extent, GroupCorners, Record, SetUp, TriangleGroup};
use super::settle::Settler;
use super::worker::{ShadowTile, ShadowWorker};
use crate::patches::Patches;
use crate::shot::{Counts, MaskAnswers, MaskPoints, Sides, TileOrder};
use crate::simd::lanes::bits_of;
use crate::simd::vectors::{LANES, splat};
use crate::vectorized;

/// The number of undecided pairs at which they are settled.
const MOST_UNDECIDED: usize = 1 << 12;

/// Where a group's bounds overlap more slots than this, or a patch's twice as many, their points aren't searched before its
/// triangles are set up.
const MOST_SEARCHED: u32 = 16;

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
        let mut batch = BatchPoints::new(points, parts, shadowed, undecided, counts);
        for (record, reached) in large.iter() {
            for part in bits_of_parts(reached) {
                self.test_large(simd, record, part, &mut batch);
            }
            self.settle_many(&mut batch, *first, shadowed);
        }
        let (mut of_patch, mut of_group) = (SlotList::EMPTY, SlotList::EMPTY);
        let (mut set_up, mut queue) = (SetUp::EMPTY, [0; QUEUE]);
        for &index in order.iter() {
            let CandidatePatch { number, around, parts } = &candidates[index as u32 as usize];
            let all_slots = bits_of_parts(parts).map(|part| (part, u16::MAX));
            batch.list_reached(simd, around, all_slots, 2 * MOST_SEARCHED, &mut of_patch);
            if of_patch.is_empty() {
                continue;
            }
            for group in self.groups(*number as usize) {
                let corners = GroupCorners::new(simd, &group);
                let around = corners.bounds(simd, self.face, extent);
                batch.list_reached(simd, &around, of_patch.iter(), MOST_SEARCHED, &mut of_group);
                if of_group.is_empty() {
                    continue;
                }
                self.set_up(simd, &mut set_up, &group, corners, extent);
                batch.counts.small_triangles += u64::from(group.filled.count_ones());
                for at in of_group.iter() {
                    self.test_part(simd, (&group, &set_up), at, &mut batch, &mut queue);
                }
            }
            self.settle_many(&mut batch, *first, shadowed);
        }
        batch.keep(shadowed);
    }

    /// Settles the undecided pairs if there are many.
    #[inline(always)]
    fn settle_many(&self, batch: &mut BatchPoints<'_>, first: usize, shadowed: &mut [u16; TILE_BLOCKS]) {
        if batch.undecided.len() >= MOST_UNDECIDED {
            self.settle(first, batch.undecided, shadowed, batch.counts);
        }
    }

    /// Tests the points of a part against a large triangle.
    #[inline(always)]
    fn test_large<S: Simd>(&self, simd: S, record: &Record, part: usize, batch: &mut BatchPoints<'_>) {
        let opacity = self.settler.opacity.opacity;
        let of_part = &batch.parts[part];
        for slot in bits_of(may_touch(simd, &record.quads, &of_part.boxes) & batch.alive(part)) {
            batch.counts.tests += 1;
            let at = (of_part.blocks[slot], batch.done(part, slot));
            let found = batch.tile.test(simd, &record.quads, record.id, at);
            if found.possible != 0 {
                // Masks of these are sampled at points in f64.
                let is_opaque = opacity.are_all_opaque() || opacity.is_opaque(record.id);
                let certain = if is_opaque { found.certain(simd, record.errors) } else { 0 };
                batch.note((part, slot), record.id, found.possible, certain);
            }
        }
    }

    /// Tests points in slots of a part against a group's triangles.
    #[inline(always)]
    fn test_part<S: Simd>(
        &self,
        simd: S,
        (group, set_up): (&TriangleGroup<'_>, &SetUp),
        (part, slots): (usize, u16),
        batch: &mut BatchPoints<'_>,
        queue: &mut [u32; QUEUE],
    ) {
        let opacity = self.settler.opacity.opacity;
        let all_opaque = opacity.are_all_opaque();
        let of_part = &batch.parts[part];
        let end = enqueue(simd, set_up, of_part, slots, queue);
        batch.counts.tests += end as u64;
        for &pair in &queue[..end] {
            let (triangle, slot) = (pair as usize / LANES % LANES, pair as usize % LANES);
            let (id, at) = (group.ids[triangle], (of_part.blocks[slot], batch.done(part, slot)));
            let found = batch.tile.test(simd, &set_up.quads(triangle), id, at);
            if found.possible != 0 {
                let (mut certain, mut possible) = (found.certain(simd, set_up.errors(triangle)), found.possible);
                if !all_opaque && certain != 0 && !opacity.is_opaque(id) {
                    batch.counts.masked += u64::from(possible.count_ones());
                    let answers = self.ask_mask(simd, (group, set_up), triangle, &batch.tile, (at.0, !possible));
                    (certain, possible) = (certain & answers.opaque, possible & !answers.cut);
                }
                batch.note((part, slot), id, possible, certain);
            }
        }
    }

    /// The triangles of a patch.
    #[inline(always)]
    pub(crate) fn groups(&self, number: usize) -> impl Iterator<Item = TriangleGroup<'_>> {
        let patch = self.patches.get(number);
        let vertices = &self.on_face.vertices[self.patches.vertex_range(number)];
        let groups = patch.corners.as_chunks().0.iter().zip(patch.ids.as_chunks().0);
        groups.enumerate().map(move |(index, (corners, ids))| {
            let filled = (1 << patch.count.saturating_sub(index * LANES).min(LANES)) - 1_u32;
            TriangleGroup { vertices, corners, ids, filled: filled as u16 }
        })
    }

    /// Sets up a group's triangles for a tile's points.
    #[inline(always)]
    pub(crate) fn set_up<S: Simd>(
        &self,
        simd: S,
        set_up: &mut SetUp,
        group: &TriangleGroup<'_>,
        corners: GroupCorners<S>,
        extent: &Extent,
    ) {
        let sides = self.settler.opacity.sides;
        let one_sided = match sides {
            Sides::Both => 0,
            Sides::Front => u16::MAX,
            Sides::Each(_) => bits_of(group.filled)
                .fold(0, |bits, triangle| bits | u16::from(!sides.has_back(group.ids[triangle])) << triangle),
        };
        set_up.fill(simd, self.face, &self.vertex_errors, corners, extent, one_sided);
    }

    /// Asks the mask of a triangle about points of a block, those that it may shadow and that aren't done. It tests
    /// them again, since a result that were passed on would be stored after every test of any triangle.
    #[inline(never)]
    fn ask_mask<S: Simd>(
        &self,
        simd: S,
        (group, set_up): (&TriangleGroup<'_>, &SetUp),
        triangle: usize,
        points: &TilePoints<'_>,
        at: (u8, u16),
    ) -> MaskAnswers {
        let id = group.ids[triangle];
        let points = vectorized!(simd => {
            let found = points.test(simd, &set_up.quads(triangle), id, at);
            self.weights(simd, group.nearness_of_corners(triangle), set_up.errors(triangle)[0], &found)
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
    fn weights<S: Simd>(
        &self,
        simd: S,
        nearness: [f32; 3],
        twice_edge_error: f32,
        found: &FilterResult<S>,
    ) -> MaskPoints {
        let [w0, w1, w2] = if self.face.is_parallel { [1.0; 3] } else { nearness };
        let edge_error = 0.5 * twice_edge_error;
        let grown = splat(simd, edge_error);
        let [e0, e1, e2] = found.edges;
        let (e0, e1, e2) = (e0 - grown, e1 - grown, e2 - grown);
        let (e1, e2) = (e1 * splat(simd, w1), e2 * splat(simd, w2));
        let inverse = splat(simd, 1.0) / (e0 * splat(simd, w0) + (e1 + e2));
        let [constant, per_nearness] = self.vertex_errors.of_weights;
        let largest = w0.max(w1).max(w2);
        let of_predicate = if self.face.is_parallel {
            nearness.into_iter().fold(1.0, |largest: f32, nearness| largest.max(nearness.abs())) * per_nearness
                + constant
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
