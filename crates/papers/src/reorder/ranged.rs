//! Large packets, of up to 256 rays (Overbeck et al., *Large ray packets for real-time Whitted ray tracing*, 2008): a
//! child is visited by all groups from the first to the last one that enters its box, and bounds of the whole packet
//! cull children before any ray is tested. The first ray decides the order of children.

use fearless_simd::Simd;
use umbrage_rays::internals::{BVH_WIDTH, BvhChild, BvhInside, BvhKind, BvhLine, BvhNode, BvhSlabs};

use super::Counts;
use super::bounds::Bounds;
use super::rays::{Group, LANES, Task, bits_of, children_of, farthest_first};

/// Maximum number of rays in a packet.
pub(super) const MOST: usize = 256;

/// A waiting child.
struct Entry {
    child: BvhChild,
    /// Its parent node, and its slot there; the root has none.
    parent: Option<(u32, usize)>,
    /// The first and the last group that may enter it.
    groups: [usize; 2],
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
    let bounds = Bounds::of_one(&lines.iter().map(|line| (line, line.far)), |_, _| f32::NEG_INFINITY);
    let all = |group: usize| (1_u32 << (lines.len() - group * LANES).min(LANES)) - 1;
    let mut stack = vec![Entry { child: inside.root, parent: None, groups: [0, groups.len() - 1] }];
    while let Some(Entry { child, parent, groups: [first, last] }) = stack.pop() {
        let mut lead = None;
        for (group, rays_of) in groups.iter().enumerate().take(last + 1).skip(first) {
            let rays = entering(simd, inside, rays_of, all(group), parent, counts);
            if rays != 0 {
                lead = Some((group, rays));
                break;
            }
        }
        let Some((first, rays)) = lead else { continue };
        match child.kind() {
            BvhKind::Leaf { index: leaf, lanes } => {
                for (group, rays_of) in groups.iter_mut().enumerate().take(last + 1).skip(first) {
                    let rays =
                        if group == first { rays } else { entering(simd, inside, rays_of, all(group), parent, counts) };
                    counts.triangles += u64::from(rays.count_ones() * lanes.count_ones());
                    for lane in bits_of(rays.into()) {
                        task.test(simd, group * LANES + lane, leaf, lanes, &mut rays_of.far[lane]);
                    }
                }
            }
            BvhKind::Node(index) => {
                let mut last = last;
                while last > first && entering(simd, inside, &groups[last], all(last), parent, counts) == 0 {
                    last -= 1;
                }
                let node = &inside.nodes[index];
                let mut children = children_of(node);
                if let Some(bounds) = &bounds {
                    counts.tested(children.count_ones());
                    children &= bounds.children(simd, node);
                }
                let ray = &lines[first * LANES + rays.trailing_zeros() as usize];
                for slot in farthest_first(children, &order(simd, ray, node, counts)) {
                    let parent = Some((index as u32, slot));
                    stack.push(Entry { child: node.children[slot], parent, groups: [first, last] });
                }
            }
        }
    }
}

/// A bit for each ray of a group that enters a child.
#[inline(always)]
fn entering<S: Simd>(
    simd: S,
    inside: BvhInside<'_>,
    group: &Group,
    all: u32,
    parent: Option<(u32, usize)>,
    counts: &mut Counts,
) -> u32 {
    let Some((node, slot)) = parent else { return all };
    counts.tested(all.count_ones());
    group.enter(simd, &inside.nodes[node as usize], slot).1 & all
}

/// t at which a ray would enter each child.
#[inline(always)]
fn order<S: Simd>(simd: S, ray: &BvhLine, node: &BvhNode, counts: &mut Counts) -> [f32; BVH_WIDTH] {
    counts.tested(1);
    BvhSlabs::new(simd, ray).enter(simd, node, f32::INFINITY).0.into()
}
