//! Patches: groups of up to 64 triangles that are near each other, which are culled and set up together.
//!
//! The grouping of triangles is kept while the index buffer stays the same; the bounds of patches are recomputed for every
//! frame. `group` makes patches of triangles near each other in an `order`, `grow` of connected triangles, each in a
//! `region`; `bound` finds their bounds; `tree` has boxes around their boxes.

mod bound;
mod connect;
mod fingerprint;
mod group;
mod grow;
mod order;
mod region;
#[cfg(test)]
mod tests;
mod tree;
mod validate;

use std::ops::Range;
use std::sync::Mutex;

use crate::simd::SimdLevel;
use crate::simd::lanes::LANES;
use crate::{Omitted, Triangles};
pub(crate) use bound::{SixteenBoxes, SixteenPositions, WorldBounds};
use fingerprint::fingerprint;
use group::Groups;
pub(crate) use order::Curve;
pub(crate) use tree::BoxTree;

/// The largest number of triangles in a patch.
pub(crate) const MOST_TRIANGLES: usize = 64;

/// The largest number of vertices in a patch.
pub(crate) const MOST_VERTICES: usize = 64;

/// The growth of boxes at which loose triangles are grouped anew. In a scene of 254 K shards that fly apart, tracing a light
/// takes 12 % (5 ms) longer at 1.16, and 33 % at 1.84; grouping takes 8 ms.
const WORSE: f32 = 1.1;

/// The triangles of a frame in patches, with the bounds of patches and the positions of vertices. About 21 bytes a triangle,
/// and 32 a patch.
///
/// Triangles with a vertex that doesn't exist are in no patch.
#[derive(Debug, Default)]
pub struct Patches {
    /// The first vertex and triangle of each patch, and finally the end of the last one's: multiples of 16.
    starts: Vec<Start>,
    /// Indices of positions. Patches are padded with their first vertex.
    vertices: Vec<u32>,
    /// The corners of each triangle, as indices of its patch's vertices; the fourth is zero.
    corners: Vec<[u8; 4]>,
    /// Each triangle's id. Patches are padded with [`Patches::NONE`].
    ids: Vec<u32>,
    /// The number of triangles in the frame, those in no patch included.
    triangles: usize,
    /// Fingerprint of the index buffer.
    fingerprint: u64,
    /// The number of positions needed for all vertices of patches to exist.
    vertices_needed: usize,
    /// Triangles that are in no patch.
    in_none: Vec<u32>,
    /// Whether patches are of connected triangles, rather than of triangles that were near each other.
    are_grown: bool,
    /// Whether the last frame had another index buffer than the previous one.
    is_changing: bool,
    /// The number of times that patches were made anew.
    made: u64,
    groups: Groups,
    /// For each sixteen of `ids`, the first vertex of their patch.
    first_vertices: Vec<u32>,
    /// Triangles that no ray can hit, in patches or not.
    omitted: Omitted,
    /// Triangles that may have to be omitted, in no order.
    suspects: Mutex<Vec<u32>>,
    /// The size of the boxes when triangles were grouped.
    spread: f32,
    /// The positions of the vertices, sixteen by sixteen.
    positions: Vec<SixteenPositions>,
    /// The bounds of the patches in the world.
    pub(crate) bounds: WorldBounds,
}

/// The start of a patch.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    vertex: u32,
    triangle: u32,
    /// The number of its triangles.
    count: u32,
}

/// One patch of [`Patches`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch<'a> {
    /// Indices of positions: up to [`MOST_VERTICES`], a multiple of 16.
    pub(crate) vertices: &'a [u32],
    /// The corners of each triangle, as indices of `vertices`, padded to a multiple of 16.
    pub(crate) corners: &'a [[u8; 4]],
    /// Ids of the triangles, as many as there are corners.
    pub(crate) ids: &'a [u32],
    /// The number of triangles.
    pub(crate) count: usize,
}

impl Patches {
    /// Id that stands for no triangle.
    pub(crate) const NONE: u32 = u32::MAX;

    /// Updates the patches for the triangles of a frame: they are made anew if the index buffer has changed, and patches of
    /// loose triangles also if these have moved apart.
    ///
    /// Growing takes as long as a few frames: it pays from the second frame with the same index buffer on.
    pub(crate) fn update(&mut self, triangles: Triangles<'_>, level: SimdLevel) {
        let fingerprint = fingerprint(triangles.indices);
        let (is_new, was_grown) = (!self.are_of(triangles, fingerprint), self.are_grown);
        self.fingerprint = fingerprint;
        let was_changing = std::mem::replace(&mut self.is_changing, is_new);
        if is_new {
            self.group(triangles);
            if !was_changing && !self.are_loose() {
                // If the index buffer doesn't change again, patches are grown next.
                self.groups = Groups::default();
            }
        } else if !self.are_grown && !self.are_loose() {
            self.grow(triangles);
        }
        if is_new || was_grown != self.are_grown {
            self.number_vertices();
        }
        self.bound(triangles, level);
        if self.are_grown {
            return;
        }
        let unit = Curve::through_triangles(triangles).size();
        let spread = self.bounds.spread(unit);
        if is_new {
            self.spread = spread;
        } else if spread > WORSE * self.spread {
            self.group(triangles);
            self.number_vertices();
            self.bound(triangles, level);
            self.spread = self.bounds.spread(unit);
        }
    }

