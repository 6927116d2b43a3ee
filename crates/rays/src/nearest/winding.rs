//! Generalised winding numbers, by a tree of expansions.

use fearless_simd::Simd;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Job;
use super::block::BLOCK;
use super::moments::Moments;
use super::solid_angle::SolidAngles;
use crate::curve_order::CurveOrder;
use crate::parallel::Parallel;
use crate::patches::Curve;
use crate::simd::lanes::bits_of;
use crate::{Triangles, vectorized};

/// Triangles of a leaf, and nodes below a node.
const LEAF: usize = 16;
const CHILDREN: usize = 4;

/// A node is expanded for points farther from its middle than this many of its radii (β of Barill et al. 2018).
const FAR: f64 = 2.0;

/// Slots of points that are computed together.
const SLOTS: usize = 16;

/// A tree of expansions, made when winding numbers of a frame are first wanted: 4 bytes a triangle for ids, and 19 for nodes.
///
/// Triangles are in the order of a curve, not in patches: the grouping of these depends on earlier frames, and so would the
/// bits of sums.
#[derive(Debug, Default)]
pub(super) struct WindingTree {
    is_current: bool,
    /// Triangles that may have an area, along the curve: a leaf has sixteen that follow each other.
    ids: Vec<u32>,
    /// Leaves, then the nodes above, up to a single one.
    levels: Vec<Vec<Node>>,
}

/// 232 bytes.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// The middle of its box.
    middle: DVec3,
    low: DVec3,
    high: DVec3,
    /// The square of the distance beyond which it is expanded.
    far: f64,
    moments: Moments,
}

impl Node {
    /// A node of a box, without moments.
    fn new(low: DVec3, high: DVec3) -> Self {
        let middle = low.midpoint(high);
        let far = FAR * FAR * (high - middle).length_squared();
        Self { middle, low, high, far, moments: Moments::default() }
    }

    fn leaf(triangles: Triangles<'_>, ids: &[u32]) -> Self {
        let corners = || ids.iter().map(|&id| triangles.corners(id).map(Vec3::as_dvec3));
        let low = corners().flatten().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().flatten().fold(DVec3::NEG_INFINITY, DVec3::max);
        let mut node = Self::new(low, high);
        for corners in corners() {
            node.moments.add_triangle(corners.map(|corner| corner - node.middle));
        }
        Self { moments: node.moments.without_trace(), ..node }
    }

    fn above(nodes: &[Self]) -> Self {
        let low = nodes.iter().fold(DVec3::INFINITY, |low, node| low.min(node.low));
        let high = nodes.iter().fold(DVec3::NEG_INFINITY, |high, node| high.max(node.high));
        let mut above = Self::new(low, high);
        for node in nodes {
            above.moments.add_moved(&node.moments, node.middle - above.middle);
        }
        Self { moments: above.moments.without_trace(), ..above }
    }
}

impl WindingTree {
    /// Forgets the frame.
    pub(super) fn forget(&mut self) {
        self.is_current = false;
    }

