//! Triangles that move while rays are sent: each ray has its own moment.
//!
//! Between two keys a hierarchy has each box and each corner twice, at the first and at the last moment, and a ray meets
//! them where they are at its own (Christensen et al., *Ray tracing for the movie Cars*, 2006, for boxes). The predicate is
//! asked about corners posed in f64, so answers are those of the triangles of that moment, bit for bit.

use std::ops::ControlFlow;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use glam::{Vec3, Vec4};

use super::build::{HUGE, SCALE};
use super::leaf::{Leaf, LeafHits};
use super::line::{Line, Slabs};
use super::split::{Extent, Item};
use super::trace::{Corners, Nodes, Stack, walk};
use super::{Bvh, Child, Kind, Node, WIDTH};
use crate::predicate::hit_of_near;
use crate::{Hit, Ray, Rays, Scanned, SimdLevel, dispatch};

/// Triangles whose vertices move in straight lines from key to key.
///
/// At a moment between two keys a coordinate is a (1 − w) + b w, in f64 and rounded to f32 once, where w is the moment's part
/// of the time between them. Before the first key and after the last one nothing moves.
#[derive(Clone, Copy, Debug)]
pub struct MovingTriangles<'a> {
    /// The positions of all vertices at some moments, in their order.
    pub keys: &'a [Key<'a>],
    /// Three indices of positions for each triangle; a triangle's id is its index here.
    pub indices: &'a [[u32; 3]],
}

/// The positions of all vertices at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Key<'a> {
    /// The moment.
    pub seconds: f64,
    /// World positions.
    pub positions: &'a [Vec3],
}

/// A moment between two keys.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    /// The index of the first key; the other is the next one, if there is any.
    key: usize,
    /// The part of the time between both keys, from 0 to 1.
    part: f64,
}

#[inline(always)]
fn between([from, to]: [Vec3; 2], part: f64) -> Vec3 {
    (from.as_dvec3() * (1.0 - part) + to.as_dvec3() * part).as_vec3()
}

impl<'a> MovingTriangles<'a> {
    /// The positions of all vertices at a moment.
    ///
    /// # Panics
    /// If there are no keys, or they have different numbers of vertices.
    pub fn pose(&self, seconds: f64, positions: &mut Vec<Vec3>) {
        let Moment { key, part } = self.moment(seconds);
        let [from, to] = self.ends(key);
        assert_eq!(from.len(), to.len(), "keys of different numbers of vertices");
        positions.clear();
        positions.extend(from.iter().zip(to).map(|(&from, &to)| between([from, to], part)));
    }

    /// The corners of a triangle at a moment.
    ///
    /// # Panics
    /// If there are no keys, no such triangle, or one of its vertices isn't there.
    #[must_use]
    pub fn corners_at(&self, seconds: f64, id: u32) -> [Vec3; 3] {
        let Moment { key, part } = self.moment(seconds);
        let [from, to] = self.ends(key);
        self.indices[id as usize].map(|vertex| between([from[vertex as usize], to[vertex as usize]], part))
    }

    /// Where a time is; NaN is at the first key.
    fn moment(&self, seconds: f64) -> Moment {
        let key = self.keys.partition_point(|key| key.seconds <= seconds).saturating_sub(1);
        let last = self.keys.len().saturating_sub(2);
        let from = self.keys[key].seconds;
        match self.keys.get(key + 1) {
            Some(to) if seconds > from => Moment { key, part: (seconds - from) / (to.seconds - from) },
            None if key > last => Moment { key: last, part: 1.0 },
            _ => Moment { key, part: 0.0 },
        }
    }

    /// The positions at a key and at the next one, or twice at the only one.
    fn ends(&self, key: usize) -> [&'a [Vec3]; 2] {
        let from = self.keys[key].positions;
        [from, self.keys.get(key + 1).map_or(from, |key| key.positions)]
    }

