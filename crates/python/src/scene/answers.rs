//! Hits as dictionaries of arrays, with Open3D's keys.

use glam::{DVec3, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use umbrage::rays::{Hit, Scanned};
use umbrage::scene::Instances;

use crate::arrays::{hand_over, hand_over_rows};

/// Stands for no geometry and no triangle, as in Open3D.
pub(crate) const INVALID_ID: u32 = Scanned::NONE;

/// The type of t in results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    Single,
    Double,
}

/// A hit, or none, for each ray.
#[derive(Debug, Default)]
pub(super) struct Answers {
    t: Vec<f64>,
    /// Ids among all triangles until they become numbers within their geometry.
    triangle: Vec<u32>,
    geometry: Vec<u32>,
    weights: Vec<[f32; 2]>,
    normal: Vec<[f32; 3]>,
}

impl Answers {
    /// Reserves memory for all hits.
    pub(super) fn with_capacity(count: usize) -> Self {
        let (t, triangle) = (Vec::with_capacity(count), Vec::with_capacity(count));
        Self { t, triangle, weights: Vec::with_capacity(count), ..Self::default() }
    }

    /// Finds and adds a hit for each of `count` rays.
    pub(super) fn find(&mut self, count: usize, hit: impl Fn(usize) -> Option<Hit> + Sync) {
        const CHUNK: usize = 256;
        let first = self.t.len();
        self.t.resize(first + count, 0.0);
        self.triangle.resize(first + count, 0);
        self.weights.resize(first + count, [0.0; 2]);
        let chunks = self.t[first..].par_chunks_mut(CHUNK).zip(self.triangle[first..].par_chunks_mut(CHUNK));
        let chunks = chunks.zip(self.weights[first..].par_chunks_mut(CHUNK)).enumerate();
        chunks.for_each(|(chunk, ((t, triangle), weights))| {
            for (index, ((t, triangle), weights)) in t.iter_mut().zip(triangle).zip(weights).enumerate() {
                let found = hit(chunk * CHUNK + index);
                *t = found.map_or(f64::INFINITY, |hit| hit.t);
                *triangle = found.map_or(INVALID_ID, |hit| hit.triangle);
                *weights = found.map_or([0.0; 2], |hit| hit.barycentric);
            }
        });
    }

    /// Adds the answers of a scan.
    pub(super) fn append(&mut self, scanned: Scanned) {
        let Scanned { mut t, mut triangle, barycentric: mut weights, .. } = scanned;
        let pairs = weights.par_iter_mut().zip(triangle.par_iter());
        pairs.with_min_len(1 << 14).filter(|(_, id)| **id == INVALID_ID).for_each(|(weights, _)| *weights = [0.0; 2]);
        if self.t.is_empty() {
            (self.t, self.triangle, self.weights) = (t, triangle, weights);
        } else {
            self.t.append(&mut t);
            self.triangle.append(&mut triangle);
            self.weights.append(&mut weights);
        }
    }

    /// Adds hits in order.
    pub(super) fn push(&mut self, hits: &[Hit]) {
        self.t.extend(hits.iter().map(|hit| hit.t));
        self.triangle.extend(hits.iter().map(|hit| hit.triangle));
        self.weights.extend(hits.iter().map(|hit| hit.barycentric));
    }

    /// Completes all hits with their geometries, and with normals if requested.
    pub(super) fn complete(&mut self, instances: &Instances, with_normals: bool) {
        const AT_LEAST: usize = 1 << 12;
        let triangles = instances.triangles();
        if with_normals {
            let normal = |id| unit_normal(triangles.corners(id)).as_vec3().to_array();
            let normals = self.triangle.par_iter().with_min_len(AT_LEAST);
            normals.map(|&id| if id == INVALID_ID { [0.0; 3] } else { normal(id) }).collect_into_vec(&mut self.normal);
        }
        let ids = self.triangle.par_iter_mut().with_min_len(AT_LEAST);
        ids.map(|id| {
            let [geometry, number] = if *id == INVALID_ID { [INVALID_ID; 2] } else { instances.of_triangle(*id) };
            *id = number;
            geometry
        })
        .collect_into_vec(&mut self.geometry);
    }

    /// The dictionary of arrays, each of this shape.
    pub(super) fn into_dict<'py>(
        self,
        py: Python<'py>,
        shape: &[usize],
        precision: Precision,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Self { t, triangle, geometry, weights, normal } = self;
        let dict = PyDict::new(py);
        let t_hit = match precision {
            Precision::Double => hand_over(py, t, shape)?,
            Precision::Single => hand_over(py, t.iter().map(|&t| t as f32).collect::<Vec<f32>>(), shape)?,
        };
        dict.set_item("t_hit", t_hit)?;
        dict.set_item("geometry_ids", hand_over(py, geometry, shape)?)?;
        dict.set_item("primitive_ids", hand_over(py, triangle, shape)?)?;
        dict.set_item("primitive_uvs", hand_over_rows(py, weights, shape)?)?;
        let count: usize = shape.iter().product();
        if normal.len() == count {
            dict.set_item("primitive_normals", hand_over_rows(py, normal, shape)?)?;
        }
        Ok(dict)
    }
}

/// Unit normal, on the side from which the corners are counterclockwise.
pub(super) fn unit_normal(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    // Not too small to be squared.
    (normal / normal.abs().max_element()).normalize_or_zero()
}
