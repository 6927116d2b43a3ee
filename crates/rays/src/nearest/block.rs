use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

use super::far::Place;
use super::filter::SixteenTriangles;
use super::measure::measure;
use super::settle::{Answer, Settle, is_nearer_than};
use super::{Job, Wanted};
use crate::patches::SixteenBoxes;
use crate::simd::lanes::{LANES, bits_of, load, load_positions, quads, splat};
use crate::vectorized;

/// The largest number of points that are answered together: neighbours along a curve.
pub(super) const BLOCK: usize = 64;

/// A block that is this large for its number of points is divided: the square of its box's diagonal for each point, where
/// patches have a size of about one sixteenth.
const WIDE: f32 = 4.0;

/// The number of candidates at which those that have been overtaken are dropped.
const MANY_CANDIDATES: usize = 1 << 12;

/// More than the rounding errors of a squared distance, of itself.
const OF_SQUARE: f32 = 1.0 + 16.0 / (1 << 24) as f32;

/// More than a square loses to underflow.
const SMALLEST_SQUARE: f32 = 1e-36;

/// The memory of a thread for finding the nearest triangles of blocks of points.
///
/// A block walks down the tree to the patches that may be nearest to any of its points, nearest first. A patch that is nearer
/// to some points than the nearest triangle known is scaled, and its triangles are tested sixteen at a time with these.
#[derive(Debug)]
pub(super) struct BlockWorker {
    pub(super) positions: [Vec3; BLOCK],
    /// Scaled coordinates of the points, axis by axis.
    pub(super) points: [[f32; BLOCK]; 3],
    /// Upper bounds of the points' distances from the nearest triangle.
    most: [f32; BLOCK],
    /// The squares of these, rounded up; below zero for slots without a point.
    squares: [f32; BLOCK],
    /// Slots with a finite point.
    pub(super) filled: u64,
    /// The largest of the squares: farther boxes don't matter to any point.
    farthest: f32,
    /// A patch's vertices.
    pub(super) vertices: Vec<[f32; 4]>,
    pub(super) candidates: Vec<Candidate>,
    /// Triangles that may be the nearest to a far point, with lower bounds of a measure of its distance.
    pub(super) far_found: Vec<(f64, u32)>,
    settle: Settle,
}

/// A triangle that may be the nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) slot: u32,
    pub(super) id: u32,
    /// Lower bound of its distance.
    pub(super) least: f32,
}

/// The scaled box around a block's points.
pub(super) struct Around {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl Default for BlockWorker {
    fn default() -> Self {
        Self {
            positions: [Vec3::ZERO; BLOCK],
            points: [[0.0; BLOCK]; 3],
            most: [0.0; BLOCK],
            squares: [0.0; BLOCK],
            filled: 0,
            farthest: 0.0,
            vertices: Vec::new(),
            candidates: Vec::new(),
            far_found: Vec::new(),
            settle: Settle::default(),
        }
    }
}

impl BlockWorker {
    /// Answers points, given by the lower halves of `order`: at most [`BLOCK`].
    pub(super) fn answer<S: Simd>(&mut self, simd: S, job: &Job<'_>, order: &[u64], answers: &mut [Answer]) {
        let (around, far) = self.fill(job, order, job.place);
        if self.is_wide(&around) {
            let middle = order.len() / 2;
            let (low, high) = answers.split_at_mut(middle);
            self.answer(simd, job, &order[..middle], low);
            self.answer(simd, job, &order[middle..], high);
            return;
        }
        self.find_candidates(simd, job, &around);
        if let Some(place) = job.place {
            for slot in bits_of(far) {
                self.find_far(job, place, slot);
            }
        }
        self.drop_overtaken();
        self.settle.choose(job.triangles, &self.positions, &self.candidates);
        self.settle.write(job, &self.positions, answers);
    }

    /// Forgets the triangles of an earlier query.
    pub(super) fn forget(&mut self) {
        self.settle.hint = None;
    }

