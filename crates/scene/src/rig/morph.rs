//! Morph targets: what a weight adds to a shape's vertices.

use glam::Vec3;

/// What one morph target adds at weight one.
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
    /// Nothing for most vertices.
    Sparse {
        /// The others, rising.
        vertices: Vec<u32>,
        /// One for each of these.
        deltas: Vec<Vec3>,
    },
}

impl Default for Deltas {
    fn default() -> Self {
        Self::Sparse { vertices: Vec::new(), deltas: Vec::new() }
    }
}

impl Deltas {
    /// Adds `weight` times the differences of the vertices from `first` on, one for each element of `values`.
    pub(super) fn add(&self, weight: f32, first: usize, values: &mut [impl AddDelta]) {
        match self {
            Self::Dense(deltas) => {
                for (value, &delta) in values.iter_mut().zip(&deltas[first..]) {
                    value.add_delta(delta * weight);
                }
            }
            Self::Sparse { vertices, deltas } => {
                let end = first + values.len();
                let before = vertices.partition_point(|&vertex| (vertex as usize) < first);
                for (&vertex, &delta) in vertices[before..].iter().zip(&deltas[before..]) {
                    if vertex as usize >= end {
                        break;
                    }
                    values[vertex as usize - first].add_delta(delta * weight);
                }
            }
        }
    }
}

/// What differences can be added to.
pub(super) trait AddDelta {
    fn add_delta(&mut self, delta: Vec3);
}

impl AddDelta for Vec3 {
    fn add_delta(&mut self, delta: Vec3) {
        *self += delta;
    }
}

impl AddDelta for glam::Vec4 {
    /// Leaves w, a tangent's sign, as it is.
    fn add_delta(&mut self, delta: Vec3) {
        *self += delta.extend(0.0);
    }
}
