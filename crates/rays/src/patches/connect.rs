use crate::{HashKey, Triangles};

/// Connections between triangles that share edges. Edges are equal if their positions are, not their vertices, so that seams
/// connect.
///
/// The sides of triangles on the same edge form a ring of any length: so any mesh takes linear time.
#[derive(Debug, Default)]
pub(super) struct Connections {
    /// For each side (three a triangle) the next side of its ring; itself if it is alone.
    next: Vec<u32>,
    points: Numbers,
    edges: Numbers,
    /// A side of each edge.
    sides: Vec<u32>,
}

impl Connections {
    /// Connects some triangles of a frame, whose corners must exist. From here on, triangles are indices of `ids`.
    pub(super) fn connect(&mut self, triangles: Triangles<'_>, ids: &[u32]) {
        self.next.clear();
        self.sides.clear();
        self.points.clear();
        self.edges.clear();
        for &id in ids {
            let [a, b, c] = triangles.indices[id as usize].map(|vertex| {
                let position = triangles.positions[vertex as usize];
                // Turns −0 into 0.
                let [x, y, z] = [position.x, position.y, position.z].map(|coordinate| (coordinate + 0.0).to_bits());
                self.points.of((pair(x, y), z))
            });
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let edge = self.edges.of((pair(from.min(to), from.max(to)), 0));
                self.add_side(edge);
            }
        }
    }

    /// The neighbours across each side of a triangle; the triangle itself where there is none.
    #[inline]
    pub(super) fn neighbours(&self, triangle: u32) -> [u32; 3] {
        let first = 3 * triangle as usize;
        [self.next[first] / 3, self.next[first + 1] / 3, self.next[first + 2] / 3]
    }

    /// Adds the next side to the ring of its edge.
    fn add_side(&mut self, edge: u32) {
        let side = self.next.len() as u32;
        self.next.push(side);
        match self.sides.get(edge as usize) {
            Some(&known) => self.next.swap(known as usize, side as usize),
            None => self.sides.push(side),
        }
    }
}

/// Numbers keys in the order of their arrival; equal keys have the same number.
#[derive(Debug, Default)]
struct Numbers {
    keys: Vec<(u64, u32)>,
    /// Numbers by the hashes of their keys, or [`Numbers::FREE`].
    slots: Vec<u32>,
    hash_key: HashKey,
}

impl Numbers {
    const FREE: u32 = u32::MAX;

    fn clear(&mut self) {
        self.keys.clear();
        self.slots.fill(Self::FREE);
    }

    #[inline(always)]
    fn of(&mut self, key: (u64, u32)) -> u32 {
        if self.slots.len() <= 2 * self.keys.len() {
            self.widen();
        }
        let slot = self.find(key);
        if self.slots[slot] == Self::FREE {
            self.slots[slot] = self.keys.len() as u32;
            self.keys.push(key);
        }
        self.slots[slot]
    }

    /// The slot of a key, or a free slot for it.
    #[inline(always)]
    fn find(&self, key: (u64, u32)) -> usize {
        let mut slot = self.hash_key.mix(self.hash_key.mix(self.hash_key.start(), key.0), key.1.into()) as usize;
        loop {
            slot &= self.slots.len() - 1;
            let number = self.slots[slot];
            if number == Self::FREE || self.keys[number as usize] == key {
                return slot;
            }
            slot += 1;
        }
    }

    /// Doubles the slots, and no more, since they have to stay in cache.
    #[cold]
    fn widen(&mut self) {
        let count = (2 * self.slots.len()).max(1 << 10);
        self.slots.clear();
        self.slots.resize(count, Self::FREE);
        for number in 0..self.keys.len() {
            let slot = self.find(self.keys[number]);
            self.slots[slot] = number as u32;
        }
    }
}

fn pair(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn connected(positions: &[Vec3], indices: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut connections = Connections::default();
        let ids: Vec<_> = (0..indices.len() as u32).collect();
        // No connection of the first round may remain in the second.
        for _ in 0..2 {
            connections.connect(Triangles { positions, indices }, &ids);
        }
        ids.iter().map(|&id| connections.neighbours(id)).collect()
    }

    #[test]
    fn edges_connect_whatever_their_vertices_are_called() {
        let minus_zero = Vec3::new(1.0, -0.0, -0.0);
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Y, minus_zero, Vec3::ONE, Vec3::NAN, Vec3::NAN, Vec3::Z];
        assert_eq!(connected(&positions, &[[0, 1, 2], [3, 4, 5]]), [[0, 1, 0], [0, 1, 1]]);
        assert_eq!(connected(&positions, &[[0, 1, 6], [7, 1, 5]]), [[0, 1, 0], [0, 1, 1]]);
        assert_eq!(connected(&positions, &[[0, 1, 2], [2, 5, 5]]), [[0; 3], [1; 3]]);
        assert_eq!(connected(&positions, &[[0, 1, 2], [8, 1, 5]]), [[0; 3], [1; 3]]);
    }

    #[test]
    fn any_number_of_triangles_on_an_edge_is_a_ring() {
        let positions: Vec<_> = (0..3000).map(|index| Vec3::splat(index as f32)).collect();
        let pages: Vec<_> = (2..3000).map(|page| if page % 2 == 0 { [0, 1, page] } else { [1, 0, page] }).collect();
        let neighbours = connected(&positions, &pages);
        let (mut page, mut seen) = (0, vec![false; pages.len()]);
        while !std::mem::replace(&mut seen[page as usize], true) {
            page = neighbours[page as usize][0];
        }
        assert!(page == 0 && seen.iter().all(|&seen| seen));
    }
}
