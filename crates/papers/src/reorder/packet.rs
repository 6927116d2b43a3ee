//! Packets: up to 64 rays go through the hierarchy together, eight in lanes against one box (Wald et al. 2001; Boulos
//! et al., *Packet-based Whitted and distribution ray tracing*, 2007). A child is visited once for all rays that enter
//! its box.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use umbrage_rays::internals::{BVH_WIDTH, BvhChild, BvhInside, BvhKind, BvhLine, BvhNode};

use super::Counts;
use super::rays::{Group, LANES, Task, bits_below, bits_of, children_of, farthest_first};

/// A waiting child.
struct Entry {
    /// Lower bound on t of the rays' entries.
    enter: f32,
    child: BvhChild,
    /// A bit for each ray that enters.
    rays: u64,
}

#[inline(always)]
pub(super) fn visit<S: Simd>(
    simd: S,
    inside: BvhInside<'_>,
    lines: &[BvhLine],
    task: &mut impl Task,
    counts: &mut Counts,
) {
    let mut groups = Group::all(lines);
    let mut stack = vec![Entry { enter: f32::NEG_INFINITY, child: inside.root, rays: bits_below(lines.len()) }];
    while let Some(Entry { enter, child, rays }) = stack.pop() {
        let rays = waiting(simd, &groups, rays, enter);
        match child.kind() {
            BvhKind::Leaf { index: leaf, lanes } => {
                counts.triangles += u64::from(rays.count_ones() * lanes.count_ones());
                for ray in bits_of(rays) {
                    task.test(simd, ray, leaf, lanes, &mut groups[ray / LANES].far[ray % LANES]);
                }
            }
            BvhKind::Node(index) if rays != 0 => {
                let node = &inside.nodes[index];
                let (enter, entering) = enter_children(simd, &groups, node, rays, children_of(node), counts);
                let met = (0..BVH_WIDTH).fold(0, |met, slot| met | u32::from(entering[slot] != 0) << slot);
                for slot in farthest_first(met, &enter) {
                    stack.push(Entry { enter: enter[slot], child: node.children[slot], rays: entering[slot] });
                }
            }
            BvhKind::Node(_) => {}
        }
    }
}

/// The rays among `rays` for which a hit at t may matter.
#[inline(always)]
pub(super) fn waiting<S: Simd>(simd: S, groups: &[Group], rays: u64, t: f32) -> u64 {
    let mut left = 0;
    for (number, group) in groups.iter().enumerate() {
        let shift = number * LANES;
        if rays >> shift & 0xff != 0 {
            left |= u64::from(group.waiting(simd, t)) << shift;
        }
    }
    rays & left
}

/// t of the first ray's entry into each of some children, and a bit for each ray that enters.
#[inline(always)]
pub(super) fn enter_children<S: Simd>(
    simd: S,
    groups: &[Group],
    node: &BvhNode,
    rays: u64,
    children: u32,
    counts: &mut Counts,
) -> ([f32; BVH_WIDTH], [u64; BVH_WIDTH]) {
    let (mut first, mut entering) = ([f32::INFINITY; BVH_WIDTH], [0; BVH_WIDTH]);
    for slot in bits_of(children.into()) {
        let mut nearest = f32x8::splat(simd, f32::INFINITY);
        for (number, group) in groups.iter().enumerate() {
            let shift = number * LANES;
            let asked = (rays >> shift & 0xff) as u32;
            if asked == 0 {
                continue;
            }
            counts.tested(asked.count_ones());
            let (enter, met) = group.enter(simd, node, slot);
            // Rays that aren't in `rays` only lower the entry.
            nearest = nearest.min(enter);
            entering[slot] |= u64::from(met & asked) << shift;
        }
        if entering[slot] != 0 {
            first[slot] = <[f32; LANES]>::from(nearest).into_iter().fold(f32::INFINITY, f32::min);
        }
    }
    (first, entering)
}