    /// Notes the first vertex for each sixteen triangles.
    fn number_vertices(&mut self) {
        let Self { starts, first_vertices, .. } = self;
        first_vertices.clear();
        for patch in starts.windows(2) {
            let sixteens = (patch[1].triangle - patch[0].triangle) as usize / LANES;
            first_vertices.extend(std::iter::repeat_n(patch[0].vertex, sixteens));
        }
    }

    /// Whether triangles share few vertices: a closed mesh has half a vertex a triangle, one with many seams one or two,
    /// shards have three.
    fn are_loose(&self) -> bool {
        2 * self.vertices_needed > 5 * self.triangles
    }

    /// Whether patches are those of a frame with this fingerprint of its index buffer.
    fn are_of(&self, triangles: Triangles<'_>, fingerprint: u64) -> bool {
        let in_range = |id: &u32| triangles.has_all_corners(*id);
        self.triangles == triangles.len()
            && self.fingerprint == fingerprint
            && self.vertices_needed <= triangles.positions.len()
            && !self.in_none.iter().any(in_range)
    }

    /// Checks that the patches have as many triangles as the frame.
    ///
    /// # Panics
    /// If the numbers differ.
    pub(crate) fn expect(&self, triangles: Triangles<'_>) {
        let (built, asked) = (self.triangles, triangles.len());
        assert!(built == asked, "built of {built} triangles, and asked about {asked}");
    }

    /// The triangles of the frame that no ray can hit.
    pub(crate) fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    /// The number of times that patches were made anew: the grouping of triangles stays the same while this does.
    pub(crate) fn made(&self) -> u64 {
        self.made
    }

    /// Whether the last frame had another index buffer than the previous one, so that patches may not last.
    pub(crate) fn is_changing(&self) -> bool {
        self.is_changing
    }

    /// The number of patches.
    pub(crate) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// A patch by its number.
    #[inline(always)]
    pub(crate) fn get(&self, number: usize) -> Patch<'_> {
        let (start, end) = (self.starts[number], self.starts[number + 1]);
        let triangles = start.triangle as usize..end.triangle as usize;
        Patch {
            vertices: &self.vertices[self.vertex_range(number)],
            corners: &self.corners[triangles.clone()],
            ids: &self.ids[triangles],
            count: start.count as usize,
        }
    }

    /// The world positions of a patch's vertices.
    #[inline(always)]
    pub(crate) fn positions(&self, number: usize) -> &[SixteenPositions] {
        let Range { start, end } = self.vertex_range(number);
        &self.positions[start / LANES..end / LANES]
    }

    /// The first slot of a patch in a list of all patches' triangles, each patch padded to a multiple of 16.
    #[inline(always)]
    pub(crate) fn first_slot(&self, number: usize) -> usize {
        self.starts[number].triangle as usize
    }

    /// The id of the triangle at a slot of that list, and its corners as indices of a list of all patches' vertices.
    #[inline(always)]
    pub(crate) fn triangle(&self, slot: u32) -> (u32, [u32; 3]) {
        let slot = slot as usize;
        let first = self.first_vertices[slot / LANES];
        let [a, b, c, _] = self.corners[slot].map(u32::from);
        (self.ids[slot], [first + a, first + b, first + c])
    }

    /// The index of a patch's first vertex in that list; for the patch after the last one, the end of the list.
    pub(crate) fn first_vertex(&self, number: usize) -> usize {
        self.starts[number].vertex as usize
    }

    /// The range of a patch's vertices in a list of all patches' vertices.
    #[inline(always)]
    pub(crate) fn vertex_range(&self, number: usize) -> Range<usize> {
        self.starts[number].vertex as usize..self.starts[number + 1].vertex as usize
    }

    /// The number of vertices of all patches, each padded to a multiple of 16.
    pub(crate) fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<Start>()
            + self.vertices.capacity() * size_of::<u32>()
            + self.corners.capacity() * size_of::<[u8; 4]>()
            + self.ids.capacity() * size_of::<u32>()
            + self.first_vertices.capacity() * size_of::<u32>()
            + self.positions.capacity() * size_of::<SixteenPositions>()
            + self.in_none.capacity() * size_of::<u32>()
            + self.groups.bytes()
            + self.bounds.bytes()
    }
}
