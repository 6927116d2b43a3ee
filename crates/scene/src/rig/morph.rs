//! Morph targets: what a weight adds to a primitive's vertices.

use glam::Vec3;
use gltf::json::Index;
use gltf::json::mesh;

use super::document::Document;
use crate::Error;

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

impl MorphTarget {
    /// Reads a target of a primitive with `count` vertices, of which those at the rising places `kept` are kept.
    ///
    /// # Errors
    /// Where an accessor is broken or has another number of elements.
    pub(super) fn read(
        document: &Document,
        json: &mesh::MorphTarget,
        count: usize,
        kept: Option<&[u32]>,
        place: &str,
    ) -> Result<Self, Error> {
        let deltas = |accessor: Option<Index<_>>, name: &str| {
            let Some(accessor) = accessor else { return Ok(Deltas::default()) };
            let place = format!("{place}.{name}");
            let accessor = document.accessor(accessor, &place)?;
            accessor.expect_count(count, &place)?;
            if accessor.is_mostly_zero() {
                let (vertices, deltas) = accessor.sparse_floats(Vec3::from_array)?;
                return Ok(Deltas::sparse(vertices, deltas, kept));
            }
            Ok(Deltas::Dense(accessor.floats(kept, Vec3::from_array)?))
        };
        Ok(Self {
            positions: deltas(json.positions, "POSITION")?,
            normals: deltas(json.normals, "NORMAL")?,
            tangents: deltas(json.tangents, "TANGENT")?,
        })
    }
}

impl Deltas {
    fn sparse(vertices: Vec<u32>, deltas: Vec<Vec3>, kept: Option<&[u32]>) -> Self {
        let Some(kept) = kept else { return Self::Sparse { vertices, deltas } };
        let renumber = |(vertex, delta)| Some((kept.binary_search(&vertex).ok()? as u32, delta));
        let (vertices, deltas) = vertices.into_iter().zip(deltas).filter_map(renumber).unzip();
        Self::Sparse { vertices, deltas }
    }

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
