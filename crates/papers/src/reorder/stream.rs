//! Streams of 64×64 rays (Gribble and Ramani, *Coherent ray tracing via stream filtering*, 2008): a node filters its
//! list of rays to a list for each child, a leaf to the rays that may hit a triangle. Filters of the paper test lanes
//! of rays against one box; here a ray is tested against the boxes of eight children, so that no lane is wasted on
//! short lists.

use fearless_simd::Simd;
use umbrage_rays::internals::{BVH_WIDTH, BvhChild, BvhInside, BvhKind, BvhLine, BvhSlabs};

use super::Counts;
use super::rays::{Task, bits_of, children_of, farthest_first};

/// Maximum number of rays in a stream.
pub(super) const MOST: usize = 64 * 64;

/// A waiting child.
struct Entry {
    child: BvhChild,
    /// Start of its list, which ends at the start of the next.
    start: usize,
}

/// The children that a ray enters at a node.
struct Filtered {
    ray: u32,
    children: u32,
    enter: [f32; BVH_WIDTH],
}

#[inline(always)]
pub(super) fn visit<S: Simd>(
    simd: S,
    inside: BvhInside<'_>,
    lines: &[BvhLine],
    task: &mut impl Task,
    counts: &mut Counts,
) {
    let mut far: Vec<f32> = lines.iter().map(|line| line.far).collect();
    // All lists, one after the other: rays, and t of each one's entry into the child.
    let mut lists: Vec<(u32, f32)> = (0..lines.len() as u32).map(|ray| (ray, f32::NEG_INFINITY)).collect();
    let mut filtered: Vec<Filtered> = Vec::with_capacity(lines.len());
    let mut stack = vec![Entry { child: inside.root, start: 0 }];
    while let Some(Entry { child, start }) = stack.pop() {
        match child.kind() {
            BvhKind::Leaf { index: leaf, lanes } => {
                for &(ray, enter) in &lists[start..] {
                    let (ray, far) = (ray as usize, &mut far[ray as usize]);
                    if enter <= *far {
                        counts.triangles += u64::from(lanes.count_ones());
                        task.test(simd, ray, leaf, lanes, far);
                    }
                }
                lists.truncate(start);
            }
            BvhKind::Node(index) => {
                let node = &inside.nodes[index];
                let used = children_of(node).count_ones();
                filtered.clear();
                let (mut first, mut met) = ([f32::INFINITY; BVH_WIDTH], 0);
                for (ray, enter) in lists.drain(start..) {
                    let far = far[ray as usize];
                    if enter > far {
                        continue;
                    }
                    counts.tested(used);
                    let (enter, children) = BvhSlabs::new(simd, &lines[ray as usize]).enter(simd, node, far);
                    let (enter, children): ([f32; BVH_WIDTH], _) = (enter.into(), children as u32);
                    met |= children;
                    for slot in bits_of(children.into()) {
                        first[slot % BVH_WIDTH] = first[slot % BVH_WIDTH].min(enter[slot % BVH_WIDTH]);
                    }
                    filtered.push(Filtered { ray, children, enter });
                }
                for slot in farthest_first(met, &first) {
                    stack.push(Entry { child: node.children[slot], start: lists.len() });
                    let of_child = filtered.iter().filter(|filtered| filtered.children >> slot & 1 == 1);
                    lists.extend(of_child.map(|filtered| (filtered.ray, filtered.enter[slot])));
                }
            }
        }
    }
}
