//! Packets that are regrouped (Boulos, Wald and Benthin, *Adaptive ray packet reordering*, 2008): if less than half of
//! the tested lanes have a ray, the remaining rays become a packet of their own below that node. Its bounds begin at
//! the node and end where no hit matters any more, which is the purpose of moving origins to the box and clipping
//! there; rays themselves stay unchanged, since answers must.

use fearless_simd::Simd;
use umbrage_rays::internals::{BVH_WIDTH, BvhChild, BvhInside, BvhKind, BvhLine};

use super::Counts;
use super::bounds::Bounds;
use super::packet::{enter_children, waiting};
use super::rays::{Group, LANES, Task, bits_below, bits_of, children_of, farthest_first};

/// Rays that are traced together.
struct Packet {
    groups: Vec<Group>,
    /// Index of each ray among all rays, and in the packet that it comes from.
    rays: Vec<[usize; 2]>,
    bounds: Option<Bounds>,
}

impl Packet {
    fn new(lines: &[BvhLine], rays: Vec<[usize; 2]>, far: &[f32], face: impl Fn(usize, f32) -> f32) -> Self {
        let set = rays.iter().zip(far).map(|(&[ray, _], &far)| (&lines[ray], far));
        let bounds = Bounds::of_one(&set, face);
        let group = |(rays, far): (&[[usize; 2]], &[f32])| {
            Group::new(rays.iter().zip(far).map(|(&[ray, _], &far)| (&lines[ray], far)))
        };
        let groups = rays.chunks(LANES).zip(far.chunks(LANES)).map(group).collect();
        Self { groups, rays, bounds }
    }

    fn far(&self, ray: usize) -> f32 {
        self.groups[ray / LANES].far[ray % LANES]
    }
}

/// A waiting child.
struct Entry {
    /// Lower bound on t of the rays' entries.
    enter: f32,
    child: BvhChild,
    /// Its parent node, and its slot there; the root has none.
    parent: Option<(u32, usize)>,
    /// Index of its packet.
    packet: usize,
    /// A bit for each ray of the packet.
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
    let far: Vec<f32> = lines.iter().map(|line| line.far).collect();
    let all = (0..lines.len()).map(|ray| [ray; 2]).collect();
    let mut packets = vec![Packet::new(lines, all, &far, |_, _| f32::NEG_INFINITY)];
    let rays = bits_below(lines.len());
    let mut stack = vec![Entry { enter: f32::NEG_INFINITY, child: inside.root, parent: None, packet: 0, rays }];
    while let Some(Entry { enter, child, parent, packet, rays }) = stack.pop() {
        packets.drain(packet + 1..).rev().for_each(drop);
        let mut packet = packet;
        let mut rays = waiting(simd, &packets[packet].groups, rays, enter);
        match child.kind() {
            BvhKind::Leaf { index: leaf, lanes } => {
                counts.triangles += u64::from(rays.count_ones() * lanes.count_ones());
                for ray in bits_of(rays) {
                    let [number, mut from] = packets[packet].rays[ray];
                    let far = &mut packets[packet].groups[ray / LANES].far[ray % LANES];
                    task.test(simd, number, leaf, lanes, far);
                    let far = *far;
                    // The packets that it comes from get the new limit, too.
                    for packet in packets[..packet].iter_mut().rev() {
                        packet.groups[from / LANES].far[from % LANES] = far;
                        from = packet.rays[from][1];
                    }
                }
            }
            BvhKind::Node(index) if rays != 0 => {
                let node = &inside.nodes[index];
                if is_sparse(rays) {
                    let face = |axis: usize, sign: f32| {
                        let Some((node, slot)) = parent else { return f32::NEG_INFINITY };
                        inside.nodes[node as usize].bounds[2 * axis + usize::from(sign < 0.0)][slot] * sign
                    };
                    let from = &packets[packet];
                    let far: Vec<f32> = bits_of(rays).map(|ray| from.far(ray)).collect();
                    let left: Vec<_> = bits_of(rays).map(|ray| [from.rays[ray][0], ray]).collect();
                    rays = bits_below(left.len());
                    counts.regrouped += left.len() as u64;
                    packets.push(Packet::new(lines, left, &far, face));
                    packet += 1;
                }
                let Packet { groups, bounds, .. } = &packets[packet];
                let mut children = children_of(node);
                if let Some(bounds) = bounds {
                    counts.tested(children.count_ones());
                    children &= bounds.children(simd, node);
                }
                let (enter, entering) = enter_children(simd, groups, node, rays, children, counts);
                let met = (0..BVH_WIDTH).fold(0, |met, slot| met | u32::from(entering[slot] != 0) << slot);
                for slot in farthest_first(met, &enter) {
                    let (parent, child) = (Some((index as u32, slot)), node.children[slot]);
                    stack.push(Entry { enter: enter[slot], child, parent, packet, rays: entering[slot] });
                }
            }
            BvhKind::Node(_) => {}
        }
    }
}

/// Whether less than half of the tested lanes have a ray, and fewer groups would have room for the rays.
fn is_sparse(rays: u64) -> bool {
    let groups = rays.to_le_bytes().into_iter().filter(|&group| group != 0).count();
    let count = rays.count_ones() as usize;
    2 * count < LANES * groups && count.div_ceil(LANES) < groups
}
