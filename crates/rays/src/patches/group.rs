use super::{MOST_TRIANGLES, MOST_VERTICES, Patches, Start};
use crate::simd::lanes::LANES;
use crate::{Bounds, Triangles};

impl Patches {
    /// Replaces all patches by groups of triangles that come one after the other.
    pub(super) fn group(&mut self, triangles: Triangles<'_>) {
        self.clear(triangles.len());
        let mut patch = Unfinished::default();
        for (id, corners) in triangles.indices.iter().enumerate() {
            if self.keep(triangles, id as u32) && !patch.add(id as u32, *corners) {
                self.push(&patch);
                patch.clear();
                patch.add(id as u32, *corners);
            }
        }
        self.push(&patch);
    }

    /// Whether all corners of a triangle exist, so that it may be in a patch; notes it if not.
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

    /// Forgets all patches; the frame has so many triangles.
    pub(super) fn clear(&mut self, triangles: usize) {
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

/// A patch that is being made.
#[derive(Debug)]
pub(super) struct Unfinished {
    vertices: Vec<u32>,
    corners: Vec<[u8; 4]>,
    ids: Vec<u32>,
    /// By a hash of the vertex: one more than its index in `vertices`, or zero.
    slots: [u8; Self::SLOTS],
}

impl Default for Unfinished {
    fn default() -> Self {
        Self { vertices: Vec::new(), corners: Vec::new(), ids: Vec::new(), slots: [0; Self::SLOTS] }
    }
}

impl Unfinished {
    const SLOTS: usize = 4 * MOST_VERTICES;

    /// Adds a triangle, if there is room for it.
    pub(super) fn add(&mut self, id: u32, corners: [u32; 3]) -> bool {
        let known = corners.map(|vertex| self.find(vertex));
        let new = known.iter().filter(|(_, index)| index.is_none()).count();
        if self.ids.len() == MOST_TRIANGLES || self.vertices.len() + new > MOST_VERTICES {
            return false;
        }
        let mut local = [0; 4];
        for ((local, vertex), (_, known)) in local.iter_mut().zip(corners).zip(known) {
            *local = known.unwrap_or_else(|| self.number(vertex));
        }
        self.corners.push(local);
        self.ids.push(id);
        true
    }

    /// The number of a vertex that was new: a triangle may have the same one twice.
    fn number(&mut self, vertex: u32) -> u8 {
        let (slot, known) = self.find(vertex);
        known.unwrap_or_else(|| {
            self.vertices.push(vertex);
            self.slots[slot] = self.vertices.len() as u8;
            self.slots[slot] - 1
        })
    }

    /// The slot of a vertex, and which one of the patch's it is, if any.
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

    /// How many triangles it has.
    pub(super) fn len(&self) -> usize {
        self.ids.len()
    }

    /// Where it is in a frame.
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
