//! Nearest points: how far is the nearest surface?
//!
//! Points are sorted along a curve, so that blocks of them are near each other, and a thread takes a block from its points to
//! their answers. A block lists the [patches](crate::patches) that may be nearest to any of its points, by the tree of boxes
//! that scans have as well. A filter in f32 bounds the distances of a point from sixteen triangles at once. f64 bounds those
//! of the few that are left, and [`exact`] arithmetic decides between triangles that are as near as f64 can tell. So the
//! choice of triangle is that of real numbers.
//!
//! One subject a file: `block` finds candidates for a block of points, `filter` bounds distances in f32, `measure` in f64,
//! `settle` chooses, `exact` compares, with numbers that are `bounded` or `integer`. `far` finds
//! candidates for points far away. `inside` counts crossings. `overlap` finds triangles that touch boxes. `winding` sums
//! solid angles: those of near triangles by `solid_angle`, of far ones by expansions, `moments`.

mod answers;
mod block;
mod bounded;
mod exact;
mod far;
mod filter;
mod inside;
mod integer;
mod measure;
mod moments;
mod overlap;
mod settle;
mod solid_angle;
mod winding;

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::Vec3;
use rayon::prelude::*;

pub use answers::{Closest, ClosestPoints, Within};
use block::{BLOCK, BlockWorker};
use far::Place;
use settle::Answer;
use winding::WindingTree;

