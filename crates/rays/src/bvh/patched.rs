use std::ops::Range;

use crate::parallel::Parallel;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::leaf::Leaf;
use super::split::{Extent, Item};
use super::{Bvh, Child, Node, WIDTH};
use crate::Triangles;
use crate::patches::{MOST_TRIANGLES, Patch, Patches};
use crate::simd::lanes::LANES;

/// Patches, and the order of their triangles in leaves: found once for all frames with the same patches. A patch has a leaf
/// for each eight of its triangles, and becomes a node unless it is opened.
#[derive(Default)]
pub(super) struct Patched {
    patches: Patches,
    /// [`Patches::made`] of these patches.
    made: u64,
    /// Each patch's triangles in the order of its leaves, by their index in the patch.
    order: Vec<u8>,
    /// The first leaf of each patch.
    first_leaf: Vec<u32>,
    /// The numbers of nodes and items before each patch in this frame.
    before: Vec<Before>,
}

impl Patched {
    pub(super) fn bytes(&self) -> usize {
        self.patches.bytes()
            + self.order.capacity()
            + self.first_leaf.capacity() * size_of::<u32>()
            + self.before.capacity() * size_of::<Before>()
    }

    /// Arranges the triangles of all patches, unless that was done for these patches.
    fn arrange(&mut self, triangles: Triangles<'_>) {
        let Self { patches, made, order, first_leaf, .. } = self;
        if *made == patches.made() && !first_leaf.is_empty() {
            return;
        }
        *made = patches.made();
        let arranged: Vec<_> = (0..patches.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|number| arranged(triangles, &patches.get(number)))
            .collect();
        order.clear();
        first_leaf.clear();
        let mut leaf = 0;
        for (number, arranged) in arranged.iter().enumerate() {
            let count = patches.get(number).count;
            first_leaf.push(leaf);
            leaf += count.div_ceil(Leaf::LANES) as u32;
            // One for each slot.
            order.extend_from_slice(&arranged[..count.next_multiple_of(LANES)]);
        }
        first_leaf.push(leaf);
    }
}

/// A patch's triangles, ordered so that each eight are near each other.
fn arranged(triangles: Triangles<'_>, patch: &Patch<'_>) -> [u8; MOST_TRIANGLES] {
    let mut order = [0; MOST_TRIANGLES];
    let mut items: Vec<Item> = (0..patch.count)
        .map(|index| {
            let [a, b, c] = triangles.corners(patch.ids[index]).map(|corner| corner.extend(0.0));
            Item::new(Extent { low: a.min(b).min(c), high: a.max(b).max(c) }, index as u32)
        })
        .collect();
    divide(&mut items);
    order.iter_mut().zip(&items).for_each(|(index, item)| *index = item.id() as u8);
    order
}

/// Divides items recursively into eights, the last of which may be smaller, by the surface area heuristic.
fn divide(items: &mut [Item]) {
    if items.len() <= Leaf::LANES {
        return;
    }
    let mut best = (f32::INFINITY, 0, Leaf::LANES);
    for axis in 0..3 {
        sort(items, axis);
        let mut above = [0.0; WIDTH + 1];
        let mut extent = Extent::EMPTY;
        for (eight, items) in items.chunks(Leaf::LANES).enumerate().rev() {
            extent = items.iter().fold(extent, |extent, item| extent.union(item.extent()));
            above[eight] = extent.area();
        }
        let mut extent = Extent::EMPTY;
        let eights = items.len().div_ceil(Leaf::LANES);
        for (eight, of_eight) in items.chunks(Leaf::LANES).enumerate().take(eights - 1) {
            extent = of_eight.iter().fold(extent, |extent, item| extent.union(item.extent()));
            let cost = extent.area() * (eight + 1) as f32 + above[eight + 1] * (eights - eight - 1) as f32;
            if cost < best.0 {
                best = (cost, axis, (eight + 1) * Leaf::LANES);
            }
        }
    }
    let (_, axis, first) = best;
    sort(items, axis);
    let (below, above) = items.split_at_mut(first);
    divide(below);
    divide(above);
}

fn sort(items: &mut [Item], axis: usize) {
    items.sort_unstable_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]).then(a.id().cmp(&b.id())));
}

/// Patches that one thread makes nodes of.
const CHUNK: usize = 64;

/// Patches whose boxes have more than this share of the mean surface are opened: the hierarchy above has their leaves
/// instead of them, so that it can group near ones, as Benthin et al. do with objects (*Improved two-level BVHs using
/// partial re-braiding*, 2017). In `demo:hall`, this makes rays of a diffuse bounce 1.3 times as fast.
const OPENED: f32 = 0.5;

/// The numbers of nodes and items before a patch.
#[derive(Clone, Copy, Default)]
struct Before {
    nodes: u32,
    items: u32,
}

impl Patched {
    /// Decides which patches are opened, and counts the nodes and items before each patch and after the last.
    fn open(&mut self, scale: f32) {
        let Self { patches, first_leaf, before, .. } = self;
        let count = patches.len();
        let area = |number: usize| {
            let [low, high] = patches.bounds.sixteens[number / LANES].get(number % LANES);
            let extent = [low, high].map(|corner| Vec3::from_array(corner).extend(0.0) * scale);
            Extent { low: extent[0], high: extent[1] }.area()
        };
        let least = OPENED * ((0..count).map(|number| f64::from(area(number))).sum::<f64>() / count as f64) as f32;
        let mut next = Before::default();
        before.clear();
        before.push(next);
        before.extend((0..count).map(|number| {
            if area(number) > least {
                next.items += first_leaf[number + 1] - first_leaf[number];
            } else {
                next.nodes += 1;
                next.items += 1;
            }
            next
        }));
    }
}

