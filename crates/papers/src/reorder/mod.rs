//! Reordering of secondary rays (Rahikainen 2013, §2.3, §3.2 to §3.4): batches of rays through the hierarchy, in other
//! orders than that of arrival, and together instead of one by one. Hits and shadows are those of single rays, to the
//! last bit.
//!
//! Boxes and triangles are the hierarchy's own and are culled by the same numbers; at a leaf, all methods test a ray
//! with up to eight triangles at once. Rays beyond the range of f32, or with a t below zero, are traced alone.

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

/// How a batch of rays is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reorder {
    /// Order and grouping of the rays.
    pub order: Order,
    /// Traversal of a group.
    pub by: Traversal,
}

/// How rays are grouped. Rays have kinds: numbers, for example for mirrored rays, for refracted rays, and for rays to
/// each light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// In order of arrival.
    Arrival,
    /// In order of arrival, only rays of one kind together (*runs* of Boulos et al. 2007).
    Runs,
    /// Sorted by kind (*types* of the same).
    Types,
    /// Sorted by kind, the direction's largest component and its signs.
    Directions,
}

/// How rays traverse the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    /// One ray at a time, by the hierarchy itself.
    Single,
    /// The same with counts, and slower.
    SingleCounted,
    /// Packets of at most this many rays, up to 64.
    Packets(usize),
    /// Packets of up to 256 rays, with ranges and bounds.
    Ranged,
    /// Packets of up to 64 rays, regrouped if half of the lanes are empty.
    Adaptive,
    /// Streams of up to 4096 rays.
    Stream,
    /// Eight frusta of eight rays.
    MultiFrusta,
}

impl Traversal {
    /// Maximum number of rays of a group.
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

/// Work of a batch, without rays that are traced alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Tests of eight lanes: rays or frusta against a box, a ray or a packet's bounds against eight boxes.
    pub tests: u64,
    /// Lanes in use in these tests.
    pub lanes: u64,
    /// Tests of a ray against a triangle.
    pub triangles: u64,
    /// Number of times that a ray changed its packet.
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

/// [`nearest`](umbrage_rays::SingleRays::nearest) for each of `rays`; `kinds` has the rays' kinds.
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

/// [`blocked`](umbrage_rays::SingleRays::blocked) for each of `rays`; their points are on the triangles `own`, and
/// `kinds` has the rays' kinds.
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

/// Calls `answer` with the prepared rays of each packet, and with rays that are traced alone, without preparation.
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
