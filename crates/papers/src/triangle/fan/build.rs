use std::collections::BinaryHeap;

use super::{Fan, Fans};
use umbrage_rays::Triangles;

impl Fans {
    /// Makes fans of a mesh's triangles, without triangles that no ray can hit.
    ///
    /// Greedy, by the fitness of Galin and Akkouche 2005, §4 (Rahikainen 2013, equation 2.19): the next centre is the vertex
    /// for which 2 × its triangles + 7 × open edges among them − 11 × triangles that would be left without neighbours is
    /// largest. The paper searches along the border of the remaining mesh; here the vertex may be anywhere.
    ///
    /// Only triangles that share vertices are joined, and only those with the same orientation.
    #[must_use]
    pub fn new(triangles: Triangles<'_>) -> Self {
        let mut fans = Self { omitted: triangles.omitted(), ..Self::default() };
        let mut mesh = Mesh::new(triangles);
        let mut candidates: BinaryHeap<(i64, u32)> =
            (0..mesh.vertices()).filter_map(|vertex| Some((mesh.fitness(vertex)?, vertex))).collect();
        let (mut spokes, mut chain, mut touched) = (Vec::new(), Vec::new(), Vec::new());
        while let Some((fitness, center)) = candidates.pop() {
            match mesh.fitness(center) {
                None => continue,
                // An earlier fitness may be too high.
                Some(now) if now < fitness => {
                    candidates.push((now, center));
                    continue;
                }
                Some(_) => {}
            }
            mesh.spokes(center, &mut spokes);
            touched.clear();
            let removed = fans.ids.len();
            // Lone triangles may still join a fan around another corner, unless there is no longer chain here.
            if !fans.push_chains(triangles, center, &mut spokes, &mut chain, 2) {
                fans.push_chains(triangles, center, &mut spokes, &mut chain, 1);
            }
            for &id in &fans.ids[removed..] {
                mesh.is_left[id as usize] = false;
            }
            for &id in &fans.ids[removed..] {
                touched.extend(mesh.indices[id as usize]);
                for neighbor in mesh.neighbors_left(id) {
                    touched.extend(mesh.indices[neighbor as usize]);
                }
            }
            touched.sort_unstable();
            touched.dedup();
            candidates.extend(touched.iter().filter_map(|&vertex| Some((mesh.fitness(vertex)?, vertex))));
        }
        fans
    }

    /// Makes a fan of each chain of at least `shortest` of the `spokes` around a centre. Returns whether there was any.
    fn push_chains(
        &mut self,
        triangles: Triangles<'_>,
        center: u32,
        spokes: &mut [Spoke],
        chain: &mut Vec<usize>,
        shortest: usize,
    ) -> bool {
        let fans = self.fans.len();
        let mut ends: Vec<u32> = spokes.iter().map(|spoke| spoke.to).collect();
        ends.sort_unstable();
        // Open chains from their beginnings first; the remaining ones are rings.
        for only_beginnings in [true, false] {
            for start in 0..spokes.len() {
                let is_inner = only_beginnings && ends.binary_search(&spokes[start].from).is_ok();
                if spokes[start].is_used || is_inner {
                    continue;
                }
                chain.clear();
                let mut next = Some(start);
                while let Some(index) = next {
                    spokes[index].is_used = true;
                    chain.push(index);
                    next = unused_from(spokes, spokes[index].to);
                }
                if chain.len() >= shortest {
                    self.push(triangles, center, spokes, chain);
                } else {
                    // Returned to the mesh, for another centre.
                    chain.iter().for_each(|&index| spokes[index].is_used = false);
                }
            }
        }
        self.fans.len() > fans
    }

    fn push(&mut self, triangles: Triangles<'_>, center: u32, spokes: &[Spoke], chain: &[usize]) {
        let position = |vertex: u32| triangles.positions[vertex as usize];
        let center_position = position(center);
        self.fans.push(Fan {
            center: center_position,
            first_triangle: self.ids.len() as u32,
            first_edge: self.edges.len() as u32,
            triangles: chain.len() as u32,
        });
        self.edges.extend(chain.iter().take(1).map(|&index| position(spokes[index].from) - center_position));
        for spoke in chain.iter().map(|&index| &spokes[index]) {
            self.edges.push(position(spoke.to) - center_position);
            self.ids.push(spoke.id);
            self.center_corners.push(spoke.center_corner);
        }
    }
}