    /// The corners of a triangle at both ends; `None` where a vertex isn't there or a coordinate isn't finite.
    fn corners(&self, ends: [&[Vec3]; 2], id: u32) -> Option<[[Vec3; 3]; 2]> {
        let mut corners = [[Vec3::ZERO; 3]; 2];
        for (corners, positions) in corners.iter_mut().zip(ends) {
            for (corner, &vertex) in corners.iter_mut().zip(&self.indices[id as usize]) {
                *corner = *positions.get(vertex as usize).filter(|position| position.is_finite())?;
            }
        }
        Some(corners)
    }
}

/// Answers rays with a moment each, among [moving triangles](MovingTriangles): hits, ids and t are those of the triangles
/// posed at the ray's moment.
///
/// Keep it and build it for every frame: its memory is reused. It takes about 190 bytes a triangle for each time between two
/// keys. Triangles with a coordinate that isn't finite at one of two keys can't be hit between these.
///
/// ```
/// use glam::{DVec3, Vec3};
/// use umbrage_rays::{Key, MotionTree, MovingTriangles, Ray, Scanned};
///
/// // A triangle that falls by two units in a second.
/// let first = [Vec3::ZERO, Vec3::X, Vec3::Z];
/// let last = first.map(|position| position - 2.0 * Vec3::Y);
/// let keys = [Key { seconds: 0.0, positions: &first }, Key { seconds: 1.0, positions: &last }];
/// let moving = MovingTriangles { keys: &keys, indices: &[[0, 1, 2]] };
///
/// let (mut tree, mut traced) = (MotionTree::default(), Scanned::default());
/// tree.build(&moving);
/// let ray = Ray::new(DVec3::new(0.25, 4.0, 0.25), DVec3::NEG_Y);
/// tree.trace(&moving, &[ray; 3], &[0.0, 0.5, 7.0], &mut traced);
/// assert_eq!(traced.t, [4.0, 5.0, 6.0]);
/// ```
#[derive(Default)]
pub struct MotionTree {
    level: SimdLevel,
    /// One for each time between two keys; one if there is a single key.
    segments: Vec<Segment>,
}

debug_some!(MotionTree as tree: "segments" => tree.segments.len());

/// A hierarchy between two keys.
#[derive(Default)]
struct Segment {
    /// At the first key.
    first: Bvh,
    /// At the second key: the bounds of nodes' children, and leaves.
    last_bounds: Vec<[[f32; WIDTH]; 6]>,
    last_leaves: Vec<Leaf>,
    /// The largest coordinate in each node and leaf at both keys.
    reach_of_nodes: Vec<f32>,
    reach_of_leaves: Vec<f32>,
    /// Triangles with huge coordinates, if others have none.
    far: Vec<u32>,
}

/// Bounds of children that aren't there: no ray meets them, and they stay inverted between two keys.
const NOWHERE: [f32; 2] = [f32::MAX / 4.0, -f32::MAX / 4.0];