    /// Makes the tree if it isn't that of the frame.
    pub(super) fn update(&mut self, triangles: Triangles<'_>, order: &mut CurveOrder) {
        if std::mem::replace(&mut self.is_current, true) {
            return;
        }
        let Self { ids, levels, .. } = self;
        ids.clear();
        let along = Curve::sort_triangles(triangles, order).iter().map(|&key| key as u32);
        ids.extend(along.filter(|&id| triangles.usable_corners(id).is_ok()));
        let mut level = 0;
        let mut below = ids.len().div_ceil(LEAF);
        while level == 0 || below > 1 {
            if levels.len() == level {
                levels.push(Vec::new());
            }
            let (lower, upper) = levels.split_at_mut(level);
            let nodes = &mut upper[0];
            let count = if level == 0 { below } else { below.div_ceil(CHILDREN) };
            nodes.clear();
            nodes.resize(count, Node::new(DVec3::ZERO, DVec3::ZERO));
            match lower.last() {
                None => nodes
                    .par_iter_mut()
                    .with_min_len(64)
                    .zip(ids.par_chunks(LEAF))
                    .each(|(node, ids)| *node = Node::leaf(triangles, ids)),
                Some(lower) => nodes
                    .par_iter_mut()
                    .with_min_len(64)
                    .zip(lower.par_chunks(CHILDREN))
                    .each(|(node, nodes)| *node = Node::above(nodes)),
            }
            below = count;
            level += 1;
        }
        levels.truncate(level);
    }

    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(Vec::capacity).sum();
        self.ids.capacity() * size_of::<u32>() + nodes * size_of::<Node>()
    }

    /// Finds the winding numbers of points, given by the lower halves of `order`: at most [`BLOCK`].
    pub(super) fn answer<S: Simd>(&self, simd: S, job: &Job<'_>, order: &[u64], numbers: &mut [f64]) {
        let mut block = Block::default();
        for (slot, &key) in order.iter().enumerate().take(BLOCK) {
            let point = job.points[key as u32 as usize];
            if point.is_finite() {
                let coordinates = point.to_array().map(f64::from);
                block.points.iter_mut().zip(coordinates).for_each(|(axis, coordinate)| axis[slot] = coordinate);
                block.filled |= 1 << slot;
            }
        }
        let top = self.levels.len() - 1;
        let filled = block.filled;
        if filled != 0 && !self.ids.is_empty() {
            self.descend(simd, job.triangles, &mut block, (top, 0), filled);
        }
        for (slot, number) in numbers.iter_mut().enumerate() {
            const TURN: f64 = 4.0 * std::f64::consts::PI;
            *number = block.far[slot] / TURN + block.near[slot / SLOTS].turns(slot % SLOTS);
        }
    }

    /// Adds a node's solid angles to the given slots: those far from it by its expansion, others by the nodes below.
    fn descend<S: Simd>(
        &self,
        simd: S,
        triangles: Triangles<'_>,
        block: &mut Block,
        (level, number): (usize, usize),
        slots: u64,
    ) {
        let mut near = 0;
        for group in 0..BLOCK / SLOTS {
            let slots = (slots >> (group * SLOTS)) as u16;
            if slots != 0 {
                let is_near = vectorized!(simd => block.expand(&self.levels[level][number], group, slots));
                near |= u64::from(is_near) << (group * SLOTS);
            }
        }
        if near == 0 {
            return;
        }
        if level > 0 {
            let below = number * CHILDREN..self.levels[level - 1].len().min((number + 1) * CHILDREN);
            for number in below {
                self.descend(simd, triangles, block, (level - 1, number), near);
            }
            return;
        }
        let ids = &self.ids[number * LEAF..self.ids.len().min((number + 1) * LEAF)];
        for group in 0..BLOCK / SLOTS {
            let slots = (near >> (group * SLOTS)) as u16;
            if slots != 0 {
                vectorized!(simd => block.add(triangles, ids, group, slots));
            }
        }
    }
}

/// Points, and the solid angles that have been added so far.
struct Block {
    points: [[f64; BLOCK]; 3],
    filled: u64,
    /// Sums of expansions.
    far: [f64; BLOCK],
    /// Those of triangles one by one.
    near: [SolidAngles<SLOTS>; BLOCK / SLOTS],
}

impl Default for Block {
    fn default() -> Self {
        Self { points: [[0.0; BLOCK]; 3], filled: 0, far: [0.0; BLOCK], near: [SolidAngles::default(); BLOCK / SLOTS] }
    }
}

impl Block {
    fn group(&self, group: usize) -> [[f64; SLOTS]; 3] {
        std::array::from_fn(|axis| std::array::from_fn(|lane| self.points[axis][group * SLOTS + lane]))
    }

    /// Adds a node's expansion to those of a group's slots that are far from it; returns the others.
    #[inline(always)]
    fn expand(&mut self, node: &Node, group: usize, slots: u16) -> u16 {
        let [x, y, z] = self.group(group);
        let middle = node.middle;
        let far = &mut self.far[group * SLOTS..][..SLOTS];
        let mut is_far = [false; SLOTS];
        for lane in 0..SLOTS {
            let to = [middle.x - x[lane], middle.y - y[lane], middle.z - z[lane]];
            let square = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
            is_far[lane] = square > node.far;
            let angle = node.moments.solid_angle(to, square);
            let is_wanted = is_far[lane] && slots >> lane & 1 == 1;
            far[lane] += if is_wanted { angle } else { 0.0 };
        }
        bits_of(slots).filter(|&lane| !is_far[lane]).fold(0, |near, lane| near | 1 << lane)
    }

    /// Adds the solid angles of triangles to those of a group's slots.
    #[inline(always)]
    fn add(&mut self, triangles: Triangles<'_>, ids: &[u32], group: usize, slots: u16) {
        let points = self.group(group);
        for &id in ids {
            self.near[group].add(&points, triangles.corners(id), slots);
        }
    }
}
