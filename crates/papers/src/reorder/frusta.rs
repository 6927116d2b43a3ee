//! Multi-frusta tracing (Benthin and Wald, *Efficient ray traced soft shadows using multi-frusta tracing*, 2009): each
//! lane has a frustum around eight rays, and a box is tested with eight frusta at once. A frustum ends when all of its
//! rays have.

use fearless_simd::Simd;
use umbrage_rays::internals::{BvhChild, BvhInside, BvhKind, BvhLine};

use super::Counts;
use super::bounds::Bounds;
use super::packet;
use super::rays::{Group, LANES, Task, bits_of, children_of, farthest_first};

/// A waiting child.
struct Entry {
    child: BvhChild,
    /// Its parent node, and its slot there; the root has none.
    parent: Option<(u32, usize)>,
    /// A bit for each frustum.
    frusta: u32,
}

/// Visits leaves with the frusta. Rays without common bounds are traced as a packet.
#[inline(always)]
pub(super) fn visit<S: Simd>(
    simd: S,
    inside: BvhInside<'_>,
    lines: &[BvhLine],
    task: &mut impl Task,
    counts: &mut Counts,
) {
    let sets = lines.chunks(LANES).map(|lines| lines.iter().map(|line| (line, line.far)));
    let Some(bounds) = Bounds::new(sets, |_, _| f32::NEG_INFINITY) else {
        return packet::visit(simd, inside, lines, task, counts);
    };
    let mut groups = Group::all(lines);
    let mut alive = (1_u32 << groups.len()) - 1;
    let mut stack = vec![Entry { child: inside.root, parent: None, frusta: alive }];
    while let Some(Entry { child, parent, frusta }) = stack.pop() {
        let frusta = frusta & alive;
        match child.kind() {
            BvhKind::Leaf { index: leaf, lanes } => {
                for frustum in bits_of(frusta.into()) {
                    let group = &mut groups[frustum];
                    let all = (1_u32 << (lines.len() - frustum * LANES).min(LANES)) - 1;
                    let mut rays = all;
                    if let Some((node, slot)) = parent {
                        counts.tested(all.count_ones());
                        rays &= group.enter(simd, &inside.nodes[node as usize], slot).1;
                    }
                    counts.triangles += u64::from(rays.count_ones() * lanes.count_ones());
                    for lane in bits_of(rays.into()) {
                        task.test(simd, frustum * LANES + lane, leaf, lanes, &mut group.far[lane]);
                    }
                    if rays != 0 && group.waiting(simd, f32::MIN) == 0 {
                        alive &= !(1 << frustum);
                    }
                }
            }
            BvhKind::Node(index) if frusta != 0 => {
                let node = &inside.nodes[index];
                let mut entering = [0; 8];
                let mut met = 0;
                for slot in bits_of(children_of(node).into()) {
                    counts.tested(frusta.count_ones());
                    entering[slot] = bounds.entering(simd, node, slot) & frusta;
                    met |= u32::from(entering[slot] != 0) << slot;
                }
                for slot in farthest_first(met, &bounds.order(node)) {
                    let parent = Some((index as u32, slot));
                    stack.push(Entry { child: node.children[slot], parent, frusta: entering[slot] });
                }
            }
            BvhKind::Node(_) => {}
        }
    }
}