impl MotionTree {
    /// Uses the instructions of a level instead of the widest; answers are the same bit for bit.
    #[must_use]
    pub fn with_level(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// Builds a hierarchy for each time between two keys.
    ///
    /// # Panics
    /// If there are no keys, or their times don't grow.
    pub fn build(&mut self, moving: &MovingTriangles<'_>) {
        let grows = moving.keys.is_sorted_by(|a, b| a.seconds < b.seconds);
        assert!(!moving.keys.is_empty() && grows, "no keys, or keys whose times don't grow");
        let level = self.level;
        self.segments.resize_with((moving.keys.len() - 1).max(1), Segment::default);
        for (key, segment) in self.segments.iter_mut().enumerate() {
            segment.first.level = level;
            segment.build(moving, moving.ends(key));
        }
    }

    /// The nearest hit of a ray at its moment, without the triangle `own`, for which `stops` is true; at equal t the one with
    /// the lowest id. `None` for a miss.
    ///
    /// # Panics
    /// If the triangles aren't those of the last build.
    #[must_use]
    pub fn nearest_from(
        &self,
        moving: &MovingTriangles<'_>,
        ray: &Ray,
        seconds: f64,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        if !ray.is_sound() || seconds.is_nan() {
            return None;
        }
        let Moment { key, part } = moving.moment(seconds);
        let segment = &self.segments[key];
        let posed = Posed { moving, ends: moving.ends(key), part, segment };
        let far = segment.far.iter().filter(|&&id| id != own);
        let of_far = far.filter_map(|&id| hit_of_near(ray, posed.corners(id)?, id)).filter(|hit| stops(hit));
        let best = of_far.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        if segment.first.nodes.is_empty() {
            return best;
        }
        let ray = Ray { t_max: best.map_or(ray.t_max, |hit| hit.t.next_up()), ..*ray };
        let hit = dispatch!(self.level, simd => segment.nearest_at(simd, posed, &ray, own, stops));
        let key = |hit: &Hit| (hit.t, hit.triangle);
        hit.filter(|hit| best.is_none_or(|best| key(hit) < key(&best))).or(best)
    }

    /// Finds the first hit of each ray at its moment, of which there is one for each ray; at equal t the one with the lowest
    /// id. A ray whose moment is NaN hits nothing.
    ///
    /// `traced` has one hit for each ray, in their order; see [`Tracer::trace`](crate::Tracer::trace).
    ///
    /// # Panics
    /// If the triangles aren't those of the last build, or there are more or fewer moments than rays.
    pub fn trace<'a>(
        &self,
        moving: &MovingTriangles<'_>,
        rays: impl Into<Rays<'a>>,
        seconds: &[f64],
        traced: &mut Scanned,
    ) {
        let rays = rays.into();
        assert_eq!(rays.len(), seconds.len(), "as many moments as rays");
        let nearest =
            |index: usize, ray: &Ray| self.nearest_from(moving, ray, seconds[index], Scanned::NONE, &|_| true);
        traced.fill_nearest(rays, nearest);
    }

    /// Bytes of memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.segments.iter().map(Segment::bytes).sum()
    }
}