impl Bvh {
    /// Builds over patches. Returns false where these may not last, or some coordinates aren't finite.
    pub(super) fn build_of_patches(&mut self, triangles: Triangles<'_>) -> bool {
        let Self { level, nodes, leaves, scale, root, builder, patched, omitted, .. } = self;
        patched.patches.update(triangles, *level);
        // Triangles without an area do no harm.
        let is_finite = patched.patches.omitted().not_finite.count == 0;
        if !is_finite || patched.patches.is_changing() || patched.patches.len() == 0 {
            return false;
        }
        omitted.clone_from(patched.patches.omitted());
        patched.arrange(triangles);
        patched.open(*scale);
        let Patched { patches, first_leaf, before, .. } = &*patched;
        let count = patches.len();
        let all = before[count];
        nodes.resize(nodes.len().max(all.nodes as usize), Node::EMPTY);
        leaves.resize(first_leaf[count] as usize, Leaf::EMPTY);
        builder.items.resize(all.items as usize, Item::default());
        let (mut nodes_left, mut items_left) = (nodes.as_mut_slice(), builder.items.as_mut_slice());
        let mut leaves_left = leaves.as_mut_slice();
        let chunks = (0..count).step_by(CHUNK).map(|first| {
            let end = (first + CHUNK).min(count);
            let (from, to) = (before[first], before[end]);
            Chunk {
                patches: first..end,
                nodes: take(&mut nodes_left, to.nodes - from.nodes),
                items: take(&mut items_left, to.items - from.items),
                leaves: take(&mut leaves_left, first_leaf[end] - first_leaf[first]),
            }
        });
        chunks.collect::<Vec<_>>().into_par_iter().each(|chunk| patched.fill(chunk, *scale));
        let built = builder.build(1);
        let of_patches = all.nodes as usize;
        nodes.resize(of_patches + built.nodes, Node::EMPTY);
        *root = Child::node(of_patches);
        built.write_nodes(&mut nodes[of_patches..], of_patches, |_, items| Child(items[0].id()));
        true
    }
}

/// Patches that one thread makes nodes, items and leaves of.
struct Chunk<'a> {
    patches: Range<usize>,
    nodes: &'a mut [Node],
    items: &'a mut [Item],
    leaves: &'a mut [Leaf],
}

/// Takes the first `count` elements off a slice.
fn take<'a, T>(from: &mut &'a mut [T], count: u32) -> &'a mut [T] {
    let first;
    (first, *from) = std::mem::take(from).split_at_mut(count as usize);
    first
}

impl Patched {
    fn fill(&self, chunk: Chunk<'_>, scale: f32) {
        let Chunk { patches, mut nodes, mut items, mut leaves } = chunk;
        for number in patches {
            let (from, to) = (self.before[number], self.before[number + 1]);
            let first_leaf = self.first_leaf[number];
            let leaves = take(&mut leaves, self.first_leaf[number + 1] - first_leaf);
            let items = take(&mut items, to.items - from.items);
            let mut boxes = [(Extent::EMPTY, Child::NONE); WIDTH];
            let boxes = &mut boxes[..leaves.len()];
            self.fill_leaves(number, leaves, boxes, scale);
            if let [node] = take(&mut nodes, to.nodes - from.nodes) {
                *node = Node::EMPTY;
                let mut whole = Extent::EMPTY;
                for (slot, &(extent, child)) in boxes.iter().enumerate() {
                    node.set_bounds(slot, extent);
                    node.children[slot] = child;
                    whole = whole.union(extent);
                }
                items[0] = Item::new(whole, Child::node(from.nodes as usize).0);
            } else {
                items.iter_mut().zip(boxes).for_each(|(item, (extent, child))| *item = Item::new(*extent, child.0));
            }
        }
    }

    /// Fills the leaves of a patch, and writes the box and the reference of each.
    fn fill_leaves(&self, number: usize, leaves: &mut [Leaf], boxes: &mut [(Extent, Child)], scale: f32) {
        let (patch, positions) = (self.patches.get(number), self.patches.positions(number));
        let position = |vertex: u8| {
            let of_sixteen = &positions[usize::from(vertex) / LANES];
            let lane = usize::from(vertex) % LANES;
            Vec4::new(of_sixteen[0][lane], of_sixteen[1][lane], of_sixteen[2][lane], 0.0) * scale
        };
        let first_leaf = self.first_leaf[number] as usize;
        let order = &self.order[self.patches.first_slot(number)..][..patch.count];
        for (index, (leaf, order)) in leaves.iter_mut().zip(order.chunks(Leaf::LANES)).enumerate() {
            let mut extent = Extent::EMPTY;
            for (lane, &index) in order.iter().enumerate() {
                let [a, b, c, _] = patch.corners[usize::from(index)].map(position);
                extent = extent.union(Extent { low: a.min(b).min(c), high: a.max(b).max(c) });
                leaf.set(lane, patch.ids[usize::from(index)], [a, b, c]);
            }
            boxes[index] = (extent, Child::leaf(first_leaf + index, order.len()));
        }
    }
}
