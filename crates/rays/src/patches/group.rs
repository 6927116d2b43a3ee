use crate::parallel::{Parallel, both};
use rayon::prelude::*;

use super::order::Curve;
use super::{MOST_TRIANGLES, MOST_VERTICES, Patches, Start};
use crate::curve_order::CurveOrder;
use crate::simd::lanes::LANES;
use crate::{Bounds, Triangles};

/// Triangles that one thread groups at once. A patch ends there: on average half a patch is lost per part.
const PART: usize = 1 << 12;

/// Memory for grouping by nearness, reused.
#[derive(Debug, Default)]
pub(super) struct Groups {
    pub(super) order: CurveOrder,
    parts: Vec<CurvePart>,
}

/// The patches of [`PART`] consecutive triangles along the curve.
#[derive(Debug, Default)]
struct CurvePart {
    patches: Patches,
    patch: Unfinished,
}

impl Groups {
    pub(super) fn bytes(&self) -> usize {
        self.order.bytes() + self.parts.iter().map(|part| part.patches.bytes()).sum::<usize>()
    }
}

impl CurvePart {
    fn fill(&mut self, triangles: Triangles<'_>, along: &[u64]) {
        let Self { patches, patch } = self;
        patches.clear(along.len());
        patch.clear();
        for id in along.iter().map(|&key| key as u32) {
            let corners = triangles.indices[id as usize];
            if !patches.keep(triangles, id) {
                continue;
            }
            if !patch.add(id, corners) {
                patches.push(patch);
                patch.clear();
                patch.add(id, corners);
            }
        }
        patches.push(patch);
    }
}

/// The remaining room for consecutive parts.
struct RoomLeft<'a> {
    starts: &'a mut [Start],
    vertices: &'a mut [u32],
    corners: &'a mut [[u8; 4]],
    ids: &'a mut [u32],
    /// The end of the parts before it.
    before: Start,
}

impl RoomLeft<'_> {
    fn write(self, parts: &[CurvePart]) {
        let (low, high) = parts.split_at(parts.len() / 2);
        let [only] = parts else {
            if !parts.is_empty() {
                let (before, after) = self.split(low);
                both(|| before.write(low), || after.write(high));
            }
            return;
        };
        let patches = &only.patches;
        for (start, of) in self.starts.iter_mut().zip(&patches.starts) {
            let (vertex, triangle) = (self.before.vertex + of.vertex, self.before.triangle + of.triangle);
            *start = Start { vertex, triangle, count: of.count };
        }
        self.vertices.copy_from_slice(&patches.vertices);
        self.corners.copy_from_slice(&patches.corners);
        self.ids.copy_from_slice(&patches.ids);
    }

    /// The room for some parts, and the rest.
    fn split(self, parts: &[CurvePart]) -> (Self, Self) {
        let sum = |length: fn(&Patches) -> usize| parts.iter().map(|part| length(&part.patches)).sum::<usize>();
        let (vertices, triangles) = (sum(|part| part.vertices.len()), sum(|part| part.ids.len()));
        let starts = self.starts.split_at_mut(sum(Patches::len));
        let vertices_of = self.vertices.split_at_mut(vertices);
        let corners = self.corners.split_at_mut(triangles);
        let ids = self.ids.split_at_mut(triangles);
        let middle = Start {
            vertex: self.before.vertex + vertices as u32,
            triangle: self.before.triangle + triangles as u32,
            count: 0,
        };
        (
            Self { starts: starts.0, vertices: vertices_of.0, corners: corners.0, ids: ids.0, before: self.before },
            Self { starts: starts.1, vertices: vertices_of.1, corners: corners.1, ids: ids.1, before: middle },
        )
    }
}

impl Patches {
    /// Replaces all patches by groups of triangles near each other in this frame.
    pub(super) fn group(&mut self, triangles: Triangles<'_>) {
        self.clear(triangles.len());
        let Groups { order, parts } = &mut self.groups;
        let along = Curve::sort_triangles(triangles, order).par_chunks(PART);
        parts.resize_with(along.len(), CurvePart::default);
        parts.par_iter_mut().zip(along).each(|(part, along)| part.fill(triangles, along));
        let mut end = Start::default();
        let mut patches = 0;
        for CurvePart { patches: of, .. } in &*parts {
            patches += of.len();
            end.vertex += of.vertices.len() as u32;
            end.triangle += of.ids.len() as u32;
            self.in_none.extend_from_slice(&of.in_none);
            self.vertices_needed = self.vertices_needed.max(of.vertices_needed);
        }
        self.starts.resize(patches + 1, end);
        self.starts[patches] = end;
        self.vertices.resize(end.vertex as usize, 0);
        self.corners.resize(end.triangle as usize, [0; 4]);
        self.ids.resize(end.triangle as usize, Self::NONE);
        let Self { starts, vertices, corners, ids, .. } = self;
        let rest = RoomLeft { starts: &mut starts[..patches], vertices, corners, ids, before: Start::default() };
        rest.write(parts);
    }