impl Segment {
    fn build(&mut self, moving: &MovingTriangles<'_>, ends: [&[Vec3]; 2]) {
        let Self { first, last_bounds, last_leaves, reach_of_nodes, reach_of_leaves, far } = self;
        let Bvh { nodes, leaves, scale, root, builder, .. } = first;
        let is_far =
            |corners: &[[Vec3; 3]; 2]| corners.as_flattened().iter().any(|corner| corner.abs().max_element() > HUGE);
        let ids = 0..moving.indices.len() as u32;
        far.clear();
        far.extend(ids.clone().filter(|&id| moving.corners(ends, id).is_some_and(|corners| is_far(&corners))));
        // A few are tested by every ray; of many, all are scaled.
        *scale = 1.0;
        if far.len() > moving.indices.len() / 64 {
            *scale = SCALE;
            far.clear();
        }
        let scale = *scale;
        let usable = ids.filter_map(|id| Some((id, moving.corners(ends, id)?)));
        builder.items.clear();
        builder.items.extend(usable.filter(|(_, corners)| scale != 1.0 || !is_far(corners)).map(|(id, corners)| {
            // Halfway between both ends.
            let boxes = corners.map(|corners| Extent::around(corners.map(|corner| (corner * scale).extend(0.0))));
            let middle = |of: fn(&Extent) -> Vec4| 0.5 * (of(&boxes[0]) + of(&boxes[1]));
            Item::new(Extent { low: middle(|at| at.low), high: middle(|at| at.high) }, id)
        }));
        let built = builder.build(Leaf::LANES);
        nodes.resize(built.nodes, Node::EMPTY);
        leaves.resize(built.leaves, Leaf::EMPTY);
        last_leaves.resize(built.leaves, Leaf::EMPTY);
        *root = Child::node(0);
        built.write_nodes(nodes, 0, |leaf, items| Child::leaf(leaf, items.len()));
        for (leaves, positions) in [&mut *leaves, last_leaves].into_iter().zip(ends) {
            built
                .fill_leaves(leaves, |id| moving.indices[id as usize].map(|vertex| positions[vertex as usize] * scale));
        }
        last_bounds.clear();
        last_bounds.extend(nodes.iter().map(|node| node.bounds));
        reach_of_nodes.clear();
        reach_of_nodes.resize(nodes.len(), 0.0);
        reach_of_leaves.clear();
        reach_of_leaves.resize(leaves.len(), 0.0);
        // Nodes are before those below them.
        for index in (0..nodes.len()).rev() {
            for slot in 0..WIDTH {
                let child = nodes[index].children[slot];
                let ends = match child.kind() {
                    _ if child == Child::NONE => {
                        for bounds in [&mut nodes[index].bounds, &mut last_bounds[index]] {
                            (0..6).for_each(|bound| bounds[bound][slot] = NOWHERE[bound % 2]);
                        }
                        continue;
                    }
                    Kind::Node(below) => [&nodes[below].bounds, &last_bounds[below]].map(around_children),
                    Kind::Leaf { index: leaf, lanes } => {
                        let ends = [&leaves[leaf], &last_leaves[leaf]].map(|leaf| around_corners(leaf, lanes));
                        reach_of_leaves[leaf] = ends[0].reach().max(ends[1].reach());
                        ends
                    }
                };
                nodes[index].set_bounds(slot, ends[0]);
                for axis in 0..3 {
                    last_bounds[index][2 * axis][slot] = ends[1].low[axis];
                    last_bounds[index][2 * axis + 1][slot] = ends[1].high[axis];
                }
                let reach = ends[0].reach().max(ends[1].reach());
                reach_of_nodes[index] = reach_of_nodes[index].max(reach);
            }
        }
    }

    #[inline(always)]
    fn nearest_at<S: Simd>(
        &self,
        simd: S,
        posed: Posed<'_>,
        ray: &Ray,
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        match Line::new(ray, self.first.scale) {
            Some(line) => self.first.nearest_on(simd, &line, posed, ray, own, stops),
            None => posed.nearest_of_all(ray, own, stops),
        }
    }

    fn bytes(&self) -> usize {
        use crate::Structure;
        self.first.bytes().triangles
            + self.last_bounds.capacity() * size_of::<[[f32; WIDTH]; 6]>()
            + self.last_leaves.capacity() * size_of::<Leaf>()
            + (self.reach_of_nodes.capacity() + self.reach_of_leaves.capacity() + self.far.capacity()) * 4
    }
}

/// The box around the boxes of children; those that aren't there are left out.
fn around_children(bounds: &[[f32; WIDTH]; 6]) -> Extent {
    let boxes = (0..WIDTH).map(|slot| Extent {
        low: Vec4::new(bounds[0][slot], bounds[2][slot], bounds[4][slot], 0.0),
        high: Vec4::new(bounds[1][slot], bounds[3][slot], bounds[5][slot], 0.0),
    });
    boxes.filter(|child| child.low.x <= child.high.x).fold(Extent::EMPTY, Extent::union)
}

fn around_corners(leaf: &Leaf, lanes: u32) -> Extent {
    let lanes = (0..Leaf::LANES).filter(|lane| lanes >> lane & 1 == 1);
    lanes.fold(Extent::EMPTY, |extent, lane| {
        extent.union(Extent::around(leaf.corners(lane).map(|corner| corner.extend(0.0))))
    })
}

