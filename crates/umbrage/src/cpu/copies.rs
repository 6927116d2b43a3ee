use umbrage_rays::{HashKey, Omitted, Opacity as _, Sides, Triangles};
use umbrage_scene::Frame;

use super::opacities;
use crate::Stats;
use crate::stats::OmittedTriangles;

/// Triangles that no ray can tell from an opaque one of a lower id. They have the same corners in the same order around, and
/// no side that the original lacks: they are hit with it, at the same t, and shadow the same points.
///
/// They are found, and left out, where a sample shows many at one position. Each ray there would ask the predicate about all
/// of them: 10 000 on 64 × 64 pixels took 3 seconds to see and shadow through the hierarchy, 6 through the perspective grid.
#[derive(Debug, Default)]
pub(super) struct Copies {
    /// The frame's triangles, with copies collapsed to points; empty where no search was made.
    indices: Vec<[u32; 3]>,
    /// A hash table: the original triangle with certain corners, and the number of triangles with them.
    table: Vec<(u32, u32)>,
    /// The ids of the first copies, and the number of all.
    first_ids: Vec<u32>,
    count: u32,
}

impl Copies {
    /// The sample's size: at least so many triangles of a frame, and one in so many.
    const SAMPLE: (usize, usize) = (256, 1024);
    /// All triangles are compared where this many of the sample are copies of one another.
    const MANY: u32 = 6;
    const FREE: u32 = u32::MAX;

    /// Looks for the copies among a frame's triangles.
    pub(super) fn find(&mut self, frame: &Frame, sides: Sides<'_>) {
        self.indices.clear();
        self.first_ids.clear();
        self.count = 0;
        let triangles = frame.triangles();
        let sampled = triangles.len().min(Self::SAMPLE.0.max(triangles.len() / Self::SAMPLE.1));
        if sampled < Self::MANY as usize || self.most_alike(triangles, sampled) < Self::MANY {
            return;
        }
        self.indices.extend_from_slice(triangles.indices);
        let opacities = opacities(frame);
        let is_opaque = |id| opacities.iter().all(|opacity| opacity.is_opaque(id));
        self.clear_table(triangles.len());
        for id in 0..triangles.len() as u32 {
            let Some((original, _)) = slot(&mut self.table, triangles, id) else { continue };
            let has_more = *original != Self::FREE && sides.has_back(id) && !sides.has_back(*original);
            if *original == Self::FREE || has_more || !is_opaque(*original) {
                *original = id;
                continue;
            }
            self.indices[id as usize] = [triangles.indices[id as usize][0]; 3];
            self.count += 1;
            if self.first_ids.len() < umbrage_rays::OmittedKind::IDS {
                self.first_ids.push(id);
            }
        }
    }

    /// The largest number of triangles in a sample with the same corners.
    fn most_alike(&mut self, triangles: Triangles<'_>, sampled: usize) -> u32 {
        self.clear_table(sampled);
        let mut most = 0;
        for number in 0..sampled {
            // One from each stretch of the list: a fixed step would meet only the floors of a row of houses.
            let [start, end] = [number, number + 1].map(|part| part * triangles.len() / sampled);
            let id = start + mixed(number as u64) as usize % (end - start);
            let Some((first, count)) = slot(&mut self.table, triangles, id as u32) else { continue };
            *first = id as u32;
            *count += 1;
            most = most.max(*count);
        }
        most
    }

    /// Makes room for `triangles` triangles.
    fn clear_table(&mut self, triangles: usize) {
        self.table.clear();
        self.table.resize((2 * triangles).next_power_of_two(), (Self::FREE, 0));
    }

    /// The frame's triangles, with copies collapsed to points, which no structure lists.
    pub(super) fn triangles<'a>(&'a self, frame: &'a Frame) -> Triangles<'a> {
        let triangles = frame.triangles();
        if self.indices.is_empty() { triangles } else { Triangles { indices: &self.indices, ..triangles } }
    }

    /// Counts the triangles that a structure has left out, and the copies.
    pub(super) fn count_omitted(&self, frame: &Frame, omitted: &Omitted, stats: &mut Stats) {
        if self.count == 0 {
            stats.count_omitted(omitted);
            return;
        }
        stats.count_omitted(&frame.triangles().omitted());
        stats.omitted.push(OmittedTriangles {
            reason: "a copy of an earlier triangle",
            count: self.count,
            first_ids: self.first_ids.clone(),
        });
    }
}

/// The table's slot for the corners of triangle `id`; `None` where no ray can hit the triangle.
fn slot<'t>(table: &'t mut [(u32, u32)], triangles: Triangles<'_>, id: u32) -> Option<&'t mut (u32, u32)> {
    let corners = ordered(triangles, id)?;
    let key = HashKey::default();
    let hash = corners.as_flattened().iter().fold(key.start(), |hash, &bits| key.mix(hash, bits.into()));
    let last = table.len() - 1;
    let mut index = hash as usize & last;
    while table[index].0 != Copies::FREE && ordered(triangles, table[index].0) != Some(corners) {
        index = (index + 1) & last;
    }
    Some(&mut table[index])
}

/// The corners of a triangle as bits, the least first, in the same order around; `None` where no ray can hit it.
fn ordered(triangles: Triangles<'_>, id: u32) -> Option<[[u32; 3]; 3]> {
    let mut corners = triangles.usable_corners(id).ok()?.map(|corner| corner.to_array().map(f32::to_bits));
    let least = (0..3).min_by_key(|&corner| corners[corner])?;
    corners.rotate_left(least);
    Some(corners)
}

/// Hashes a number, so that nearby numbers are spread.
fn mixed(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 32)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits ^ (bits >> 29)
}
