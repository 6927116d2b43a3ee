use glam::Vec4;
use rayon::prelude::*;

use super::leaf::Leaf;
use super::split::{Extent, Item};
use super::{Bvh, Child, Node, WIDTH};
use crate::Triangles;
use crate::patches::{MOST_TRIANGLES, Patch, Patches};
use crate::simd::lanes::LANES;

/// Patches, and how their triangles are arranged in leaves: found once for all frames with the same patches. A patch becomes a
/// node with a leaf for each eight of its triangles.
#[derive(Default)]
pub(super) struct Patched {
    patches: Patches,
    /// Which patches these are, by how often they were made anew.
    made: u64,
    /// Each patch's triangles as they come in its leaves, by their index in the patch.
    order: Vec<u8>,
    /// The first leaf of each patch.
    first_leaf: Vec<u32>,
}

impl Patched {
    pub(super) fn bytes(&self) -> usize {
        self.patches.bytes() + self.order.capacity() + self.first_leaf.capacity() * size_of::<u32>()
    }

    /// Arranges the triangles of all patches anew, if these are others.
    fn arrange(&mut self, triangles: Triangles<'_>) {
        let Self { patches, made, order, first_leaf } = self;
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
            // As many as there are slots.
            order.extend_from_slice(&arranged[..count.next_multiple_of(LANES)]);
        }
        first_leaf.push(leaf);
    }
}

/// A patch's triangles, so that those of each eight are near each other.
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

/// Divides items again and again, so that all but the last eight are eight, by what the surface area heuristic says.
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

impl Bvh {
    /// Builds over patches; false where these may not last, or some coordinates aren't finite.
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
        let Patched { patches, order, first_leaf, .. } = &*patched;
        let count = patches.len();
        nodes.resize(nodes.len().max(count), Node::EMPTY);
        leaves.resize(first_leaf[count] as usize, Leaf::EMPTY);
        builder.items.resize(count, Item::default());
        let mut rest = leaves.as_mut_slice();
        let chunks = nodes[..count].chunks_mut(CHUNK).zip(builder.items.chunks_mut(CHUNK)).enumerate();
        let chunks = chunks.map(|(chunk, (nodes, items))| {
            let first = chunk * CHUNK;
            let leaf_count = first_leaf[first + nodes.len()] - first_leaf[first];
            let leaves;
            (leaves, rest) = std::mem::take(&mut rest).split_at_mut(leaf_count as usize);
            (first, nodes, items, leaves)
        });
        let scale = *scale;
        chunks.collect::<Vec<_>>().into_par_iter().for_each(|(first, nodes, items, leaves)| {
            let mut rest = leaves;
            for (number, (node, item)) in (first..).zip(nodes.iter_mut().zip(items)) {
                let of_patch = (first_leaf[number + 1] - first_leaf[number]) as usize;
                let leaves;
                (leaves, rest) = rest.split_at_mut(of_patch);
                let order = &order[patches.first_slot(number)..];
                let extent = fill(node, leaves, first_leaf[number], patches, number, order, scale);
                *item = Item::new(extent, number as u32);
            }
        });
        let built = builder.build(1);
        nodes.resize(count + built.nodes, Node::EMPTY);
        *root = Child::node(count);
        built.write_nodes(&mut nodes[count..], count, |_, items| Child::node(items[0].id() as usize));
        true
    }
}

/// Makes a node of a patch; the box around it.
fn fill(
    node: &mut Node,
    leaves: &mut [Leaf],
    first_leaf: u32,
    patches: &Patches,
    number: usize,
    order: &[u8],
    scale: f32,
) -> Extent {
    let (patch, positions) = (patches.get(number), patches.positions(number));
    let position = |vertex: u8| {
        let of_sixteen = &positions[usize::from(vertex) / LANES];
        let lane = usize::from(vertex) % LANES;
        Vec4::new(of_sixteen[0][lane], of_sixteen[1][lane], of_sixteen[2][lane], 0.0) * scale
    };
    *node = Node::EMPTY;
    let mut whole = Extent::EMPTY;
    for (slot, (leaf, order)) in leaves.iter_mut().zip(order[..patch.count].chunks(Leaf::LANES)).enumerate() {
        let mut extent = Extent::EMPTY;
        for (lane, &index) in order.iter().enumerate() {
            let [a, b, c, _] = patch.corners[usize::from(index)].map(position);
            extent = extent.union(Extent { low: a.min(b).min(c), high: a.max(b).max(c) });
            leaf.set(lane, patch.ids[usize::from(index)], [a, b, c]);
        }
        node.set_bounds(slot, extent);
        node.children[slot] = Child::leaf(first_leaf as usize + slot, order.len());
        whole = whole.union(extent);
    }
    whole
}