    /// Whether all corners of a triangle exist, so that it may be in a patch; notes the triangle if not.
    pub(super) fn keep(&mut self, triangles: Triangles<'_>, id: u32) -> bool {
        let exists = triangles.has_all_corners(id);
        if exists {
            let last = triangles.indices[id as usize].into_iter().max().unwrap_or_default();
            self.vertices_needed = self.vertices_needed.max(last as usize + 1);
        } else {
            self.in_none.push(id);
        }
        exists
    }

    /// Removes all patches, for a frame with this number of triangles.
    pub(super) fn clear(&mut self, triangles: usize) {
        self.made += 1;
        self.starts.clear();
        self.vertices.clear();
        self.corners.clear();
        self.ids.clear();
        self.in_none.clear();
        self.triangles = triangles;
        self.vertices_needed = 0;
        self.are_grown = false;
        self.starts.push(Start::default());
    }

    /// Adds a patch, unless it is empty.
    pub(super) fn push(&mut self, patch: &Unfinished) {
        let Unfinished { vertices, corners, ids, .. } = patch;
        let (Some(&first), Some(last)) = (vertices.first(), self.starts.last_mut()) else { return };
        last.count = ids.len() as u32;
        self.vertices.extend_from_slice(vertices);
        self.vertices.resize(self.vertices.len().next_multiple_of(LANES), first);
        self.corners.extend_from_slice(corners);
        self.corners.resize(self.corners.len().next_multiple_of(LANES), [0; 4]);
        self.ids.extend_from_slice(ids);
        self.ids.resize(self.corners.len(), Self::NONE);
        let (vertex, triangle) = (self.vertices.len() as u32, self.ids.len() as u32);
        self.starts.push(Start { vertex, triangle, count: 0 });
    }
}

/// A patch under construction.
#[derive(Debug)]
pub(super) struct Unfinished {
    vertices: Vec<u32>,
    corners: Vec<[u8; 4]>,
    ids: Vec<u32>,
    /// By a hash of the vertex: its index in `vertices` plus one, or zero.
    slots: [u8; Self::SLOTS],
}

impl Default for Unfinished {
    fn default() -> Self {
        Self { vertices: Vec::new(), corners: Vec::new(), ids: Vec::new(), slots: [0; Self::SLOTS] }
    }
}

impl Unfinished {
    const SLOTS: usize = 4 * MOST_VERTICES;

    /// Adds a triangle if there is room for it; returns whether there was.
    pub(super) fn add(&mut self, id: u32, corners: [u32; 3]) -> bool {
        if !self.has_room() {
            let new = corners.iter().filter(|&&vertex| self.find(vertex).1.is_none()).count();
            if self.ids.len() == MOST_TRIANGLES || self.vertices.len() + new > MOST_VERTICES {
                return false;
            }
        }
        let [a, b, c] = corners.map(|vertex| self.number(vertex));
        self.corners.push([a, b, c, 0]);
        self.ids.push(id);
        true
    }

    /// The index of a vertex in the patch; adds it if it isn't there.
    #[inline(always)]
    fn number(&mut self, vertex: u32) -> u8 {
        let (slot, known) = self.find(vertex);
        known.unwrap_or_else(|| {
            self.vertices.push(vertex);
            self.slots[slot] = self.vertices.len() as u8;
            self.slots[slot] - 1
        })
    }

    /// The slot of a vertex, and its index in the patch, if any.
    #[inline(always)]
    fn find(&self, vertex: u32) -> (usize, Option<u8>) {
        let mut slot = vertex.wrapping_mul(0x9E37_79B9) as usize >> 24;
        loop {
            match self.slots[slot] {
                0 => return (slot, None),
                number if self.vertices[usize::from(number) - 1] == vertex => return (slot, Some(number - 1)),
                _ => slot = (slot + 1) % Self::SLOTS,
            }
        }
    }

    /// The number of triangles.
    pub(super) fn len(&self) -> usize {
        self.ids.len()
    }

    /// The bounds in a frame.
    pub(super) fn bounds(&self, triangles: Triangles<'_>) -> Bounds {
        Bounds::of_points(self.vertices.iter().map(|&vertex| triangles.positions[vertex as usize]))
    }

    /// Whether there is room for any triangle.
    pub(super) fn has_room(&self) -> bool {
        self.ids.len() < MOST_TRIANGLES && self.vertices.len() + 3 <= MOST_VERTICES
    }

    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.corners.clear();
        self.ids.clear();
        self.slots.fill(0);
    }
}
