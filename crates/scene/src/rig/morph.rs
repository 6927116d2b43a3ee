//! Morph targets: weighted differences of a shape's vertices.

use glam::Vec3;

/// The differences that a morph target adds at weight one.
#[derive(Debug, Default)]
pub struct MorphTarget {
    /// To positions.
    pub positions: Deltas,
    /// To normals.
    pub normals: Deltas,
    /// To tangents' directions.
    pub tangents: Deltas,
}

/// Differences, for all vertices or for some.
#[derive(Debug)]
pub enum Deltas {
    /// One for each vertex.
    Dense(Vec<Vec3>),
    /// Differences of some vertices; zero for the others.
    Sparse {
        /// The affected vertices, ascending.
        vertices: Vec<u32>,
        /// One for each of `vertices`.
        deltas: Vec<Vec3>,
    },
}

impl Default for Deltas {
    fn default() -> Self {
        Self::Sparse { vertices: Vec::new(), deltas: Vec::new() }
    }
}

impl Deltas {
    /// Calls `add` with each element of `values`, which belong to the vertices from `first` on, and `weight` times that
    /// vertex's difference.
    pub(super) fn add<T>(&self, weight: f32, first: usize, values: &mut [T], add: impl Fn(&mut T, Vec3)) {
        match self {
            Self::Dense(deltas) => {
                for (value, &delta) in values.iter_mut().zip(&deltas[first..]) {
                    add(value, delta * weight);
                }
            }
            Self::Sparse { vertices, deltas } => {
                let end = first + values.len();
                let before = vertices.partition_point(|&vertex| (vertex as usize) < first);
                for (&vertex, &delta) in vertices[before..].iter().zip(&deltas[before..]) {
                    if vertex as usize >= end {
                        break;
                    }
                    add(&mut values[vertex as usize - first], delta * weight);
                }
            }
        }
    }
}
