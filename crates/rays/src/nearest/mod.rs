//! Nearest points: how far is the nearest surface?
//!
//! Points are sorted along a curve, so that blocks of them are near each other, and a thread takes a block from its points to
//! their answers. A block lists the [patches](crate::patches) that may be nearest to any of its points, by the tree of boxes
//! that scans have as well. A filter in f32 bounds the distances of a point from sixteen triangles at once. f64 bounds those
//! of the few that are left, and [`exact`] arithmetic decides between triangles that are as near as f64 can tell. So the
//! choice of triangle is that of real numbers.
//!
//! One subject a file: `block` finds candidates for a block of points, `filter` bounds distances in f32, `measure` in f64,
//! `settle` chooses, `exact` compares, with numbers that are `bounded` or `integer`.

mod answers;
mod block;
mod bounded;
mod exact;
mod filter;
mod integer;
mod measure;
mod settle;

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::Vec3;
use rayon::prelude::*;

pub use answers::{Closest, ClosestPoints};
use block::{BLOCK, BlockWorker};
use settle::Answer;

use crate::dispatch;
use crate::parallel::{Parallel, both};
use crate::patches::{BoxTree, Order, Patches};
use crate::{Omitted, SimdLevel, Triangles};

/// Finds the [nearest points](Closest) of triangles, rebuilt for every frame.
///
/// Keep it and use it again: its memory is reused. It holds about 23 bytes a triangle and 68 a point.
///
/// ```
/// use glam::{DVec3, Vec3};
/// use umbrage_rays::{Closest, ClosestPoints, Nearest, Triangles};
///
/// // A square in the plane y = 0.
/// let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
/// let triangles = Triangles { positions: &positions, indices: &[[0, 1, 2], [0, 2, 3]] };
/// let (mut nearest, mut closest) = (Nearest::default(), ClosestPoints::default());
/// // For each frame:
/// nearest.build(triangles);
/// let points = [Vec3::new(0.5, 2.0, -0.25), Vec3::new(-4.0, 0.0, 5.0), Vec3::new(0.0, -9.0, 0.0), Vec3::NAN];
/// nearest.closest_points(&Closest { max: 8.0, ..Closest::new(triangles, &points) }, &mut closest);
/// assert_eq!(closest.distance, [2.0, 5.0, f64::INFINITY, f64::INFINITY]);
/// assert_eq!(closest.triangle, [0, 1, ClosestPoints::NONE, ClosestPoints::NONE]);
/// assert_eq!(closest.position[1], DVec3::new(-1.0, 0.0, 1.0));
/// assert_eq!(closest.barycentric[1], [0.0, 1.0]);
/// assert_eq!(closest.nowhere, 1);
/// ```
#[derive(Default)]
pub struct Nearest {
    level: SimdLevel,
    patches: Patches,
    boxes: BoxTree,
    /// Factor for lengths in f32: a power of two.
    scale: f32,
    order: Order,
    /// The answers in the order of the curve.
    answers: Vec<Answer>,
    /// The index in `answers` of each point.
    ranks: Vec<AtomicU32>,
    workers: Mutex<Vec<BlockWorker>>,
}

debug_some!(Nearest as nearest: "patches" => nearest.patches.len());

/// The number of points that a thread takes at once.
const CHUNK: usize = 16 * BLOCK;

impl Nearest {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Updates it for the triangles of a frame; call it before any query about them.
    pub fn build(&mut self, triangles: Triangles<'_>) {
        self.patches.update(triangles, self.level);
        self.boxes.find(&self.patches);
        self.scale = scale(&self.patches, self.boxes.reach);
    }

    /// The triangles that no ray can hit, as of the last [`build`](Self::build). Of these, nearest points may be on triangles
    /// without area.
    #[must_use]
    pub fn omitted(&self) -> &Omitted {
        self.patches.omitted()
    }

