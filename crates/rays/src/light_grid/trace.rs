use std::collections::HashMap;
use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::block::Block;
use super::boxes::{FaceBox, SixteenBoxes, SplatBox};
use super::face::{Face, HALF_ULP, VertexErrors};
use super::parts::Part;
use super::pixel_map::PixelMap;
use super::points::{GROUPS, TILE_BLOCKS, TileMap, origin};
use super::project::FacePatches;
use super::set_up::{Extent, Record, SetUp};
use super::settle::Settler;
use super::survey::Survey;
use super::worker::{Tile, Worker, make_room};
use crate::patches::{MOST_TRIANGLES, Patches};
use crate::shot::{MaskAnswers, MaskPoints, SeenPixels, TileOrder};
use crate::simd::lanes::{bits_of, load, min3};
use crate::simd::vectorized;
use crate::simd::vectors::{LANES, splat};

/// Parts whose candidates are found together.
const BATCH_PARTS: usize = 128;

/// A bit for each part of a batch.
type PartBits = [u64; BATCH_PARTS / 64];

/// Candidates whose triangles are set up together.
const BATCH_CANDIDATES: usize = 256;

/// Undecided pairs that are collected before they are settled.
const MOST_UNDECIDED: usize = 1 << 12;

/// Where a triangle's bounds overlap more slots of a part than this, its edges are tested against their boxes before it is
/// tested against their points.
const MOST_UNTESTED: u32 = 6;

/// What tracing a face's tiles needs to know.
pub(crate) struct Tracer<'a> {
    face: &'a Face,
    vertex_errors: VertexErrors,
    pixels: PixelMap,
    patches: &'a Patches,
    on_face: &'a FacePatches,
    settler: &'a Settler<'a>,
    /// The area of a face over the number of the image's blocks.
    average: f32,
}

/// What may shadow points of some parts.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// The boxes of parts, sixteen together.
    boxes: Vec<SixteenBoxes>,
    candidates: Vec<Candidate>,
    /// Their indices, in the lower half of each number, the nearest to the light first.
    order: Vec<u64>,
    /// Those beyond `set_up_count` are left from earlier.
    set_ups: Vec<SetUp>,
    set_up_count: usize,
    large: Vec<(Record, PartBits)>,
    /// Pairs of a triangle, in the upper bits, and a slot of a part, in the lowest four.
    queue: Vec<u32>,
}

/// A patch that may shadow points of a batch.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    number: u32,
    /// Its index in `set_ups`, or none.
    set_up: u32,
    /// In relation to the tile's origin.
    around: FaceBox,
    /// Which parts it may shadow points of.
    parts: PartBits,
}

impl Batch {
    pub(crate) fn bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<SixteenBoxes>()
            + self.candidates.capacity() * (size_of::<Candidate>() + size_of::<u64>())
            + self.set_ups.capacity() * size_of::<SetUp>()
            + self.large.capacity() * size_of::<(Record, PartBits)>()
            + self.queue.capacity() * size_of::<u32>()
    }

    /// How much each list has room for.
    pub(crate) fn room(&self) -> [usize; 4] {
        [self.boxes.capacity(), self.candidates.capacity(), self.set_ups.len(), self.large.capacity()]
    }

    /// Makes room for at least so much in each list.
    pub(crate) fn make_room(&mut self, [boxes, candidates, set_ups, large]: [usize; 4]) {
        make_room(&mut self.boxes, boxes);
        make_room(&mut self.candidates, candidates);
        make_room(&mut self.order, candidates);
        make_room(&mut self.set_ups, set_ups);
        make_room(&mut self.large, large);
    }
}

const NOT_SET_UP: u32 = u32::MAX;

/// Room of the queue: each triangle of a patch and each slot, and what is written beyond them.
const QUEUE: usize = 64 * LANES + LANES;

