use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16, u32x16};

use super::batch::{BatchPoints, MOST_SEARCHED, SlotList, SlotPoints};
use super::boxes::SplatBox;
use super::candidates::{BATCH_PARTS, CandidateBatch, CandidatePatch, bits_of_parts};
use super::face::{Face, HALF_ULP, VertexErrors};
use super::filter::{FilterResult, TilePoints, enqueue, may_touch};
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

/// Where a patch's bounds overlap more slots than this, their points aren't searched before its triangles are set up.
const MOST_OF_PATCH: u32 = MOST_SEARCHED as u32;

/// The same for a group of sixteen triangles.
const MOST_OF_GROUP: u32 = 32;

/// Room of the queue: each triangle of a group and each slot of a part, or points of the slots searched for a group, fewer
/// of each than triangles; and the lanes written beyond them.
pub(crate) const QUEUE: usize = LANES * MOST_OF_GROUP as usize + LANES;

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
            batch.list_reached(simd, around, all_slots, MOST_OF_PATCH, &mut of_patch);
            if of_patch.is_empty() {
                continue;
            }
            for group in self.groups(*number as usize) {
                let corners = GroupCorners::new(simd, &group);
                let around = corners.bounds(simd, self.face, extent);
                batch.list_reached(simd, &around, of_patch.iter(), MOST_OF_GROUP, &mut of_group);
                if of_group.is_empty() {
                    continue;
                }
                self.set_up(simd, &mut set_up, &group, &corners, extent);
                batch.counts.small_triangles += u64::from(group.filled.count_ones());
                if let Some(found) = of_group.found() {
                    self.test_found(simd, (&group, &set_up), found, &mut batch, &mut queue);
                    continue;
                }
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
        let of_part = &batch.parts[part];
        for slot in bits_of(may_touch(simd, &record.quads, &of_part.boxes) & batch.alive(part)) {
            batch.counts.tests += 1;
            let at = (of_part.blocks[slot], batch.done(part, slot));
            let found = batch.tile.test(simd, &record.quads, record.id, at);
            if found.possible != 0 {
                // Masks of these are sampled at points in f64.
                let certain = if self.is_opaque(record.id) { found.certain(simd, record.errors) } else { 0 };
                batch.note((part, slot), record.id, found.possible, certain);
            }
        }
    }

    /// Tests points in slots of a part against a group's triangles.
    #[inline(always)]
    fn test_part<S: Simd>(
        &self,
        simd: S,
        triangles: (&TriangleGroup<'_>, &SetUp),
        (part, slots): (usize, u16),
        batch: &mut BatchPoints<'_>,
        queue: &mut [u32; QUEUE],
    ) {
        let end = enqueue(simd, triangles.1, &batch.parts[part], slots, queue);
        for &pair in &queue[..end] {
            let (triangle, slot) = (pair as usize / LANES % LANES, pair as usize % LANES);
            self.test_slot(simd, triangles, triangle, (part, slot), batch);
        }
    }

    /// Tests the points in a group's box against its triangles. In each slot the fewer are taken one by one, and tested with
    /// sixteen of the others: the points of it, or the triangles whose bounds overlap its own.
    #[inline(always)]
    fn test_found<S: Simd>(
        &self,
        simd: S,
        triangles: (&TriangleGroup<'_>, &SetUp),
        found: &[SlotPoints],
        batch: &mut BatchPoints<'_>,
        queue: &mut [u32; QUEUE],
    ) {
        let lanes = u32x16::simd_from(simd, std::array::from_fn::<u32, LANES, _>(|lane| lane as u32));
        let mut end = 0;
        for &SlotPoints { part, slot, points } in found {
            let (part, slot) = (usize::from(part), usize::from(slot) % LANES);
            let around = SplatBox::new(simd, &batch.parts[part].boxes.get(slot));
            let overlapping = triangles.1.bounds.may_shadow(simd, &around);
            if points.count_ones() < overlapping.count_ones() {
                let pairs = lanes | u32x16::splat(simd, (part << 8 | slot << 4) as u32);
                let pairs = pairs.compress(mask32x16::from_bitmask(simd, points.into()));
                pairs.store_slice(&mut queue[end..end + LANES]);
                end += points.count_ones() as usize;
            } else {
                for triangle in bits_of(overlapping) {
                    self.test_slot(simd, triangles, triangle, (part, slot), batch);
                }
            }
        }
        for &point in &queue[..end] {
            let point = point as usize;
            self.test_point(simd, triangles, (point >> 8, point >> 4 & 15, point & 15), batch);
        }
    }

    /// Tests the points of a slot against a triangle of a group.
    #[inline(always)]
    fn test_slot<S: Simd>(
        &self,
        simd: S,
        (group, set_up): (&TriangleGroup<'_>, &SetUp),
        triangle: usize,
        (part, slot): (usize, usize),
        batch: &mut BatchPoints<'_>,
    ) {
        batch.counts.tests += 1;
        let (id, at) = (group.ids[triangle % LANES], (batch.parts[part].blocks[slot], batch.done(part, slot)));
        let found = batch.tile.test(simd, &set_up.quads(triangle), id, at);
        if found.possible != 0 {
            let (mut certain, mut possible) = (found.certain(simd, set_up.errors(triangle)), found.possible);
            if certain != 0 && !self.is_opaque(id) {
                batch.counts.masked += u64::from(possible.count_ones());
                let answers = self.ask_mask(simd, (group, set_up), triangle, &batch.tile, (at.0, !possible));
                (certain, possible) = (certain & answers.opaque, possible & !answers.cut);
            }
            batch.note((part, slot), id, possible, certain);
        }
    }

    /// Tests a point, by its part, slot and lane, against the triangles of a group.
    #[inline(always)]
    fn test_point<S: Simd>(
        &self,
        simd: S,
        (group, set_up): (&TriangleGroup<'_>, &SetUp),
        (part, slot, lane): (usize, usize, usize),
        batch: &mut BatchPoints<'_>,
    ) {
        batch.counts.tests += 1;
        let block = batch.parts[part].blocks[slot];
        let (point, own) = batch.tile.point(block, lane);
        let [possible, certain] = set_up.test_point(simd, group.ids, point, own);
        if possible == 0 {
            return;
        }
        let mut is_shadowed = bits_of(certain).any(|triangle| self.is_opaque(group.ids[triangle]));
        if !is_shadowed {
            for triangle in bits_of(possible) {
                let mut is_pending = true;
                if certain >> triangle & 1 == 1 {
                    batch.counts.masked += 1;
                    let answers = self.ask_mask(simd, (group, set_up), triangle, &batch.tile, (block, !(1 << lane)));
                    is_shadowed |= answers.opaque != 0;
                    is_pending = answers.opaque | answers.cut == 0;
                }
                if is_pending {
                    batch.tile.list_pending(block, group.ids[triangle], 1 << lane, batch.undecided);
                }
            }
        }
        batch.note((part, slot), 0, 0, u16::from(is_shadowed) << lane);
    }

    /// Whether a triangle stops light wherever it is hit.
    #[inline(always)]
    fn is_opaque(&self, id: u32) -> bool {
        let opacity = self.settler.opacity.opacity;
        opacity.are_all_opaque() || opacity.is_opaque(id)
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
        corners: &GroupCorners<S>,
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