/// A triangle as seen from one of its corners, with the two others in its own order.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    from: u32,
    to: u32,
    id: u32,
    center_corner: u8,
    is_used: bool,
}

/// The first unused spoke that begins at a vertex; `spokes` are sorted by that vertex.
fn unused_from(spokes: &[Spoke], vertex: u32) -> Option<usize> {
    let first = spokes.partition_point(|spoke| spoke.from < vertex);
    let same = spokes[first..].iter().take_while(|spoke| spoke.from == vertex);
    same.enumerate().find(|(_, spoke)| !spoke.is_used).map(|(index, _)| first + index)
}

/// The rest of a mesh, with neighbours.
struct Mesh<'a> {
    indices: &'a [[u32; 3]],
    /// Whether each triangle can be hit and is in no fan yet.
    is_left: Vec<bool>,
    /// The neighbour across the edge from each corner to the next; [`Mesh::NONE`] for none.
    neighbors: Vec<[u32; 3]>,
    /// Start of each vertex's triangles in `around`, and the end.
    starts: Vec<u32>,
    around: Vec<u32>,
}

impl<'a> Mesh<'a> {
    const NONE: u32 = u32::MAX;

    fn new(triangles: Triangles<'a>) -> Self {
        let indices = triangles.indices;
        let mut is_left = vec![true; indices.len()];
        let mut starts = vec![0_u32; triangles.positions.len() + 1];
        let mut edges = Vec::new();
        for (id, corners) in indices.iter().enumerate() {
            if triangles.usable_corners(id as u32).is_err() {
                is_left[id] = false;
                continue;
            }
            for corner in 0..3 {
                let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
                starts[from as usize + 1] += 1;
                edges.push((from.min(to), from.max(to), id as u32, corner));
            }
        }
        let mut neighbors = vec![[Self::NONE; 3]; indices.len()];
        edges.sort_unstable();
        for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            // Where more than two triangles meet, they are neighbours two by two.
            for pair in same.chunks_exact(2) {
                let [(.., first, first_corner), (.., second, second_corner)] = [pair[0], pair[1]];
                neighbors[first as usize][first_corner] = second;
                neighbors[second as usize][second_corner] = first;
            }
        }
        for vertex in 1..starts.len() {
            starts[vertex] += starts[vertex - 1];
        }
        let mut ends = starts.clone();
        let mut around = vec![0; edges.len()];
        for (id, corners) in indices.iter().enumerate().filter(|&(id, _)| is_left[id]) {
            for &corner in corners {
                around[ends[corner as usize] as usize] = id as u32;
                ends[corner as usize] += 1;
            }
        }
        Self { indices, is_left, neighbors, starts, around }
    }

    fn vertices(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Triangles around a vertex that are in no fan yet.
    fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let range = self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize;
        self.around[range].iter().copied().filter(|&id| self.is_left[id as usize])
    }

    fn neighbors_left(&self, id: u32) -> impl Iterator<Item = u32> {
        let neighbors = self.neighbors[id as usize].into_iter();
        neighbors.filter(|&neighbor| neighbor != Self::NONE && self.is_left[neighbor as usize])
    }

    /// Fitness of a vertex as a centre; `None` if no triangles are left around it.
    fn fitness(&self, vertex: u32) -> Option<i64> {
        let (mut triangles, mut open_edges, mut left_alone) = (0, 0, 0);
        for id in self.around(vertex) {
            triangles += 1;
            open_edges += 3 - self.neighbors_left(id).count() as i64;
            let is_apart = |id: &u32| !self.indices[*id as usize].contains(&vertex);
            let mut outer = self.neighbors_left(id).filter(is_apart);
            left_alone += i64::from(outer.any(|outer| !self.neighbors_left(outer).any(|id| is_apart(&id))));
        }
        (triangles > 0).then_some(2 * triangles + 7 * open_edges - 11 * left_alone)
    }

    /// The triangles left around a vertex, sorted by the corner that follows it.
    fn spokes(&self, center: u32, spokes: &mut Vec<Spoke>) {
        spokes.clear();
        spokes.extend(self.around(center).filter_map(|id| {
            let corners = self.indices[id as usize];
            let corner = corners.iter().position(|&vertex| vertex == center)?;
            let (from, to) = (corners[(corner + 1) % 3], corners[(corner + 2) % 3]);
            Some(Spoke { from, to, id, center_corner: corner as u8, is_used: false })
        }));
        spokes.sort_unstable_by_key(|spoke| (spoke.from, spoke.to, spoke.id));
    }
}