impl<'a> Tracer<'a> {
    pub(crate) fn new(
        face: &'a Face,
        survey: &Survey,
        patches: &'a Patches,
        on_face: &'a FacePatches,
        settler: &'a Settler<'a>,
    ) -> Self {
        Self {
            face,
            vertex_errors: VertexErrors::new(face),
            pixels: PixelMap::new(face, &survey.rays),
            patches,
            on_face,
            settler,
            average: 4.0 / (survey.slots / TileOrder::BLOCK_PIXELS).max(1) as f32,
        }
    }
}

impl Tracer<'_> {
    /// Finds which points of a tile are in shadow, among those that the face has.
    #[inline(always)]
    pub(crate) fn trace<S: Simd>(&self, simd: S, worker: &mut Worker, number: usize) {
        self.begin(simd, worker, number);
        let count = worker.parts.parts.len();
        for first in (0..count).step_by(BATCH_PARTS) {
            let parts = first..(first + BATCH_PARTS).min(count);
            self.find_candidates(simd, worker, parts.clone());
            let candidates = worker.batch.candidates.len();
            for first in (0..candidates.max(1)).step_by(BATCH_CANDIDATES) {
                worker.batch.set_up_count = 0;
                let candidates = first..(first + BATCH_CANDIDATES).min(candidates);
                for part in parts.clone() {
                    self.test_part(simd, worker, part, part - parts.start, candidates.clone());
                }
            }
        }
        if !worker.undecided.is_empty() {
            self.settle(worker);
        }
    }

    /// Maps a tile's points and divides them into parts.
    #[inline(always)]
    pub(crate) fn begin<S: Simd>(&self, simd: S, worker: &mut Worker, number: usize) {
        let Settler { image, rays, .. } = self.settler;
        let origin = origin(image, &self.pixels, number);
        let map = TileMap::new(image, rays, self.face, &self.pixels, number, origin);
        worker.tile.first = number * TILE_BLOCKS * LANES;
        worker.tile.shadowed.fill(0);
        self.map(simd, &map, worker);
    }

    #[inline(never)]
    fn settle(&self, worker: &mut Worker) {
        let Worker { tile, undecided, counts, .. } = worker;
        counts.settled += self.settler.settle(undecided, tile.first, &mut *tile.shadowed);
        undecided.clear();
    }

    #[inline(never)]
    fn map<S: Simd>(&self, simd: S, map: &TileMap<'_>, worker: &mut Worker) {
        vectorized!(simd => self.map_with(simd, map, worker));
    }

    #[inline(always)]
    fn map_with<S: Simd>(&self, simd: S, map: &TileMap<'_>, worker: &mut Worker) {
        let Worker { tile, parts, outliers, counts, .. } = worker;
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

    /// Finds the patches and large triangles that may shadow points of some parts.
    #[inline(never)]
    pub(crate) fn find_candidates<S: Simd>(&self, simd: S, worker: &mut Worker, parts: Range<usize>) {
        vectorized!(simd => self.find_candidates_with(simd, worker, parts));
    }

    #[inline(always)]
    fn find_candidates_with<S: Simd>(&self, simd: S, worker: &mut Worker, parts: Range<usize>) {
        let Worker { tile, parts: all, batch, counts, .. } = worker;
        let parts = &all.parts[parts];
        let Batch { boxes, candidates, order, large, .. } = batch;
        let around = boxes_on_face(&tile.extent, parts, boxes);
        let splat_around = SplatBox::new(simd, &around);
        candidates.clear();
        let [origin_x, origin_y, origin_w] = tile.extent.origin;
        for (number, upper) in self.on_face.upper.iter().enumerate() {
            for lane in bits_of(upper.may_shadow(simd, &splat_around)) {
                let number = number * LANES + lane;
                let sixteen = &self.on_face.sixteens[number];
                for lane in bits_of(sixteen.may_shadow(simd, &splat_around)) {
                    let one = sixteen.get(lane);
                    let splat_one = SplatBox::new(simd, &one);
                    let mut reached = PartBits::default();
                    for (number, boxes) in boxes.iter().enumerate() {
                        reached[number / 4] |= boxes.reached(simd, &splat_one).to_bitmask() << (number % 4 * LANES);
                    }
                    if reached == PartBits::default() {
                        continue;
                    }
                    // With what rounding the differences makes of it.
                    const ROUNDED: f32 = 4.0 * HALF_ULP as f32;
                    let nearness = one.nearness - origin_w + (one.nearness.abs() + origin_w.abs()) * ROUNDED;
                    let around = FaceBox {
                        x: [one.x[0] - origin_x - ROUNDED, one.x[1] - origin_x + ROUNDED],
                        y: [one.y[0] - origin_y - ROUNDED, one.y[1] - origin_y + ROUNDED],
                        nearness,
                    };
                    let number = (number * LANES + lane) as u32;
                    candidates.push(Candidate { number, set_up: NOT_SET_UP, around, parts: reached });
                }
            }
        }
        // The nearest to the light first, since what is found in shadow needn't be tested again.
        order.clear();
        order.extend(
            candidates
                .iter()
                .enumerate()
                .map(|(index, candidate)| u64::from(!ascending(candidate.around.nearness)) << 32 | index as u64),
        );
        order.sort_unstable();
        large.clear();
        self.on_face.large.reaching(
            simd,
            &around,
            #[inline(always)]
            |number| {
                let Extent { origin, reach, depth, errors } = tile.extent;
                let record = self.on_face.large.record(number, origin, [reach, depth], errors);
                let mut reached = PartBits::default();
                for (index, part) in parts.iter().enumerate() {
                    let touched = may_touch(simd, &record.quads, &part.boxes);
                    reached[index / 64] |= u64::from(touched != 0) << (index % 64);
                }
                if reached != PartBits::default() {
                    large.push((record, reached));
                }
            },
        );
        counts.large_triangles += large.len() as u64;
    }

    /// Tests the points of a part, number `bit` of its batch, against some of the candidates that may shadow them.
    #[inline(never)]
    fn test_part<S: Simd>(&self, simd: S, worker: &mut Worker, part: usize, bit: usize, candidates: Range<usize>) {
        vectorized!(simd => self.test_part_with(simd, worker, part, bit, candidates));
    }

    #[inline(always)]
    fn test_part_with<S: Simd>(&self, simd: S, worker: &mut Worker, part: usize, bit: usize, candidates: Range<usize>) {
        let Worker { tile, parts, batch, undecided, counts, .. } = worker;
        let Batch { candidates: all, order, set_ups, set_up_count, large, queue, .. } = batch;
        let part = &parts.parts[part];
        let (word, bit) = (bit / 64, bit % 64);
        queue.resize(QUEUE, 0);
        let Tile { first, extent, blocks, shadowed } = tile;
        let mut points = PartPoints::new(part, *first, blocks, shadowed, self.settler.image.seen);
        let opacity = self.settler.image.shot.shadow_opacity;
        let all_opaque = opacity.are_all_opaque();
        let known = undecided.len();
        if candidates.start == 0 {
            for (record, parts) in large.iter() {
                if parts[word] >> bit & 1 == 1 {
                    for slot in bits_of(may_touch(simd, &record.quads, &part.boxes)) {
                        counts.tests += 1;
                        let [a, b, c] = &record.quads;
                        let found = points.test(simd, [a, b, c], record.id, slot);
                        if found.possible != 0 {
                            // Masks are asked in f64 about points of these.
                            let is_opaque = all_opaque || opacity.is_opaque(record.id);
                            let certain = if is_opaque { found.certain(simd, record.errors) } else { 0 };
                            points.note(slot, record.id, certain, found.possible & !certain, undecided);
                        }
                    }
                }
            }
        }
        let whole = SplatBox::new(simd, &part.whole);
        for &index in &order[candidates] {
            let candidate = &mut all[index as u32 as usize];
            if candidate.parts[word] >> bit & 1 == 0 {
                continue;
            }
            if points.alive == 0 {
                break;
            }
            let around = SplatBox::new(simd, &candidate.around);
            if part.boxes.reached(simd, &around).to_bitmask() as u16 & points.alive == 0 {
                continue;
            }
            if candidate.set_up == NOT_SET_UP {
                candidate.set_up = *set_up_count as u32;
                *set_up_count += 1;
                if set_ups.len() < *set_up_count {
                    set_ups.push(SetUp::EMPTY);
                }
                self.set_up(simd, &mut set_ups[candidate.set_up as usize], candidate.number, extent);
                counts.small_triangles += u64::from(set_ups[candidate.set_up as usize].count);
            }
            let set_up = &set_ups[candidate.set_up as usize];
            let end = enqueue(simd, set_up, part, &whole, points.alive, queue);
            counts.tests += end as u64;
            let ids = self.patches.get(set_up.number as usize).ids;
            for &pair in &queue[..end] {
                let (triangle, slot) = (pair as usize / LANES, pair as usize % LANES);
                let found = points.test(simd, set_up.quads(triangle), ids[triangle], slot);
                if found.possible != 0 {
                    let id = ids[triangle];
                    let (mut certain, mut possible) = (found.certain(simd, set_up.errors(triangle)), found.possible);
                    if !all_opaque && certain != 0 && !opacity.is_opaque(id) {
                        counts.masked += u64::from(possible.count_ones());
                        let answers = self.ask_mask(simd, set_up, triangle, id, &found);
                        (certain, possible) = (certain & answers.opaque, possible & !answers.cut);
                    }
                    points.note(slot, id, certain, possible & !certain, undecided);
                }
            }
        }
        counts.undecided += (undecided.len() - known) as u64;
        let done = points.done;
        for ((&block, &members), done) in part.blocks.iter().zip(&part.points).zip(done) {
            shadowed[usize::from(block)] |= members & done;
        }
        if worker.undecided.len() >= MOST_UNDECIDED {
            self.settle(worker);
        }
    }

    /// Sets up a patch's triangles for a tile's points.
    #[inline(never)]
    fn set_up<S: Simd>(&self, simd: S, set_up: &mut SetUp, number: u32, extent: &Extent) {
        set_up.number = number;
        let patch = self.patches.get(number as usize);
        let vertices = &self.on_face.vertices[self.patches.vertex_range(number as usize)];
        vectorized!(simd => set_up.fill(simd, self.face, &self.vertex_errors, &patch, vertices, extent));
    }

    /// Asks the mask of a patch's triangle about the points that it may shadow.
    #[inline(never)]
    fn ask_mask<S: Simd>(&self, simd: S, set_up: &SetUp, triangle: usize, id: u32, found: &Found<S>) -> MaskAnswers {
        let points = vectorized!(simd => self.weights(simd, set_up, triangle, found));
        self.settler.image.shot.shadow_opacity.which_stop(id, &points)
    }

    /// Where on a triangle the rays of the points that it may shadow cross it, if they do.
    ///
    /// The predicate's weight of a corner is Eᵢ Wᵢ / D, with D the sum of all Eⱼ Wⱼ; in parallel light W is one there.
    /// If each E is wrong by at most δ, a weight from 0 to 1 is by at most 2 δ W / D, W being the largest, taken as 3.
    /// The nearness of a corner is wrong by 4 ε of itself, and with products, sums, quotient and the predicate's own
    /// rounding that makes 15 ε, taken as 24.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, set_up: &SetUp, triangle: usize, found: &Found<S>) -> MaskPoints {
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

/// The points of a part.
struct PartPoints<'a> {
    blocks: [&'a Block; LANES],
    /// The triangles that they are on.
    own: [&'a [u32]; LANES],
    /// The index of each slot's first pixel.
    first: [u32; LANES],
    /// Which needn't be tested any more: those in shadow, and those that aren't in the slot.
    done: [u16; LANES],
    /// The slots with points that must still be tested.
    alive: u16,
}

/// What the filter says about a triangle and the points of a slot.
struct Found<S: Simd> {
    /// The edge functions, grown by their error.
    edges: [f32x16<S>; 3],
    /// The least of them.
    least: f32x16<S>,
    /// By how much the triangle is nearer to the light, grown by its error.
    nearer: f32x16<S>,
    /// Which of the points that must still be tested it may shadow.
    possible: u16,
}

impl<S: Simd> Found<S> {
    /// Which points the triangle shadows for certain; `errors` are twice those of the edge functions and of the nearness.
    #[inline(always)]
    fn certain(&self, simd: S, errors: [f32; 2]) -> u16 {
        let certain = self.least.simd_gt(splat(simd, errors[0])) & self.nearer.simd_gt(splat(simd, errors[1]));
        certain.to_bitmask() as u16 & self.possible
    }
}

impl<'a> PartPoints<'a> {
    /// Notes which points of a slot a triangle shadows for certain, and lists those that are pending.
    #[inline(always)]
    fn note(&mut self, slot: usize, id: u32, certain: u16, pending: u16, undecided: &mut Vec<[u32; 2]>) {
        let slot = slot % LANES;
        self.done[slot] |= certain;
        self.alive &= !(u16::from(self.done[slot] == u16::MAX) << slot);
        if pending != 0 {
            list_pending(self.first[slot], id, pending, undecided);
        }
    }

    #[inline(always)]
    fn new(
        part: &Part,
        first: usize,
        blocks: &'a [Block; TILE_BLOCKS],
        shadowed: &[u16; TILE_BLOCKS],
        seen: &'a SeenPixels,
    ) -> Self {
        let of_slot = part.blocks.map(usize::from);
        let done: [u16; LANES] = std::array::from_fn(|slot| !part.points[slot] | shadowed[of_slot[slot]]);
        let alive = (0..LANES).fold(0, |alive, slot| alive | u16::from(done[slot] != u16::MAX) << slot);
        let index = of_slot.map(|block| first + block * LANES);
        Self {
            blocks: of_slot.map(|block| &blocks[block]),
            own: index.map(|index| &seen.triangle[index..index + LANES]),
            first: index.map(|index| index as u32),
            done,
            alive,
        }
    }

    /// Tests a triangle against the points of a slot.
    ///
    /// Points on the triangle itself are left out at once: that most tests of lit surfaces find something of which only these
    /// are left can't be foreseen.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, [first, second, third]: [&[f32; 4]; 3], id: u32, slot: usize) -> Found<S> {
        let slot = slot % LANES;
        let block = self.blocks[slot];
        let (x, y) = (f32x16::simd_from(simd, block.x), f32x16::simd_from(simd, block.y));
        let nearness = f32x16::simd_from(simd, block.nearness);
        let e0 = line(simd, [first[0], first[1], first[2]], x, y);
        let e1 = line(simd, [second[0], second[1], second[2]], x, y);
        let e2 = line(simd, [third[0], third[1], third[2]], x, y);
        let nearer = line(simd, [first[3], second[3], third[3]], x, y) - nearness;
        let least = min3([e0, e1, e2]);
        let zero = splat(simd, 0.0);
        // Written so that NaN is possible.
        let own = u32x16::from_slice(simd, self.own[slot]).simd_eq(u32x16::splat(simd, id));
        let missed = least.simd_lt(zero) | nearer.simd_lt(zero) | own;
        let possible = !(missed.to_bitmask() as u16 | self.done[slot]);
        Found { edges: [e0, e1, e2], least, nearer, possible }
    }
}

/// Lists the pairs of a triangle and the points of a block that are pending.
#[cold]
#[inline(never)]
fn list_pending(first: u32, id: u32, pending: u16, undecided: &mut Vec<[u32; 2]>) {
    undecided.extend(bits_of(pending).map(|lane| [first + lane as u32, id]));
}

/// The boxes of parts on the face, sixteen together, and the box around them all.
fn boxes_on_face(extent: &Extent, parts: &[Part], boxes: &mut Vec<SixteenBoxes>) -> FaceBox {
    let [origin_x, origin_y, origin_w] = extent.origin;
    let mut all = FaceBox { nearness: f32::INFINITY, ..FaceBox::NOTHING };
    boxes.clear();
    boxes.extend(parts.chunks(LANES).map(|parts| {
        let mut sixteen = SixteenBoxes::NO_POINTS;
        for (lane, part) in parts.iter().enumerate() {
            // With what rounding the sums makes of it.
            const ROUNDED: f32 = 4.0 * HALF_ULP as f32;
            let FaceBox { x, y, nearness } = part.whole;
            let one = FaceBox {
                x: [x[0] + origin_x - ROUNDED, x[1] + origin_x + ROUNDED],
                y: [y[0] + origin_y - ROUNDED, y[1] + origin_y + ROUNDED],
                nearness: nearness + origin_w - (nearness.abs() + origin_w.abs()) * ROUNDED,
            };
            all.x = [all.x[0].min(one.x[0]), all.x[1].max(one.x[1])];
            all.y = [all.y[0].min(one.y[0]), all.y[1].max(one.y[1])];
            all.nearness = all.nearness.min(one.nearness);
            sixteen.set(lane, one);
        }
        sixteen
    }));
    all
}

/// A number that is larger the larger another is.
fn ascending(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ if number.is_sign_negative() { u32::MAX } else { 1 << 31 }
}

/// Which slots of a part a triangle may shadow points of: those where none of its functions is below zero everywhere.
#[inline(always)]
fn may_touch<S: Simd>(simd: S, [first, second, third]: &[[f32; 4]; 3], points: &SixteenBoxes) -> u16 {
    let (x, y) =
        ([load(simd, &points.x[0]), load(simd, &points.x[1])], [load(simd, &points.y[0]), load(simd, &points.y[1])]);
    let e0 = most(simd, [first[0], first[1], first[2]], x, y);
    let e1 = most(simd, [second[0], second[1], second[2]], x, y);
    let e2 = most(simd, [third[0], third[1], third[2]], x, y);
    let nearer = most(simd, [first[3], second[3], third[3]], x, y) - load(simd, &points.nearness);
    let missed = min3([e0, e1, e2]).min(nearer).simd_lt(splat(simd, 0.0)) | x[0].simd_gt(x[1]);
    !(missed.to_bitmask() as u16)
}

/// Sixteen of what a patch's triangles have.
#[inline(always)]
fn sixteen<S: Simd>(simd: S, values: &[f32; MOST_TRIANGLES], group: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &values[group * LANES..(group + 1) * LANES])
}

