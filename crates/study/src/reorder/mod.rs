//! Re-ordering of secondary rays (Rahikainen 2013, §2.3, §3.2 to §3.4): batches of rays through the hierarchy, in other orders than
//! the one they come in, and together instead of one by one. Hits and shadows are those of single rays, to the last bit.
//!
//! Boxes and triangles are the hierarchy's own and are left out by the same numbers; at a leaf a ray is tested with its up to eight
//! triangles at once, by all methods. Rays that f32 can't hold, or that have a t below zero, go alone.

mod adaptive;
mod bounds;
mod frusta;
mod order;
mod packet;
mod ranged;
mod rays;
mod stream;

use fearless_simd::Simd;
use umbrage_rays::dispatch;
use umbrage_rays::internals::{BvhInside, BvhLine, BvhNearest};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Bvh, Hit, Ray, SeenPixels, SingleRays as _, Triangles};

use rays::{BlockedTask, NearestTask, Task};

/// How a batch of rays is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reorder {
    /// In which order, and which of them together.
    pub order: Order,
    /// By what.
    pub by: Traversal,
}

/// Which rays go together. Rays have kinds: numbers, say for those that are mirrored, for those that are refracted, and for those to each
/// light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// As they come.
    Arrival,
    /// As they come, and only those of one kind (*runs* of Boulos et al. 2007).
    Runs,
    /// Sorted by kind (*types* of the same).
    Types,
    /// Sorted by kind, the direction's largest component and its signs.
    Directions,
}

/// What leads rays to leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    /// One ray at a time, by the hierarchy itself.
    Single,
    /// The same with what it takes counted, and slower.
    SingleCounted,
    /// Packets of up to so many rays, at most 64.
    Packets(usize),
    /// Packets of up to 256 rays, with ranges and bounds.
    Ranged,
    /// Packets of up to 64 rays, put together anew where half of the lanes are empty.
    Adaptive,
    /// Streams of up to 4096 rays.
    Stream,
    /// Eight frusta of eight rays.
    MultiFrusta,
}

impl Traversal {
    /// Most rays that go together.
    fn most(self) -> usize {
        match self {
            Self::Single | Self::Stream => stream::MOST,
            Self::SingleCounted => 1,
            Self::Packets(most) => most.clamp(1, 64),
            Self::Adaptive | Self::MultiFrusta => 64,
            Self::Ranged => ranged::MOST,
        }
    }
}

/// What a batch took, but for rays that went alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Tests of eight lanes: of rays or frusta with a box, of a ray or a packet's bounds with eight boxes.
    pub tests: u64,
    /// Lanes of these in which there was something to test.
    pub lanes: u64,
    /// Pairs of a ray and a triangle.
    pub triangles: u64,
    /// Rays that were put into another packet on their way, each time.
    pub regrouped: u64,
}

impl Counts {
    #[inline(always)]
    fn tested(&mut self, lanes: u32) {
        self.tests += 1;
        self.lanes += u64::from(lanes);
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.tests += other.tests;
        self.lanes += other.lanes;
        self.triangles += other.triangles;
        self.regrouped += other.regrouped;
    }
}

/// Does what [`nearest`](umbrage_rays::SingleRays::nearest) does for each of `rays`, whose `kinds` are given.
///
/// # Panics
/// If there are more or fewer `kinds` or `hits` than `rays`.
pub fn nearest(
    bvh: &Bvh,
    triangles: Triangles<'_>,
    (rays, kinds): (&[Ray], &[u32]),
    how: Reorder,
    stops: &dyn Fn(&Hit) -> bool,
    hits: &mut [Option<Hit>],
) -> Counts {
    assert!(rays.len() == kinds.len() && rays.len() == hits.len(), "{} rays", rays.len());
    let mut counts = Counts::default();
    by_packets(
        bvh,
        how,
        |index| &rays[index],
        kinds,
        |members, lines| {
            if how.by == Traversal::Single || lines.is_empty() {
                members.iter().for_each(|&index| hits[index] = bvh.nearest(triangles, &rays[index], stops));
                return;
            }
            let inside = bvh.inside();
            let of_ray = |(&index, line)| BvhNearest::new(bvh, triangles, &rays[index], line, SeenPixels::NONE, stops);
            let mut task = NearestTask {
                lines,
                leaves: inside.leaves,
                nearest: members.iter().zip(lines).map(of_ray).collect(),
                far: lines.iter().map(|line| line.far).collect(),
            };
            dispatch!(inside.level, simd => {
                visit(simd, how.by, inside, lines, &mut task, &mut counts);
                for ((&index, nearest), far) in members.iter().zip(&mut task.nearest).zip(&mut task.far) {
                    let again = || bvh.nearest(triangles, &rays[index], stops);
                    hits[index] = nearest.end(simd, far).unwrap_or_else(again);
                }
            });
        },
    );
    counts
}