impl Extent {
    fn around([a, b, c]: [Vec4; 3]) -> Self {
        Self { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    /// The largest coordinate.
    fn reach(&self) -> f32 {
        self.low.abs().max(self.high.abs()).truncate().max_element()
    }
}

/// A segment's triangles at a moment.
///
/// **Error bounds.** With ε = 2⁻²⁴ and coordinates up to m at both ends, a + (b − a) w in f32 is off by ε 2 m for each of
/// the roundings of w, of the difference and of the product, and by ε m for that of the sum. Corners are rounded once when
/// they are posed, by ε m. So boxes grow by 16 ε m, twice the sum, and corners have a blur of 16 m.
#[derive(Clone, Copy)]
struct Posed<'a> {
    moving: &'a MovingTriangles<'a>,
    ends: [&'a [Vec3]; 2],
    part: f64,
    segment: &'a Segment,
}

const ROUNDINGS: f32 = 16.0;
const EPSILON: f32 = 1.0 / (1 << 24) as f32;

impl Posed<'_> {
    fn corners(&self, id: u32) -> Option<[Vec3; 3]> {
        let [first, last] = self.moving.corners(self.ends, id)?;
        Some([0, 1, 2].map(|corner| between([first[corner], last[corner]], self.part)))
    }

    #[cold]
    fn nearest_of_all(&self, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        let ids = self.segment.first.ids().filter(|&id| id != own);
        let hits = ids.filter_map(|id| hit_of_near(ray, self.corners(id)?, id)).filter(|hit| stops(hit));
        hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
    }
}

impl Corners for Posed<'_> {
    #[inline(always)]
    fn triangle(&self, bvh: &Bvh, leaf: usize, lane: usize) -> (u32, [Vec3; 3]) {
        let id = bvh.leaves[leaf].ids[lane % Leaf::LANES];
        let [first, last] = self.ends;
        let corner = |vertex: u32| between([first[vertex as usize], last[vertex as usize]], self.part);
        (id, self.moving.indices[id as usize].map(corner))
    }

    #[inline(always)]
    fn visit<S: Simd>(
        &self,
        simd: S,
        bvh: &Bvh,
        (line, stack): (&Line, &mut Stack),
        far: &mut f32,
        mut test: impl FnMut(usize, &LeafHits, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (segment, part) = (self.segment, self.part as f32);
        walk(
            simd,
            (Moving { segment, part }, bvh.root),
            (line, stack),
            far,
            #[inline(always)]
            |index, lanes, far| {
                let leaf = bvh.leaves[index].towards(simd, &segment.last_leaves[index], part);
                let blur = segment.reach_of_leaves[index].mul_add(ROUNDINGS, line.blur);
                match leaf.find_blurred(simd, line, blur, lanes, *far) {
                    Some(found) => test(index, &found, far),
                    None => ControlFlow::Continue(()),
                }
            },
        )
    }
}

/// Nodes with the bounds of a moment.
struct Moving<'a> {
    segment: &'a Segment,
    part: f32,
}

impl Nodes for Moving<'_> {
    #[inline(always)]
    fn enter<S: Simd>(&self, simd: S, slabs: &Slabs<S>, index: usize, far: f32) -> (f32x8<S>, u64) {
        let Segment { first, last_bounds, reach_of_nodes, .. } = self.segment;
        let margin = reach_of_nodes[index] * (ROUNDINGS * EPSILON);
        let mut node = Node::EMPTY;
        let bounds = node.bounds.iter_mut().zip(&first.nodes[index].bounds).zip(&last_bounds[index]);
        for (bound, ((into, from), to)) in bounds.enumerate() {
            let (from, to) = (f32x8::from_slice(simd, from), f32x8::from_slice(simd, to));
            let moved = (to - from).mul_add(self.part, from);
            (if bound % 2 == 0 { moved - margin } else { moved + margin }).store_slice(into);
        }
        slabs.enter(simd, &node, far)
    }

    #[inline(always)]
    fn children(&self, index: usize) -> &[Child; WIDTH] {
        &self.segment.first.nodes[index].children
    }
}