/// The most of a linear function in boxes.
#[inline(always)]
fn most<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: [f32x16<S>; 2], y: [f32x16<S>; 2]) -> f32x16<S> {
    let x = if a > 0.0 { x[1] } else { x[0] };
    let y = if b > 0.0 { y[1] } else { y[0] };
    line(simd, [a, b, c], x, y)
}

#[inline(always)]
fn line<S: Simd>(simd: S, [a, b, c]: [f32; 3], x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    splat(simd, a).mul_add(x, splat(simd, b).mul_add(y, splat(simd, c)))
}

/// Lists the pairs of a patch's triangles and the `alive` slots of a part that the triangle may shadow points of; how many
/// there are.
#[inline(always)]
fn enqueue<S: Simd>(simd: S, set_up: &SetUp, part: &Part, whole: &SplatBox<S>, alive: u16, queue: &mut [u32]) -> usize {
    let lanes = u32x16::simd_from(simd, std::array::from_fn::<u32, LANES, _>(|lane| lane as u32));
    let mut end = 0;
    for group in 0..(set_up.count as usize).div_ceil(LANES) {
        let overlap = sixteen(simd, &set_up.x[0], group).simd_le(whole.x[1])
            & sixteen(simd, &set_up.x[1], group).simd_ge(whole.x[0])
            & sixteen(simd, &set_up.y[0], group).simd_le(whole.y[1])
            & sixteen(simd, &set_up.y[1], group).simd_ge(whole.y[0])
            & sixteen(simd, &set_up.nearness, group).simd_ge(whole.nearness);
        let filled = (set_up.count as usize - group * LANES).min(LANES);
        for lane in bits_of(overlap.to_bitmask() & ((1 << filled) - 1)) {
            let triangle = group * LANES + lane;
            let bounds = SplatBox::new(simd, &set_up.bounds(triangle));
            let mut slots = part.boxes.reached(simd, &bounds).to_bitmask() as u16 & alive;
            if slots.count_ones() > MOST_UNTESTED {
                let [a, b, c] = set_up.quads(triangle);
                slots &= may_touch(simd, &[*a, *b, *c], &part.boxes);
            }
            let pairs = lanes | u32x16::splat(simd, (triangle * LANES) as u32);
            let pairs = pairs.compress(mask32x16::from_bitmask(simd, slots.into()));
            pairs.store_slice(&mut queue[end..end + LANES]);
            end += slots.count_ones() as usize;
        }
    }
    end
}