/// Does what [`blocked`](umbrage_rays::SingleRays::blocked) does for each of `rays`, whose points are on the triangles `own` and whose
/// `kinds` are given.
///
/// # Panics
/// If there are more or fewer `own`, `kinds` or `blocked` than `rays`.
pub fn blocked(
    bvh: &Bvh,
    triangles: Triangles<'_>,
    (rays, own, kinds): (&[ShadowRay], &[u32], &[u32]),
    how: Reorder,
    stops: &dyn Fn(u32, [f32; 2]) -> bool,
    blocked: &mut [bool],
) -> Counts {
    let count = rays.len();
    assert!(own.len() == count && kinds.len() == count && blocked.len() == count, "{count} rays");
    let mut counts = Counts::default();
    by_packets(
        bvh,
        how,
        |index| &rays[index].ray,
        kinds,
        |members, lines| {
            if how.by == Traversal::Single || lines.is_empty() {
                for &index in members {
                    blocked[index] = bvh.blocked(triangles, &rays[index], own[index], stops);
                }
                return;
            }
            let inside = bvh.inside();
            let blocks = |ray: usize, id: u32| {
                let index = members[ray];
                id != own[index]
                    && rays[index].blocked_by(triangles.corners(id)).is_some_and(|barycentric| stops(id, barycentric))
            };
            let is_blocked = vec![false; lines.len()];
            let mut task = BlockedTask { lines, leaves: inside.leaves, blocks, is_blocked };
            dispatch!(inside.level, simd => visit(simd, how.by, inside, lines, &mut task, &mut counts));
            members.iter().zip(&task.is_blocked).for_each(|(&index, &is_blocked)| blocked[index] = is_blocked);
        },
    );
    counts
}

/// Calls `answer` with the rays of each packet, prepared; and without preparation with those that go alone.
fn by_packets<'a>(
    bvh: &Bvh,
    how: Reorder,
    ray: impl Fn(usize) -> &'a Ray,
    kinds: &[u32],
    mut answer: impl FnMut(&[usize], &[BvhLine]),
) {
    let (order, ends) = order::packets(how.order, &ray, kinds, how.by.most());
    let scale = bvh.inside().scale;
    let (mut members, mut lines, mut alone) = (Vec::new(), Vec::new(), Vec::new());
    let mut start = 0;
    for end in ends {
        members.clear();
        lines.clear();
        for index in order[start..end].iter().map(|&index| index as usize) {
            let line = || bvh.may_be_met(ray(index)).then(|| BvhLine::new(ray(index), scale)).flatten();
            match if how.by == Traversal::Single { None } else { line() } {
                Some(line) if line.is_ahead => {
                    members.push(index);
                    lines.push(line);
                }
                _ => alone.push(index),
            }
        }
        if !lines.is_empty() {
            answer(&members, &lines);
        }
        start = end;
    }
    answer(&alone, &[]);
}

#[inline(always)]
fn visit<S: Simd>(
    simd: S,
    by: Traversal,
    inside: BvhInside<'_>,
    lines: &[BvhLine],
    task: &mut impl Task,
    counts: &mut Counts,
) {
    match by {
        Traversal::Packets(_) => packet::visit(simd, inside, lines, task, counts),
        Traversal::Ranged => ranged::visit(simd, inside, lines, task, counts),
        Traversal::Adaptive => adaptive::visit(simd, inside, lines, task, counts),
        Traversal::MultiFrusta => frusta::visit(simd, inside, lines, task, counts),
        Traversal::Single | Traversal::SingleCounted | Traversal::Stream => {
            stream::visit(simd, inside, lines, task, counts);
        }
    }
}
