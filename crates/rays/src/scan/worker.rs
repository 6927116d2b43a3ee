use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, mask32x16};
use glam::DVec3;

use super::cull::{Frustum, nearest_of};
use super::lines::{Face, Lines};
use super::slots::{Slots, Taken};
use super::test::{Beam, LineTests, test};
use super::{Asked, Job, NearestAt};
use crate::Hit;
use crate::patches::{MOST_VERTICES, Patch};
use crate::shear::SMALLEST;
use crate::simd::lanes::{
    LANES, all_transposed, bits_of, load, load_local_corner, load_positions, quads, splat, transposed,
};
use crate::simd::vectors::{narrow, widen};
use crate::vectorized;

/// Patches whose pairs are tested together.
const POOL: usize = 8;

/// The fewest lines that a single triangle is tested with.
const FEWEST: u32 = 5;

/// Depths at or below which a corner counts as beside or behind the lines' origin.
const LEAST_DEPTH: f32 = 1e-12;

/// The memory of a thread for tracing tiles.
#[derive(Debug, Default)]
pub(super) struct ScanWorker {
    pub(super) slots: Slots,
    found: Vec<u64>,
    /// Corners of patches, in the form for [`test`].
    vertices: Vec<[f32; 4]>,
    pairs: Vec<Pair>,
    pub(super) candidates: Vec<HitCandidate>,
    pub(super) settle: super::settle::Settle,
    /// Hits of lines, given by their indices in all sweeps, nearest first for each.
    pub(super) hits: Vec<(usize, Hit)>,
    /// Lines that are hit at all, given in the same way.
    pub(super) met: Vec<usize>,
    /// Lines of the tile that are certainly hit.
    pub(super) met_slots: Vec<u32>,
    /// The number of lines that go nowhere.
    pub(super) nowhere: usize,
}

/// A line and a triangle, whose corners are indices of the vertices.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    slot: u32,
    id: u32,
    corners: [u16; 3],
}

/// A triangle that a line may hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct HitCandidate {
    pub(super) slot: u16,
    /// Whether the line certainly hits it, and is stopped.
    pub(super) is_certain: bool,
    pub(super) id: u32,
    /// Lower bound of the hit's depth.
    pub(super) earliest: f32,
}

/// Bounds of sixteen triangles on the face, and their nearest depths.
struct Around {
    low: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    nearest: [f32; LANES],
    /// Triangles that may meet a line of the tile.
    alive: u16,
}