    /// Lists the triangles that are near enough to points, in ascending order.
    pub(super) fn list<S: Simd>(&mut self, simd: S, job: &Job<'_>, order: &[u64], lists: &mut [Vec<u32>]) {
        let (around, _) = self.fill(job, order, None);
        if self.is_wide(&around) {
            let middle = order.len() / 2;
            let (low, high) = lists.split_at_mut(middle);
            self.list(simd, job, &order[..middle], low);
            self.list(simd, job, &order[middle..], high);
            return;
        }
        self.find_candidates(simd, job, &around);
        for &Candidate { slot, id, .. } in &self.candidates {
            let corners = job.triangles.corners(id);
            if is_nearer_than(
                job.max,
                self.positions[slot as usize],
                corners,
                &measure(self.positions[slot as usize], corners),
            ) {
                lists[slot as usize].push(id);
            }
        }
        lists.iter_mut().for_each(|list| list.sort_unstable());
    }

    /// Whether a block is so wide that its halves take less time.
    fn is_wide(&self, around: &Around) -> bool {
        let count = self.filled.count_ones();
        count > 1 && around.diagonal_squared() > WIDE * count as f32
    }

    fn find_candidates<S: Simd>(&mut self, simd: S, job: &Job<'_>, around: &Around) {
        self.candidates.clear();
        if self.filled != 0 {
            vectorized!(simd => self.begin(simd, job));
            self.descend(simd, job, around, (job.boxes.top(), 0));
        }
    }

    /// Scales the points of a block, and finds the box around them. Returns the slots of those far from a place, which are
    /// left out.
    pub(super) fn fill(&mut self, job: &Job<'_>, order: &[u64], place: Option<&Place>) -> (Around, u64) {
        let mut far = 0;
        let mut around = Around { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };
        (self.filled, self.squares) = (0, [-1.0; BLOCK]);
        for (slot, &key) in order.iter().enumerate().take(BLOCK) {
            let point = job.points[key as u32 as usize];
            if !point.is_finite() {
                continue;
            }
            self.positions[slot] = point;
            if place.is_some_and(|place| place.is_far(point)) {
                far |= 1 << slot;
                continue;
            }
            self.filled |= 1 << slot;
            self.squares[slot] = 0.0;
            for (axis, coordinate) in (point * job.scale).to_array().into_iter().enumerate() {
                self.points[axis][slot] = coordinate;
                around.low[axis] = around.low[axis].min(coordinate);
                around.high[axis] = around.high[axis].max(coordinate);
            }
        }
        (around, far)
    }

    /// Begins with the query's largest distance, or that from a corner of the triangle that was nearest to an earlier point.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, simd: S, job: &Job<'_>) {
        let [x, y, z] = self.settle.hint.map_or([f32::INFINITY; 3], |hint| (hint * job.scale).to_array());
        let most = splat(simd, job.most);
        for start in (0..BLOCK).step_by(LANES) {
            let slots = start..start + LANES;
            let [px, py, pz] = self.load_points(simd, start);
            let (x, y, z) = (px - splat(simd, x), py - splat(simd, y), pz - splat(simd, z));
            let square = x.mul_add(x, y.mul_add(y, z * z));
            let distance = (square * OF_SQUARE + SMALLEST_SQUARE).sqrt() * OF_SQUARE;
            // Infinite where it is NaN, as from a corner that overflows where it is scaled.
            let distance = distance.simd_lt(most).select(distance, most);
            let squares = f32x16::from_slice(simd, &self.squares[slots.clone()]);
            let above = distance * distance * OF_SQUARE + SMALLEST_SQUARE;
            let squares = squares.simd_lt(splat(simd, 0.0)).select(squares, above);
            distance.store_slice(&mut self.most[slots.clone()]);
            squares.store_slice(&mut self.squares[slots]);
        }
        self.find_farthest(simd);
    }

