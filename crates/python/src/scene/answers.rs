//! Hits as dictionaries of arrays, with Open3D's keys.

use glam::{DVec3, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use umbrage::rays::{ClosestPoints, Hit, Ray, Scanned, SimdLevel, Triangles, predicate};
use umbrage::scene::Instances;

use super::keys::Keys;
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
    /// The triangles that some pixels show, given by their ids, without anything else about them.
    pub(super) fn of_ids(count: usize, id: impl Fn(usize) -> u32 + Sync + Send) -> Self {
        let triangle = (0..count).into_par_iter().with_min_len(1 << 12).map(id).collect();
        Self { triangle, ..Self::default() }
    }

    /// The hits of rays on the triangles that they hit first, given by their ids.
    pub(super) fn of_rays(
        triangles: Triangles<'_>,
        count: usize,
        id: impl Fn(usize) -> u32 + Sync,
        ray: impl Fn(usize) -> Ray + Sync,
    ) -> Self {
        const CHUNK: usize = 256;
        let (mut t, mut triangle) = (vec![f64::INFINITY; count], vec![INVALID_ID; count]);
        let mut weights = vec![[0.0; 2]; count];
        let chunks = t.par_chunks_mut(CHUNK).zip(triangle.par_chunks_mut(CHUNK)).zip(weights.par_chunks_mut(CHUNK));
        chunks.enumerate().for_each(|(chunk, ((t, triangle), weights))| {
            let first = chunk * CHUNK;
            let (mut rays, mut pairs) = ([Ray::new(DVec3::ZERO, DVec3::ZERO); CHUNK], [(0, 0); CHUNK]);
            let mut hits = 0;
            for index in (0..t.len()).filter(|index| id(first + index) != INVALID_ID) {
                rays[index] = ray(first + index);
                pairs[hits] = (index as u32, id(first + index));
                hits += 1;
            }
            let mut found = [None; CHUNK];
            predicate::hits(SimdLevel::default(), triangles, &rays, &pairs[..hits], &mut found[..hits]);
            for (&(index, _), hit) in pairs[..hits].iter().zip(&found) {
                if let Some(Hit { t: of_hit, triangle: id, barycentric }) = *hit {
                    let index = index as usize;
                    (t[index], triangle[index], weights[index]) = (of_hit, id, barycentric);
                }
            }
        });
        Self { t, triangle, weights, ..Self::default() }
    }

    /// Adds the answers of a scan: those of its parts that are wanted.
    pub(super) fn append(&mut self, scanned: Scanned) {
        let Scanned { mut t, mut triangle, barycentric: mut weights, .. } = scanned;
        let pairs = weights.par_iter_mut().zip(triangle.par_iter());
        pairs.with_min_len(1 << 14).filter(|(_, id)| **id == INVALID_ID).for_each(|(weights, _)| *weights = [0.0; 2]);
        if self.triangle.is_empty() {
            (self.t, self.triangle, self.weights) = (t, triangle, weights);
        } else {
            self.t.append(&mut t);
            self.triangle.append(&mut triangle);
            self.weights.append(&mut weights);
        }
    }

    /// Adds nearest points, as hits without t.
    pub(super) fn append_closest(&mut self, closest: ClosestPoints) {
        let ClosestPoints { mut triangle, barycentric: mut weights, .. } = closest;
        weights.iter_mut().filter(|of| of[0].is_nan()).for_each(|of| *of = [0.0; 2]);
        self.triangle.append(&mut triangle);
        self.weights.append(&mut weights);
    }

    /// Adds hits in order.
    pub(super) fn push(&mut self, hits: &[Hit]) {
        self.t.extend(hits.iter().map(|hit| hit.t));
        self.triangle.extend(hits.iter().map(|hit| hit.triangle));
        self.weights.extend(hits.iter().map(|hit| hit.barycentric));
    }

    /// Completes all hits with their geometries and normals, where these are asked for. `corners` are those of a hit's
    /// triangle, given the hit's index and the triangle's id among all; `of_triangle` gives the geometry and the number there.
    pub(super) fn complete(
        &mut self,
        keys: Keys,
        corners: impl Fn(usize, u32) -> [Vec3; 3] + Sync,
        of_triangle: impl Fn(u32) -> [u32; 2] + Sync,
    ) {
        const AT_LEAST: usize = 1 << 12;
        if keys.normals() {
            let normal = |index, id| unit_normal(corners(index, id)).as_vec3().to_array();
            let normals = self.triangle.par_iter().enumerate().with_min_len(AT_LEAST);
            normals
                .map(|(index, &id)| if id == INVALID_ID { [0.0; 3] } else { normal(index, id) })
                .collect_into_vec(&mut self.normal);
        }
        if !keys.geometry() && !keys.primitive() {
            return;
        }
        let ids = self.triangle.par_iter_mut().with_min_len(AT_LEAST);
        let number = |id: &mut u32| {
            let [geometry, number] = if *id == INVALID_ID { [INVALID_ID; 2] } else { of_triangle(*id) };
            *id = number;
            geometry
        };
        if keys.geometry() {
            ids.map(number).collect_into_vec(&mut self.geometry);
        } else {
            ids.for_each(|id| _ = number(id));
        }
    }

    /// As [`complete`](Self::complete), for the geometries of a scene.
    pub(super) fn complete_among(&mut self, instances: &Instances, keys: Keys) {
        let triangles = instances.triangles();
        self.complete(keys, |_, id| triangles.corners(id), |id| instances.of_triangle(id));
    }

    /// The dictionary of arrays, each of this shape.
    pub(super) fn into_dict<'py>(
        self,
        py: Python<'py>,
        shape: &[usize],
        precision: Precision,
        keys: Keys,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Self { t, triangle, geometry, weights, normal } = self;
        let dict = PyDict::new(py);
        if keys.t() {
            let t_hit = match precision {
                Precision::Double => hand_over(py, t, shape)?,
                Precision::Single => hand_over(py, t.iter().map(|&t| t as f32).collect::<Vec<f32>>(), shape)?,
            };
            dict.set_item("t_hit", t_hit)?;
        }
        if keys.geometry() {
            dict.set_item("geometry_ids", hand_over(py, geometry, shape)?)?;
        }
        if keys.primitive() {
            dict.set_item("primitive_ids", hand_over(py, triangle, shape)?)?;
        }
        if keys.weights() {
            dict.set_item("primitive_uvs", hand_over_rows(py, weights, shape)?)?;
        }
        if keys.normals() {
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