impl ScanWorker {
    /// Answers a tile's lines, given by their indices in their sweep: the nearest hits, where these are asked for, come to
    /// `nearest`.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        lines: &Lines<'_>,
        order: &[u32],
        mut nearest: NearestAt<'_>,
    ) {
        let mut first = 0;
        while first < order.len() {
            let mut end = order.len();
            let taken = loop {
                match vectorized!(simd => self.slots.take(simd, lines, &order[first..end])) {
                    Taken::Apart => end = first + (end - first).div_ceil(2),
                    taken => break taken,
                }
            };
            self.nowhere += self.slots.nowhere;
            let mut nearest = nearest.take(job.asked, end - first);
            match taken {
                Taken::On(face, frustum) => {
                    self.trace_taken(simd, job, lines, &face, &frustum);
                    self.settle(job, lines, &order[first..end], nearest);
                }
                Taken::Nowhere | Taken::Apart => nearest.miss(),
            }
            first = end;
        }
    }

    /// Finds the candidates of the taken lines.
    #[inline(always)]
    fn trace_taken<S: Simd>(&mut self, simd: S, job: &Job<'_>, lines: &Lines<'_>, face: &Face, frustum: &Frustum) {
        let mut found = std::mem::take(&mut self.found);
        frustum.find_in(simd, job.boxes, job.patches, &mut found);
        self.candidates.clear();
        self.met_slots.clear();
        self.pairs.clear();
        self.vertices.clear();
        let scale = lines.scale as f32;
        for &of in &found {
            let farthest = vectorized!(simd => self.slots.farthest(simd));
            if nearest_of(of) * scale > farthest {
                break;
            }
            vectorized!(simd => self.take(simd, job, lines, face, of as u32 as usize, farthest));
        }
        vectorized!(simd => self.flush(simd, job));
        self.found = found;
    }

    /// Tests a patch's triangles against the lines that they may meet.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, job: &Job<'_>, lines: &Lines<'_>, face: &Face, number: usize, farthest: f32) {
        if self.vertices.len() > (POOL - 1) * MOST_VERTICES {
            self.flush(simd, job);
        }
        let first = self.vertices.len();
        self.project(simd, job, lines, face, number);
        let patch = job.patches.get(number);
        for group in 0..patch.count.div_ceil(LANES) {
            let corners = &patch.corners[group * LANES..(group + 1) * LANES];
            let of = &self.vertices[first..];
            let loaded = [
                load_local_corner(simd, of, corners, 0),
                load_local_corner(simd, of, corners, 1),
                load_local_corner(simd, of, corners, 2),
            ];
            let filled = (patch.count - group * LANES).min(LANES);
            let around = self.bound(simd, &loaded, filled, farthest);
            for lane in bits_of(around.alive) {
                self.find_lines(simd, job, &patch, (group * LANES + lane, lane), first, &around);
            }
        }
    }

    /// Transforms a patch's vertices to coordinates of the tile.
    #[inline(always)]
    fn project<S: Simd>(&mut self, simd: S, job: &Job<'_>, lines: &Lines<'_>, face: &Face, number: usize) {
        let [i, j, k] = face.axes;
        let slope = self.slots.slope;
        let origin: DVec3 = lines.origin;
        for positions in job.patches.positions(number) {
            let [low, high] = widen(load_positions(simd, positions));
            let along = lines.scale * face.sign;
            let (low_z, high_z) = ((low[k] - origin[k]) * along, (high[k] - origin[k]) * along);
            let low_x = (low[i] - origin[i]) * lines.scale - low_z * slope[0];
            let high_x = (high[i] - origin[i]) * lines.scale - high_z * slope[0];
            let low_y = (low[j] - origin[j]) * lines.scale - low_z * slope[1];
            let high_y = (high[j] - origin[j]) * lines.scale - high_z * slope[1];
            let [x, y, z] = narrow([low_x, low_y, low_z], [high_x, high_y, high_z]);
            let start = self.vertices.len();
            self.vertices.resize(start + LANES, [0.0; 4]);
            let interleaved = quads([x, y, z, splat(simd, 0.0)]);
            let to = self.vertices[start..].as_flattened_mut().chunks_exact_mut(LANES);
            for (quad, to) in interleaved.into_iter().zip(to) {
                quad.store_slice(to);
            }
        }
    }

    /// Finds the bounds of sixteen triangles. The error bounds are those of [`LineTests`]: a corner's x / z is wrong by less
    /// than 4 ε of itself, a line's u by ε, and the error of both in f64 is below 2⁻²⁶ H.
    #[inline(always)]
    fn bound<S: Simd>(&self, simd: S, corners: &[[f32x16<S>; 3]; 3], filled: usize, farthest: f32) -> Around {
        const EPSILON: f32 = 1.0 / (1 << 24) as f32;
        let Slots { wide, low, high, .. } = &self.slots;
        let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
        let one = splat(simd, 1.0);
        let (nearest, last) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
        let (i0, i1, i2) = (one / z0, one / z1, one / z2);
        let (u0, u1, u2) = (x0 * i0, x1 * i1, x2 * i2);
        let (v0, v1, v2) = (y0 * i0, y1 * i1, y2 * i2);
        let (low_u, high_u) = (u0.min(u1).min(u2), u0.max(u1).max(u2));
        let (low_v, high_v) = (v0.min(v1).min(v2), v0.max(v1).max(v2));
        // NaN in any of them makes this NaN too.
        let all = u0.abs() + u1.abs() + u2.abs() + (v0.abs() + v1.abs() + v2.abs()) + (z0.abs() + z1.abs() + z2.abs());
        let is_ahead = all.simd_lt(splat(simd, 1e30)) & nearest.simd_gt(splat(simd, LEAST_DEPTH));
        let mut is_gone = nearest.simd_gt(splat(simd, farthest)) | last.simd_lt(splat(simd, 0.0));
        let of_wide = splat(simd, *wide / (1 << 26) as f32);
        let margin_u = low_u.abs().max(high_u.abs()) * (8.0 * EPSILON) + of_wide;
        let margin_v = low_v.abs().max(high_v.abs()) * (8.0 * EPSILON) + of_wide;
        let infinity = splat(simd, f32::INFINITY);
        let low_u = is_ahead.select(low_u - margin_u, -infinity);
        let high_u = is_ahead.select(high_u + margin_u, infinity);
        let low_v = is_ahead.select(low_v - margin_v, -infinity);
        let high_v = is_ahead.select(high_v + margin_v, infinity);
        is_gone |= low_u.simd_gt(splat(simd, high[0]))
            | high_u.simd_lt(splat(simd, low[0]))
            | low_v.simd_gt(splat(simd, high[1]))
            | high_v.simd_lt(splat(simd, low[1]));
        is_gone |= all_beside(simd, *wide, corners);
        // The rounding of depths is smaller than this.
        let nearest = nearest - nearest.abs() * (16.0 * EPSILON);
        let alive = !(is_gone.to_bitmask() as u16) & ((1_u32 << filled) - 1) as u16;
        Around {
            low: [low_u.into(), low_v.into()],
            high: [high_u.into(), high_v.into()],
            nearest: nearest.into(),
            alive,
        }
    }

    /// Finds the lines that a triangle may meet, and tests it against them.
    #[inline(always)]
    fn find_lines<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        patch: &Patch<'_>,
        (triangle, lane): (usize, usize),
        first: usize,
        around: &Around,
    ) {
        let id = patch.ids[triangle];
        if job.is_hidden(id) {
            return;
        }
        let [a, b, c, _] = patch.corners[triangle].map(|corner| (first + usize::from(corner)) as u16);
        let corners = [a, b, c];
        let ends = [around.low[0][lane], around.high[0][lane], around.low[1][lane], around.high[1][lane]];
        let nearest = around.nearest[lane];
        let [low_u, high_u, low_v, high_v] = ends;
        let blocks = &self.slots.blocks;
        let met = load(simd, &blocks.low[0]).simd_le(splat(simd, high_u))
            & load(simd, &blocks.high[0]).simd_ge(splat(simd, low_u))
            & load(simd, &blocks.low[1]).simd_le(splat(simd, high_v))
            & load(simd, &blocks.high[1]).simd_ge(splat(simd, low_v))
            & load(simd, &blocks.far).simd_ge(splat(simd, nearest));
        for block in bits_of(met.to_bitmask()) {
            self.test_block(simd, job, (id, corners), block, ends, nearest);
        }
    }

    /// Tests a triangle against those of a block's lines that are within its bounds.
    #[inline(always)]
    fn test_block<S: Simd>(
        &mut self,
        simd: S,
        job: &Job<'_>,
        (id, corners): (u32, [u16; 3]),
        block: usize,
        [low_u, high_u, low_v, high_v]: [f32; 4],
        nearest: f32,
    ) {
        let start = block * LANES;
        let slots = start..start + LANES;
        let u = f32x16::from_slice(simd, &self.slots.u[slots.clone()]);
        let v = f32x16::from_slice(simd, &self.slots.v[slots.clone()]);
        let far = f32x16::from_slice(simd, &self.slots.far[slots.clone()]);
        let inside = u.simd_ge(splat(simd, low_u))
            & u.simd_le(splat(simd, high_u))
            & v.simd_ge(splat(simd, low_v))
            & v.simd_le(splat(simd, high_v))
            & far.simd_ge(splat(simd, nearest));
        let lanes = inside.to_bitmask() as u32;
        if lanes.count_ones() < FEWEST {
            for lane in bits_of(lanes) {
                self.pairs.push(Pair { slot: (start + lane) as u32, id, corners });
            }
            return;
        }
        let beam = Beam {
            u,
            v,
            near: f32x16::from_slice(simd, &self.slots.near[slots.clone()]),
            end: f32x16::from_slice(simd, &self.slots.end[slots]),
            far,
        };
        let [[ax, ay, az, _], [bx, by, bz, _], [cx, cy, cz, _]] =
            corners.map(|corner| self.vertices[usize::from(corner)]);
        let corners = [
            [splat(simd, ax), splat(simd, ay), splat(simd, az)],
            [splat(simd, bx), splat(simd, by), splat(simd, bz)],
            [splat(simd, cx), splat(simd, cy), splat(simd, cz)],
        ];
        let found = test(simd, self.slots.wide, &corners, &beam);
        let (possible, certain, earliest, latest) = lanes_of(&found);
        let always = certain != 0 && job.always_stops(id);
        for lane in bits_of(possible & lanes as u16) {
            let is_certain = always && certain >> lane & 1 == 1;
            self.note(job, start + lane, id, is_certain, earliest[lane], latest[lane]);
        }
        if always {
            self.slots.find_far(simd, block);
        }
    }

    /// Tests the waiting pairs, and drops their vertices.
    #[inline(always)]
    fn flush<S: Simd>(&mut self, simd: S, job: &Job<'_>) {
        let mut pairs = std::mem::take(&mut self.pairs);
        let count = pairs.len();
        // Padded with copies of the last pair.
        if let Some(&last) = pairs.last() {
            pairs.resize(count.next_multiple_of(LANES), last);
        }
        for (number, sixteen) in pairs.chunks_exact(LANES).enumerate() {
            let corners = [self.load(simd, sixteen, 0), self.load(simd, sixteen, 1), self.load(simd, sixteen, 2)];
            let mut far = [0.0; LANES];
            for (far, pair) in far.iter_mut().zip(sixteen) {
                *far = self.slots.far[pair.slot as usize];
            }
            let [u, v, near, end] = all_transposed(
                #[inline(always)]
                |lane| f32x4::simd_from(simd, self.slots.quads[sixteen[lane].slot as usize]),
            );
            let beam = Beam { u, v, near, end, far: f32x16::simd_from(simd, far) };
            let found = test(simd, self.slots.wide, &corners, &beam);
            let (possible, certain, earliest, latest) = lanes_of(&found);
            let filled = (count - number * LANES).min(LANES);
            for lane in bits_of(possible & ((1_u32 << filled) - 1) as u16) {
                let Pair { slot, id, .. } = sixteen[lane];
                let is_certain = certain >> lane & 1 == 1 && job.always_stops(id);
                self.note(job, slot as usize, id, is_certain, earliest[lane], latest[lane]);
            }
        }
        pairs.clear();
        self.pairs = pairs;
        self.vertices.clear();
        for block in 0..self.slots.len.div_ceil(LANES) {
            self.slots.find_far(simd, block);
        }
    }

    /// One corner of each of sixteen pairs.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, pairs: &[Pair], corner: usize) -> [f32x16<S>; 3] {
        transposed(
            #[inline(always)]
            |lane| f32x4::simd_from(simd, self.vertices[usize::from(pairs[lane].corners[corner])]),
        )
    }

    #[inline(always)]
    fn note(&mut self, job: &Job<'_>, slot: usize, id: u32, is_certain: bool, earliest: f32, latest: f32) {
        let far = &mut self.slots.far[slot];
        if earliest > *far {
            return;
        }
        match job.asked {
            Asked::Any if is_certain => {
                *far = f32::NEG_INFINITY;
                self.met_slots.push(slot as u32);
                return;
            }
            Asked::Nearest | Asked::NearestIds if is_certain => *far = far.min(latest),
            _ => {}
        }
        self.candidates.push(HitCandidate { slot: slot as u16, is_certain, id, earliest });
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Slots>()
            + self.settle.bytes()
            + self.found.capacity() * size_of::<u64>()
            + self.vertices.capacity() * size_of::<[f32; 4]>()
            + self.pairs.capacity() * size_of::<Pair>()
            + self.candidates.capacity() * size_of::<HitCandidate>()
            + self.hits.capacity() * size_of::<(usize, Hit)>()
            + self.met.capacity() * size_of::<usize>()
            + self.met_slots.capacity() * size_of::<u32>()
    }
}

