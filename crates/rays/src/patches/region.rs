use glam::Vec3;

use super::connect::Connections;
use super::group::Unfinished;
use super::grow::GrownPatches;
use super::order::centre;
use super::{MOST_TRIANGLES, Patches};
use crate::simd::lanes::LANES;
use crate::{Bounds, Triangles};

/// Triangles near each other, in which patches grow. Triangles are indices of the region.
#[derive(Debug, Default)]
pub(super) struct Region {
    ids: Vec<u32>,
    centres: Vec<Vec3>,
    connections: Connections,
    /// The index of each triangle in `frontier`, or [`FREE`], or [`TAKEN`].
    states: Vec<u32>,
    /// Candidates for the patch: the neighbours of its triangles.
    frontier: Vec<RimTriangle>,
    /// The neighbours of earlier patches, the latest last; some have been taken since.
    rims: Vec<u32>,
    /// All triangles before this one are taken.
    first_free: usize,
    patch: Unfinished,
    /// The distance at which a patch always accepts an unconnected triangle.
    spacing: f32,
}

const FREE: u32 = u32::MAX;
const TAKEN: u32 = u32::MAX - 1;

/// Number of latest rims that are searched.
const RECENT: usize = 64;

#[derive(Clone, Copy, Debug)]
struct RimTriangle {
    centre: Vec3,
    /// Cost factor, low if most neighbours are taken: the triangle would be left alone.
    weight: f32,
    triangle: u32,
}

impl Region {
    /// Makes patches of the triangles of a region, given by their keys along a curve.
    pub(super) fn grow(&mut self, triangles: Triangles<'_>, along: &[u64]) -> GrownPatches {
        let mut patches = Patches::default();
        patches.clear(0);
        self.ids.clear();
        self.ids.extend(along.iter().map(|&key| key as u32).filter(|&id| patches.keep(triangles, id)));
        self.centres.clear();
        self.centres.extend(self.ids.iter().map(|&id| centre(triangles, id)));
        self.connections.connect(triangles, &self.ids);
        self.states.clear();
        self.states.resize(self.ids.len(), FREE);
        self.rims.clear();
        let mut middles = Vec::new();
        self.first_free = 0;
        let extent = Bounds::of_points(self.centres.iter().copied());
        self.spacing = 0.5 * extent.size().max_element() * (MOST_TRIANGLES as f32 / self.ids.len() as f32).cbrt();
        while let Some(seed) = self.seed() {
            self.grow_patch(triangles, seed);
            middles.push(self.patch.bounds(triangles).center());
            patches.push(&self.patch);
        }
        GrownPatches { patches, middles }
    }

    /// The first triangle of the next patch: the one with the fewest free neighbours next to the latest patches, so that no
    /// scraps are left there.
    fn seed(&mut self) -> Option<u32> {
        while self.rims.last().is_some_and(|&triangle| self.is_taken(triangle)) {
            self.rims.pop();
        }
        let recent = self.recent_rims().min_by_key(|&triangle| self.free_neighbours(triangle));
        recent.or_else(|| self.first_free())
    }

    /// Fills `patch`, starting with one triangle.
    fn grow_patch(&mut self, triangles: Triangles<'_>, seed: u32) {
        self.patch.clear();
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        let mut next = Some(seed);
        while let Some(triangle) = next.take() {
            let id = self.ids[triangle as usize];
            if self.patch.add(id, triangles.indices[id as usize]) {
                self.take(triangle);
                sum += self.centres[triangle as usize];
                count += 1.0;
            } else {
                self.rims.push(triangle);
            }
            let middle = sum / count;
            if self.patch.len() < MOST_TRIANGLES {
                next = self.best(middle).or_else(|| self.near(triangles, middle));
            }
        }
        for candidate in self.frontier.drain(..) {
            self.states[candidate.triangle as usize] = FREE;
            self.rims.push(candidate.triangle);
        }
    }

    /// Marks a triangle as taken and adds its neighbours to the frontier.
    fn take(&mut self, triangle: u32) {
        self.states[triangle as usize] = TAKEN;
        for neighbour in self.connections.neighbours(triangle) {
            let state = self.states[neighbour as usize];
            if state == TAKEN {
                continue;
            }
            let weight = 0.4 + 0.3 * self.free_neighbours(neighbour) as f32;
            if state == FREE {
                self.states[neighbour as usize] = self.frontier.len() as u32;
                let centre = self.centres[neighbour as usize];
                self.frontier.push(RimTriangle { centre, weight, triangle: neighbour });
            } else {
                self.frontier[state as usize].weight = weight;
            }
        }
    }

    /// Takes the best candidate out of the frontier: near the patch's middle, with few free neighbours.
    fn best(&mut self, middle: Vec3) -> Option<u32> {
        // Positive floats have the order of their bits, so the minimum is found without a branch.
        let costs = self.frontier.iter().zip(0_u64..).map(|(candidate, index)| {
            let cost = candidate.centre.distance_squared(middle) * candidate.weight;
            u64::from(cost.to_bits()) << 32 | index
        });
        let best = costs.min()? as u32 as usize;
        let triangle = self.frontier[best].triangle;
        self.frontier.swap_remove(best);
        self.states[triangle as usize] = FREE;
        if let Some(moved) = self.frontier.get(best) {
            self.states[moved.triangle as usize] = best as u32;
        }
        Some(triangle)
    }

    /// A triangle near a patch that has no connected triangles left.
    fn near(&mut self, triangles: Triangles<'_>, middle: Vec3) -> Option<u32> {
        if !self.patch.has_room() {
            return None;
        }
        let first_free = self.first_free();
        let distance = |triangle: u32| self.centres[triangle as usize].distance(middle);
        let candidates = self.recent_rims().chain(first_free).map(|triangle| (distance(triangle), triangle));
        let (distance, triangle) = candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
        // A patch below sixteen is padded to sixteen anyway, so it may reach further.
        let reach = if self.patch.len() < LANES { 2.0 * self.spacing } else { self.spacing };
        let is_near = distance <= reach || distance <= self.patch.bounds(triangles).size().length();
        is_near.then_some(triangle)
    }

    /// The first triangle along the curve that is in no patch.
    fn first_free(&mut self) -> Option<u32> {
        while self.states.get(self.first_free).is_some_and(|&state| state == TAKEN) {
            self.first_free += 1;
        }
        (self.first_free < self.states.len()).then_some(self.first_free as u32)
    }

    fn recent_rims(&self) -> impl Iterator<Item = u32> {
        self.rims.iter().rev().take(RECENT).copied().filter(|&triangle| !self.is_taken(triangle))
    }

    fn is_taken(&self, triangle: u32) -> bool {
        self.states[triangle as usize] == TAKEN
    }

    fn free_neighbours(&self, triangle: u32) -> usize {
        let is_free = |&neighbour: &u32| neighbour != triangle && !self.is_taken(neighbour);
        self.connections.neighbours(triangle).iter().filter(|neighbour| is_free(neighbour)).count()
    }
}
