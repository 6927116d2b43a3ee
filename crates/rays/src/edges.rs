use crate::Triangles;

impl Triangles<'_> {
    /// The edges that aren't shared by exactly two triangles, each by its two vertices, in ascending order. A mesh without any
    /// is watertight: it has an [inside](crate::Nearest::inside).
    ///
    /// Vertices at the same position are the same vertex, named by the lowest index, so seams of normals or textures aren't
    /// open. Triangles that no ray can hit are left out.
    #[must_use]
    pub fn open_edges(&self) -> Vec<[u32; 2]> {
        let same = self.first_of_same();
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * self.len());
        for id in (0..self.len() as u32).filter(|&id| self.usable_corners(id).is_ok()) {
            let [a, b, c] = self.indices[id as usize].map(|vertex| same[vertex as usize]);
            edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]));
        }
        edges.sort_unstable();
        edges.chunk_by(|one, other| one == other).filter(|same| same.len() != 2).map(|same| same[0]).collect()
    }

    /// Whether there are no [open edges](Self::open_edges).
    #[must_use]
    pub fn is_watertight(&self) -> bool {
        self.open_edges().is_empty()
    }

    /// For each vertex the first one at its position.
    fn first_of_same(&self) -> Vec<u32> {
        // Minus zero plus zero is zero.
        let bits = |vertex: u32| (self.positions[vertex as usize] + 0.0).to_array().map(f32::to_bits);
        let mut sorted: Vec<([u32; 3], u32)> =
            (0..self.positions.len() as u32).map(|vertex| (bits(vertex), vertex)).collect();
        sorted.sort_unstable();
        let mut first = vec![0; sorted.len()];
        for same in sorted.chunk_by(|(one, _), (other, _)| one == other) {
            for &(_, vertex) in same {
                first[vertex as usize] = same[0].1;
            }
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A cube in which each side has corners of its own.
    fn cube() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for [x, y, z] in [[Vec3::X, Vec3::Y, Vec3::Z], [Vec3::Y, Vec3::Z, Vec3::X], [Vec3::Z, Vec3::X, Vec3::Y]] {
            // Zeros with either sign.
            for start in [Vec3::ZERO * -1.0, z] {
                let first = positions.len() as u32;
                positions.extend([start, start + x, start + x + y, start + y]);
                indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        (positions, indices)
    }

    #[test]
    fn edges_are_open_unless_two_triangles_share_them() {
        let (mut positions, mut indices) = cube();
        let open = |positions: &[Vec3], indices: &[[u32; 3]]| {
            let triangles = Triangles { positions, indices };
            assert_eq!(triangles.is_watertight(), triangles.open_edges().is_empty());
            triangles.open_edges()
        };
        assert!(open(&[], &[]).is_empty());
        assert!(open(&positions, &indices).is_empty());
        // Without area, without finite corners and without a vertex.
        positions.push(Vec3::NAN);
        indices.extend([[3, 3, 2], [0, 1, 24], [0, 1, 99]]);
        assert!(open(&positions, &indices).is_empty());
        indices.push([0, 1, 2]);
        assert_eq!(open(&positions, &indices), [[0, 1], [0, 2], [1, 2]], "three triangles");
        indices.truncate(11);
        let edges = open(&positions, &indices);
        assert_eq!(edges.len(), 3);
        for [from, to] in edges {
            let ends = [positions[from as usize], positions[to as usize]];
            assert!(
                ends.iter().all(|end| [20, 22, 23].map(|corner: usize| positions[corner]).contains(end)),
                "{ends:?}"
            );
        }
    }
}