/// The bits of pairs that may be and certainly are hits, and the bounds of their depths.
#[inline(always)]
fn lanes_of<S: Simd>(found: &LineTests<S>) -> (u16, u16, [f32; LANES], [f32; LANES]) {
    let (possible, certain) = (found.possible.to_bitmask() as u16, found.certain.to_bitmask() as u16);
    (possible, certain, found.earliest.into(), found.latest.into())
}

/// Returns a mask of the triangles, of sixteen, that all lines of a tile miss.
///
/// With [`Sheared`](crate::shear::Sheared)'s names, an edge function is E = x₁ y₂ − x₂ y₁ − u (z₁ y₂ − z₂ y₁) − v (x₁ z₂ − x₂ z₁), and |u| and |v| are
/// at most H. A line misses where two edge functions, or one and the sum of all, have different signs. With
/// s = |x| + |y| + 3 H |z|, which is at least a + H z for each line, rounding of corners and lines moves E by less than
/// 11 ε s₁ s₂, and rounding here by less than 8 ε s₁ s₂: the bound takes δ = 32 ε s₁ s₂ for both.
#[inline(always)]
fn all_beside<S: Simd>(simd: S, wide: f32, corners: &[[f32x16<S>; 3]; 3]) -> mask32x16<S> {
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
    let wide = splat(simd, wide);
    let size0 = x0.abs() + y0.abs() + z0.abs() * wide * 3.0;
    let size1 = x1.abs() + y1.abs() + z1.abs() * wide * 3.0;
    let size2 = x2.abs() + y2.abs() + z2.abs() * wide * 3.0;
    let (middle0, u0, v0, error0) = edge([x1, y1, z1], [x2, y2, z2], size1 * size2);
    let (middle1, u1, v1, error1) = edge([x2, y2, z2], [x0, y0, z0], size2 * size0);
    let (middle2, u2, v2, error2) = edge([x0, y0, z0], [x1, y1, z1], size0 * size1);
    let reach0 = (u0.abs() + v0.abs()).mul_add(wide, error0);
    let reach1 = (u1.abs() + v1.abs()).mul_add(wide, error1);
    let reach2 = (u2.abs() + v2.abs()).mul_add(wide, error2);
    let of_all = ((u0 + u1 + u2).abs() + (v0 + v1 + v2).abs()).mul_add(wide, error0 + error1 + error2);
    let middle = middle0 + middle1 + middle2;
    let any_above =
        middle0.simd_gt(reach0) | middle1.simd_gt(reach1) | middle2.simd_gt(reach2) | middle.simd_gt(of_all);
    let any_below =
        middle0.simd_lt(-reach0) | middle1.simd_lt(-reach1) | middle2.simd_lt(-reach2) | middle.simd_lt(-of_all);
    any_above & any_below
}

/// An edge function's value in the middle, its change along u and v, and its error bound.
#[inline(always)]
fn edge<S: Simd>(
    [x1, y1, z1]: [f32x16<S>; 3],
    [x2, y2, z2]: [f32x16<S>; 3],
    size: f32x16<S>,
) -> (f32x16<S>, f32x16<S>, f32x16<S>, f32x16<S>) {
    const ERROR: f32 = 32.0 / (1 << 24) as f32;
    (x1 * y2 - x2 * y1, z1 * y2 - z2 * y1, x1 * z2 - x2 * z1, size * ERROR + SMALLEST)
}