use crate::curve_order::CurveOrder;
use crate::dispatch;
use crate::parallel::{Parallel, both};
use crate::patches::{BoxTree, Curve, Patches};
use crate::simd::lanes::LANES;
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
    place: Option<Place>,
    order: CurveOrder,
    /// The answers in the order of the curve.
    answers: Vec<Answer>,
    is_inside: Vec<bool>,
    /// The triangles near each point, in the order of the curve.
    lists: Vec<Vec<u32>>,
    /// Whether each point is inside, in the order of the query.
    inside: Vec<bool>,
    /// The index in `answers` of each point.
    ranks: Vec<AtomicU32>,
    workers: Mutex<Vec<BlockWorker>>,
    winding: WindingTree,
    /// Winding numbers in the order of the curve.
    numbers: Vec<f64>,
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
        self.winding.forget();
        let curve = Curve::through_triangles(triangles);
        // Without a patch of finite corners, the cube has some of the others.
        let of_cube = Some(curve.size()).filter(|size| size.is_normal());
        let size = typical_size(&self.patches).or(of_cube).unwrap_or(self.boxes.reach);
        self.scale = scale(size);
        self.place = Place::new(&self.patches, curve.middle(), curve.size().max(size));
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
        let points = closest.points;
        found.resize(points.len());
        let mut answers = std::mem::take(&mut self.answers);
        answers.clear();
        answers.resize(points.len(), Answer::NONE);
        self.each_block(closest, Wanted::Nearest, &mut answers, |job, worker, order, answers| {
            dispatch!(job.level, simd => worker.answer(simd, job, order, answers));
        });
        let ClosestPoints { triangle, barycentric, position, distance, nowhere } = found;
        let slots = triangle.par_iter_mut().zip(barycentric).zip(position.par_iter_mut().zip(distance));
        slots.zip(&self.ranks).each(|(((triangle, barycentric), (position, distance)), rank)| {
            let answer = answers[rank.load(Ordering::Relaxed) as usize];
            *triangle = answer.triangle;
            *barycentric = answer.barycentric;
            *position = answer.position;
            *distance = answer.distance;
        });
        self.answers = answers;
        let is_nowhere = |points: &[Vec3]| points.iter().filter(|point| !point.is_finite()).count();
        *nowhere = points.par_chunks(CHUNK).map(is_nowhere).merge(|one, other| one + other).unwrap_or(0);
    }

    /// Finds which points are inside of closed meshes: those from which a ray crosses triangles an odd number of times. Points
    /// that aren't finite are outside.
    ///
    /// The number of crossings is exact, through edges and corners too: the point is moved by less than any number, along
    /// y, less along z and still less along x. So the answer is the same for every direction of a ray if each edge is shared
    /// by two triangles or another even number. Points on the surface have the answer of where they are moved.
    ///
    /// # Panics
    /// If it was built for another number of triangles, or there are 2³² points or more.
    pub fn inside(&mut self, triangles: Triangles<'_>, points: &[Vec3], inside: &mut Vec<bool>) {
        inside.clear();
        inside.resize(points.len(), false);
        let mut answers = std::mem::take(&mut self.is_inside);
        answers.clear();
        answers.resize(points.len(), false);
        self.each_block(
            &Closest::new(triangles, points),
            Wanted::Nearest,
            &mut answers,
            |job, worker, order, answers| {
                dispatch!(job.level, simd => worker.find_inside(simd, job, order, answers));
            },
        );
        inside.par_iter_mut().zip(&self.ranks).each(|(inside, rank)| {
            *inside = answers[rank.load(Ordering::Relaxed) as usize];
        });
        self.is_inside = answers;
    }

    /// As [`closest_points`](Self::closest_points), with distances of points [inside](Self::inside) of closed meshes below
    /// zero.
    ///
    /// # Panics
    /// As these.
    pub fn signed_distances(&mut self, closest: &Closest<'_>, found: &mut ClosestPoints) {
        self.closest_points(closest, found);
        let mut inside = std::mem::take(&mut self.inside);
        self.inside(closest.triangles, closest.points, &mut inside);
        found.distance.par_iter_mut().zip(&inside).each(|(distance, is_inside)| {
            if *is_inside {
                *distance = -*distance;
            }
        });
        self.inside = inside;
    }

    /// Lists the triangles that are nearer to each point than [`Closest::max`], in real numbers. A point that isn't finite is
    /// near to none.
    ///
    /// # Panics
    /// If it was built for another number of triangles, or there are 2³² points or more.
    pub fn within(&mut self, closest: &Closest<'_>, found: &mut Within) {
        let mut lists = std::mem::take(&mut self.lists);
        lists.iter_mut().for_each(Vec::clear);
        lists.resize_with(closest.points.len(), Vec::new);
        self.each_block(closest, Wanted::All, &mut lists, |job, worker, order, lists| {
            dispatch!(job.level, simd => worker.list(simd, job, order, lists));
        });
        let Within { triangle, starts } = found;
        triangle.clear();
        starts.clear();
        starts.push(0);
        for rank in &self.ranks {
            triangle.extend_from_slice(&lists[rank.load(Ordering::Relaxed) as usize]);
            starts.push(triangle.len());
        }
        self.lists = lists;
    }

    /// Finds generalised winding numbers: how often the triangles surround each point. That is the sum of their solid angles as
    /// seen from the point, in whole spheres, above zero for triangles whose back faces it. So it is 1 inside of a closed mesh
    /// with its fronts outside, 0 outside of it, and between these for a mesh with holes, where it is the part of all
    /// directions that the mesh covers. Points that aren't finite have NaN.
    ///
    /// Many triangles seen from a distance of more than twice their radius count by the first three terms of an expansion
    /// (Barill et al., *Fast winding numbers for soups and clouds*, 2018, with β = 2). Each of these is wrong by less than
    /// 1.25 A ÷ (4 π d²), for their area A at the distance d, and by far less where they are nearly a plane: all together are
    /// wrong by less than 0.01 in closed meshes and random triangles that were tried. Triangles nearby are added in f64, and
    /// which side of one a point is on is decided exactly. From a point on a triangle it has no solid angle: on a closed mesh
    /// the number is 1/2 on faces, and less or more than that on edges.
    ///
    /// Numbers are the same bit for bit for every SIMD level and number of threads, for any other points and earlier frames.
    /// The first call for a frame sorts the triangles and makes a tree, of about 40 bytes a triangle.
    ///
    /// # Panics
    /// If it was built for another number of triangles, or there are 2³² points or more.
    pub fn winding_numbers(&mut self, triangles: Triangles<'_>, points: &[Vec3], found: &mut Vec<f64>) {
        self.patches.expect(triangles);
        let (mut winding, mut numbers) = (std::mem::take(&mut self.winding), std::mem::take(&mut self.numbers));
        winding.update(triangles, &mut self.order);
        numbers.clear();
        numbers.resize(points.len(), 0.0);
        let all = Closest::new(triangles, points);
        self.each_block(&all, Wanted::All, &mut numbers, |job, _, order, numbers| {
            dispatch!(job.level, simd => winding.answer(simd, job, order, numbers));
        });
        found.resize(points.len(), 0.0);
        found.par_iter_mut().zip(points).zip(&self.ranks).each(|((found, point), rank)| {
            *found = if point.is_finite() { numbers[rank.load(Ordering::Relaxed) as usize] } else { f64::NAN };
        });
        (self.winding, self.numbers) = (winding, numbers);
    }

    /// Has threads answer blocks of points along a curve, unless nothing can be near enough. The answer for point i has index
    /// `ranks[i]`.
    fn each_block<T: Send>(
        &mut self,
        closest: &Closest<'_>,
        wanted: Wanted,
        answers: &mut [T],
        answer: impl Fn(&Job<'_>, &mut BlockWorker, &[u64], &mut [T]) + Sync,
    ) {
        let Closest { triangles, points, max } = *closest;
        self.patches.expect(triangles);
        assert!(u32::try_from(points.len()).is_ok(), "{} points at once", points.len());
        let Self { level, patches, boxes, scale, place, order, ranks, workers, .. } = self;
        ranks.resize_with(points.len(), AtomicU32::default);
        for worker in workers.get_mut().unwrap_or_else(PoisonError::into_inner) {
            worker.forget();
        }
        if max > 0.0 && patches.len() > 0 {
            // Rounded up.
            let most = (max * f64::from(*scale)) as f32 * (1.0 + 4.0 * f32::EPSILON) + f32::MIN_POSITIVE;
            let (level, scale, place) = (*level, *scale, place.as_ref());
            let job = Job { level, wanted, triangles, points, max, most, patches, boxes, scale, place, ranks, workers };
            job.each_block(Curve::sort_points(points, order), 0, answers, &answer);
        } else {
            // All answers are the same. Those of an earlier query may have been more.
            ranks.iter_mut().for_each(|rank| *rank.get_mut() = 0);
        }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let workers = self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        self.patches.bytes()
            + self.boxes.bytes()
            + self.order.bytes()
            + self.answers.capacity() * size_of::<Answer>()
            + self.is_inside.capacity()
            + self.lists.iter().map(|list| size_of::<Vec<u32>>() + list.capacity() * size_of::<u32>()).sum::<usize>()
            + self.inside.capacity()
            + self.ranks.capacity() * size_of::<AtomicU32>()
            + workers.iter().map(BlockWorker::bytes).sum::<usize>()
            + self.winding.bytes()
            + self.numbers.capacity() * size_of::<f64>()
    }
}