    /// Finds the nearest point of all triangles for each point.
    ///
    /// # Panics
    /// If it was built for another number of triangles, or there are 2³² points or more.
    pub fn closest_points(&mut self, closest: &Closest<'_>, found: &mut ClosestPoints) {
        let Closest { triangles, points, max } = *closest;
        self.patches.expect(triangles);
        assert!(u32::try_from(points.len()).is_ok(), "{} points at once", points.len());
        found.resize(points.len());
        let Self { level, patches, boxes, scale, order, answers, ranks, workers } = self;
        answers.resize(points.len(), Answer::NONE);
        ranks.resize_with(points.len(), AtomicU32::default);
        for worker in workers.get_mut().unwrap_or_else(PoisonError::into_inner) {
            worker.forget();
        }
        // Rounded up.
        let most = (max * f64::from(*scale)) as f32 * (1.0 + 4.0 * f32::EPSILON) + f32::MIN_POSITIVE;
        let job = Job { level: *level, triangles, points, max, patches, boxes, scale: *scale, most, ranks, workers };
        let order = order.sort_points(points);
        if max > 0.0 && patches.len() > 0 {
            job.answer(order, 0, answers);
        } else {
            job.rank(order, 0);
            answers.fill(Answer::NONE);
        }
        let ClosestPoints { triangle, barycentric, position, distance, nowhere } = found;
        let answers = &*answers;
        let slots = triangle.par_iter_mut().zip(barycentric).zip(position.par_iter_mut().zip(distance));
        slots.zip(&*ranks).each(|(((triangle, barycentric), (position, distance)), rank)| {
            let answer = answers[rank.load(Ordering::Relaxed) as usize];
            *triangle = answer.triangle;
            *barycentric = answer.barycentric;
            *position = answer.position;
            *distance = answer.distance;
        });
        let is_nowhere = |points: &[Vec3]| points.iter().filter(|point| !point.is_finite()).count();
        *nowhere = points.par_chunks(CHUNK).map(is_nowhere).merge(|one, other| one + other).unwrap_or(0);
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let workers = self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        self.patches.bytes()
            + self.boxes.bytes()
            + self.order.bytes()
            + self.answers.capacity() * size_of::<Answer>()
            + self.ranks.capacity() * size_of::<AtomicU32>()
            + workers.iter().map(BlockWorker::bytes).sum::<usize>()
    }
}

/// The inputs of finding nearest triangles.
struct Job<'a> {
    level: SimdLevel,
    triangles: Triangles<'a>,
    points: &'a [Vec3],
    /// Triangles at this distance or farther don't count.
    max: f64,
    /// The same scaled, rounded up.
    most: f32,
    patches: &'a Patches,
    boxes: &'a BoxTree,
    scale: f32,
    ranks: &'a [AtomicU32],
    workers: &'a Mutex<Vec<BlockWorker>>,
}

impl Job<'_> {
    /// Answers the points of `order`, which begins at index `first`, in halves for other threads to share.
    fn answer(&self, order: &[u64], first: usize, answers: &mut [Answer]) {
        if order.len() > CHUNK {
            let middle = (order.len() / 2).next_multiple_of(BLOCK);
            let (low, high) = answers.split_at_mut(middle);
            both(|| self.answer(&order[..middle], first, low), || self.answer(&order[middle..], first + middle, high));
            return;
        }
        self.rank(order, first);
        let workers = || self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        let mut worker = workers().pop().unwrap_or_default();
        for (order, answers) in order.chunks(BLOCK).zip(answers.chunks_mut(BLOCK)) {
            dispatch!(self.level, simd => worker.answer(simd, self, order, answers));
        }
        workers().push(worker);
    }

    fn rank(&self, order: &[u64], first: usize) {
        for (rank, &key) in (first as u32..).zip(order) {
            self.ranks[key as u32 as usize].store(rank, Ordering::Relaxed);
        }
    }
}

/// The power of two that makes the median size of patches about one sixteenth, so that distances in the scene are about
/// one. Only few patches reach a vertex that is far away.
fn scale(patches: &Patches, reach: f32) -> f32 {
    const SAMPLES: usize = 64;
    let mut sizes = [0.0_f32; SAMPLES];
    let every = patches.len().div_ceil(SAMPLES).max(1);
    let mut count = 0;
    for number in (0..patches.len()).step_by(every) {
        let [low, high] = patches.bounds.sixteens[number / 16].get(number);
        let size = (0..3).fold(0.0_f32, |size, axis| size.max(high[axis] - low[axis]));
        if size.is_normal() {
            sizes[count] = size;
            count += 1;
        }
    }
    let sizes = &mut sizes[..count];
    let length = if count > 0 { *sizes.select_nth_unstable_by(count / 2, f32::total_cmp).1 } else { reach };
    // From the exponent, without rounding.
    let exponent = (length.to_bits() >> 23) as i32;
    f32::from_bits((250 - exponent).clamp(4, 250) as u32 * (1 << 23))
}