/// What the filter alone says about a point and a triangle, for `validate`.
pub(crate) enum Verdict {
    /// The triangle shadows the point for certain.
    Shadowed,
    /// It doesn't, for this reason.
    NotShadowed(&'static str),
    /// The predicate has to say.
    Undecided,
}

impl Tracer<'_> {
    /// The patch of each triangle, and where in that it is.
    pub(crate) fn slots_of_triangles(&self) -> HashMap<u32, (usize, usize)> {
        let patches = 0..self.patches.len();
        let of_patch = |number| {
            let patch = self.patches.get(number);
            patch.ids[..patch.count].iter().enumerate().map(move |(slot, &id)| (id, (number, slot)))
        };
        patches.flat_map(of_patch).collect()
    }

    /// Forgets what was set up for another tile's [`verdict`](Self::verdict).
    pub(crate) fn forget(&self, worker: &mut Worker) {
        worker.batch.set_ups.clear();
    }

    /// What the filter says about a triangle, which is at this place among the patches, and the point in a lane of a slot of a
    /// part; after candidates were found for this part alone.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a point and a triangle, each by where it is")]
    pub(crate) fn verdict<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        part: usize,
        slot: usize,
        lane: usize,
        id: u32,
        place: Option<(usize, usize)>,
    ) -> Verdict {
        let Worker { tile, parts, batch, .. } = worker;
        let Tile { first, extent, blocks, .. } = tile;
        let part = &parts.parts[part];
        let points = PartPoints::new(part, *first, blocks, &[0; TILE_BLOCKS], self.settler.image.seen);
        let of_record = |record: &Record| {
            let [a, b, c] = &record.quads;
            let found = points.test(simd, [a, b, c], record.id, slot);
            if may_touch(simd, &record.quads, &part.boxes) >> slot & 1 == 0 || found.possible >> lane & 1 == 0 {
                Verdict::NotShadowed("the filter says that it doesn't")
            } else if found.certain(simd, record.errors) >> lane & 1 == 1 {
                Verdict::Shadowed
            } else {
                Verdict::Undecided
            }
        };
        let mut large = batch.large.iter().filter(|(record, _)| record.id == id);
        if let Some((first, _)) = large.next() {
            // Of two planes one may be turned the wrong way.
            return match (of_record(first), large.next()) {
                (Verdict::NotShadowed(_), Some((second, _))) => of_record(second),
                (verdict, _) => verdict,
            };
        }
        let Some((number, triangle)) = place else { return Verdict::NotShadowed("it is in no patch") };
        if !batch.candidates.iter().any(|candidate| candidate.number as usize == number) {
            return Verdict::NotShadowed("it is in no candidate");
        }
        let Batch { set_ups, queue, .. } = batch;
        // Most that are asked about in a row are of the same patch.
        if set_ups.first().is_none_or(|set_up| set_up.number as usize != number) {
            set_ups.resize(1, SetUp::EMPTY);
            self.set_up(simd, &mut set_ups[0], number as u32, extent);
        }
        let set_up = &set_ups[0];
        let whole = SplatBox::new(simd, &part.whole);
        queue.resize(QUEUE, 0);
        let end = enqueue(simd, set_up, part, &whole, 1 << slot, queue);
        if !queue[..end].contains(&((triangle * LANES + slot) as u32)) {
            return Verdict::NotShadowed("its bounds are elsewhere");
        }
        of_record(&set_up.record(triangle, id))
    }
}