/// The triangles that are wanted of those near enough to a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Nearest,
    All,
}

/// The inputs of finding near triangles.
struct Job<'a> {
    level: SimdLevel,
    wanted: Wanted,
    triangles: Triangles<'a>,
    points: &'a [Vec3],
    /// Triangles at this distance or farther don't count.
    max: f64,
    /// The same scaled, rounded up.
    most: f32,
    patches: &'a Patches,
    boxes: &'a BoxTree,
    scale: f32,
    place: Option<&'a Place>,
    ranks: &'a [AtomicU32],
    workers: &'a Mutex<Vec<BlockWorker>>,
}

impl Job<'_> {
    /// Answers the points of `order`, which begins at index `first`, in halves for other threads to share.
    fn each_block<T: Send>(
        &self,
        order: &[u64],
        first: usize,
        answers: &mut [T],
        answer: &(impl Fn(&Job<'_>, &mut BlockWorker, &[u64], &mut [T]) + Sync),
    ) {
        if order.len() > CHUNK {
            let middle = (order.len() / 2).next_multiple_of(BLOCK);
            let (low, high) = answers.split_at_mut(middle);
            both(
                || self.each_block(&order[..middle], first, low, answer),
                || self.each_block(&order[middle..], first + middle, high, answer),
            );
            return;
        }
        for (rank, &key) in (first as u32..).zip(order) {
            self.ranks[key as u32 as usize].store(rank, Ordering::Relaxed);
        }
        let workers = || self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        let mut worker = workers().pop().unwrap_or_default();
        for (order, answers) in order.chunks(BLOCK).zip(answers.chunks_mut(BLOCK)) {
            answer(self, &mut worker, order, answers);
        }
        workers().push(worker);
    }
}

/// The median size of patches, few of which reach a vertex that is far away; `None` if that is nothing, infinite or NaN.
fn typical_size(patches: &Patches) -> Option<f32> {
    const SAMPLES: usize = 64;
    let mut sizes = [0.0_f32; SAMPLES];
    let every = patches.len().div_ceil(SAMPLES).max(1);
    let mut count = 0;
    for number in (0..patches.len()).step_by(every) {
        let [low, high] = patches.bounds.sixteens[number / LANES].get(number);
        let size = (0..3).fold(0.0_f32, |size, axis| size.max(high[axis] - low[axis]));
        if size.is_normal() {
            sizes[count] = size;
            count += 1;
        }
    }
    (count > 0).then(|| *sizes[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1)
}

/// The power of two that makes a length about one sixteenth: distances in a scene are about one then if patches are that
/// large.
fn scale(length: f32) -> f32 {
    // From the exponent, without rounding.
    let exponent = (length.to_bits() >> 23) as i32;
    f32::from_bits((250 - exponent).clamp(4, 250) as u32 * (1 << 23))
}