    #[inline(always)]
    pub(super) fn load_points<S: Simd>(&self, simd: S, start: usize) -> [f32x16<S>; 3] {
        let [x, y, z] = &self.points;
        let slots = start..start + LANES;
        [
            f32x16::from_slice(simd, &x[slots.clone()]),
            f32x16::from_slice(simd, &y[slots.clone()]),
            f32x16::from_slice(simd, &z[slots]),
        ]
    }

    /// Visits the patches below a node of the tree, from the nearest to the farthest.
    fn descend<S: Simd>(&mut self, simd: S, job: &Job<'_>, around: &Around, (level, number): (usize, usize)) {
        let (boxes, count) = job.boxes.node(job.patches, level, number);
        let (near, squares) = vectorized!(simd => around.near(simd, job.scale, self.farthest, boxes));
        let mut order = [0_u64; LANES];
        let mut len = 0;
        for lane in bits_of(near & (u16::MAX >> (LANES - count))) {
            // Squares aren't negative, so they are in the order of their bits.
            order[len] = u64::from(squares[lane].to_bits()) << 32 | lane as u64;
            len += 1;
        }
        order[..len].sort_unstable();
        for &key in &order[..len] {
            if f32::from_bits((key >> 32) as u32) > self.farthest {
                break;
            }
            let below = number * LANES + key as u32 as usize;
            if level == 0 {
                vectorized!(simd => self.visit(simd, job, below));
            } else {
                self.descend(simd, job, around, (level - 1, below));
            }
        }
    }

    #[inline(always)]
    fn find_farthest<S: Simd>(&mut self, simd: S) {
        let mut farthest = splat(simd, -1.0);
        for start in (0..BLOCK).step_by(LANES) {
            farthest = farthest.max(f32x16::from_slice(simd, &self.squares[start..start + LANES]));
        }
        self.farthest = farthest.reduce_max();
    }

    /// Takes a patch if it is near to any point.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, job: &Job<'_>, number: usize) {
        let [low, high] = job.patches.bounds.sixteens[number / LANES].get(number);
        let scale = job.scale;
        let low = [low[0] * scale, low[1] * scale, low[2] * scale];
        let near = self.near(simd, [low, [high[0] * scale, high[1] * scale, high[2] * scale]]);
        if near != 0 {
            self.take(simd, job, number, near);
            self.find_farthest(simd);
        }
    }

    /// The slots of points to which a box is as near as the nearest triangle known; a box of NaN is near to all.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, [low, high]: [[f32; 3]; 2]) -> u64 {
        let zero = splat(simd, 0.0);
        let [low_x, low_y, low_z] = [splat(simd, low[0]), splat(simd, low[1]), splat(simd, low[2])];
        let [high_x, high_y, high_z] = [splat(simd, high[0]), splat(simd, high[1]), splat(simd, high[2])];
        let mut near = 0;
        for start in (0..BLOCK).step_by(LANES) {
            let [px, py, pz] = self.load_points(simd, start);
            let x = (low_x - px).max(px - high_x).max(zero);
            let y = (low_y - py).max(py - high_y).max(zero);
            let z = (low_z - pz).max(pz - high_z).max(zero);
            let square = x.mul_add(x, y.mul_add(y, z * z));
            let is_far = square.simd_gt(f32x16::from_slice(simd, &self.squares[start..start + LANES]));
            near |= (!is_far.to_bitmask() & 0xffff) << start;
        }
        near & self.filled
    }

    /// Scales a patch's vertices. One that isn't finite becomes NaN.
    #[inline(always)]
    pub(super) fn scale_vertices<S: Simd>(&mut self, simd: S, job: &Job<'_>, number: usize) {
        let (scale, zero, nan) = (splat(simd, job.scale), splat(simd, 0.0), splat(simd, f32::NAN));
        self.vertices.clear();
        for positions in job.patches.positions(number) {
            let [x, y, z] = load_positions(simd, positions);
            // Zero times NaN or infinity is NaN.
            let is_finite = (x * zero + y * zero + z * zero).simd_eq(zero);
            let [a, b, c, d] = quads([is_finite.select(x * scale, nan), y * scale, z * scale, zero]);
            for quads in [a, b, c, d] {
                let quads: [f32; LANES] = quads.into();
                self.vertices.extend_from_slice(quads.as_chunks().0);
            }
        }
    }

    /// Tests the triangles of a patch with the points that it is near to.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, job: &Job<'_>, number: usize, near: u64) {
        self.scale_vertices(simd, job, number);
        let patch = job.patches.get(number);
        for (sixteen, corners) in patch.corners.chunks_exact(LANES).enumerate() {
            let first = sixteen * LANES;
            let triangles = SixteenTriangles::new(simd, &self.vertices, corners, patch.count - first);
            for slot in bits_of(near & self.near(simd, triangles.bounds)) {
                let point = [self.points[0][slot], self.points[1][slot], self.points[2][slot]];
                let distances = triangles.distances(simd, point);
                let most = splat(simd, self.most[slot]);
                let mut near = distances.least.simd_le(most).to_bitmask() as u16 & triangles.filled;
                if near == 0 {
                    continue;
                }
                let nearest = distances.most.min(most).reduce_min();
                if nearest < self.most[slot] && job.wanted == Wanted::Nearest {
                    self.most[slot] = nearest;
                    self.squares[slot] = nearest * nearest * OF_SQUARE + SMALLEST_SQUARE;
                    near &= distances.least.simd_le(splat(simd, nearest)).to_bitmask() as u16;
                }
                let least: [f32; LANES] = distances.least.into();
                for lane in bits_of(near) {
                    let candidate = Candidate { slot: slot as u32, id: patch.ids[first + lane], least: least[lane] };
                    self.candidates.push(candidate);
                }
            }
            if self.candidates.len() > MANY_CANDIDATES && job.wanted == Wanted::Nearest {
                self.reduce(job);
            }
        }
    }

    /// Drops candidates, so that copies of a triangle don't fill the memory.
    #[cold]
    #[inline(never)]
    fn reduce(&mut self, job: &Job<'_>) {
        self.drop_overtaken();
        if self.candidates.len() > MANY_CANDIDATES / 2 {
            self.settle.choose(job.triangles, &self.positions, &self.candidates);
            self.candidates.clear();
            self.candidates.extend(self.settle.chosen());
        }
    }

    fn drop_overtaken(&mut self) {
        let Self { candidates, most, .. } = self;
        candidates.retain(|candidate| candidate.least <= most[candidate.slot as usize]);
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.vertices.capacity() * size_of::<[f32; 4]>()
            + self.candidates.capacity() * size_of::<Candidate>()
            + self.far_found.capacity() * size_of::<(f64, u32)>()
            + self.settle.bytes()
    }
}

impl Around {
    /// NaN where coordinates overflow.
    fn diagonal_squared(&self) -> f32 {
        (0..3).map(|axis| self.high[axis] - self.low[axis]).map(|side| side * side).sum()
    }

    /// Returns a mask of the boxes, of sixteen, that aren't certainly farther than a squared distance, and squared distances.
    /// Those of boxes of NaN are zero.
    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, scale: f32, farthest: f32, boxes: &SixteenBoxes) -> (u16, [f32; LANES]) {
        let (scale, zero) = (splat(simd, scale), splat(simd, 0.0));
        let mut square = zero;
        for axis in 0..3 {
            let above = load(simd, &boxes.low[axis]) * scale - splat(simd, self.high[axis]);
            let below = splat(simd, self.low[axis]) - load(simd, &boxes.high[axis]) * scale;
            let gap = above.max(below).max(zero);
            square = gap.mul_add(gap, square);
        }
        let is_far = square.simd_gt(splat(simd, farthest));
        let square = square.simd_gt(zero).select(square, zero);
        (!(is_far.to_bitmask() as u16), square.into())
    }
}
