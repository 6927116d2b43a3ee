//! Any rays, and all hits of rays through the hierarchy.

use std::cell::RefCell;

use glam::DVec3;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;
use umbrage::rays::{Bvh, Hit, Masks, Ray, Rays, SingleRays, Triangles};

use super::answers::Precision;
use crate::arrays::Rows;

/// An argument of rays: six numbers each, an origin and a direction.
pub(super) enum RayArray<'py> {
    Single(Rows<'py, f32, 6>),
    Double(Rows<'py, f64, 6>),
    /// From a scene's origin, of this shape and precision.
    Moved(Vec<[f64; 6]>, Vec<usize>, Precision),
}

impl<'py> RayArray<'py> {
    /// Takes float64 as it is, and all else as float32, in a scene with this origin.
    pub(super) fn new(value: &Bound<'py, PyAny>, origin: DVec3) -> PyResult<Self> {
        let is_double = value.cast::<PyArrayDyn<f64>>().is_ok();
        if origin != DVec3::ZERO {
            let precision = if is_double { Precision::Double } else { Precision::Single };
            let rows = Rows::<f64, 6>::new("rays", value)?;
            let moved = rows.of::<[f64; 6]>().iter().map(|&[x, y, z, dx, dy, dz]| {
                let [x, y, z] = (DVec3::new(x, y, z) - origin).to_array();
                [x, y, z, dx, dy, dz]
            });
            return Ok(Self::Moved(moved.collect(), rows.shape().to_vec(), precision));
        }
        if is_double { Rows::new("rays", value).map(Self::Double) } else { Rows::new("rays", value).map(Self::Single) }
    }

    pub(super) fn shape(&self) -> &[usize] {
        match self {
            Self::Single(rows) => rows.shape(),
            Self::Double(rows) => rows.shape(),
            Self::Moved(_, shape, _) => shape,
        }
    }

    /// The rays, in numpy's own memory.
    pub(super) fn rays(&self) -> Rays<'_> {
        match self {
            Self::Single(rows) => Rays::Single(rows.of()),
            Self::Double(rows) => Rays::Double(rows.of()),
            Self::Moved(rays, ..) => Rays::Double(rays),
        }
    }

    pub(super) fn precision(&self) -> Precision {
        match self {
            Self::Single(_) => Precision::Single,
            Self::Double(_) => Precision::Double,
            Self::Moved(.., precision) => *precision,
        }
    }
}

/// The hierarchy of some triangles, and their masks and those of rays.
#[derive(Clone, Copy)]
pub(super) struct Masked<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) triangles: Triangles<'a>,
    pub(super) masks: Masks<'a>,
}

/// All hits of a ray with a mask, nearest first; of those at the same t the lowest id first.
fn all(Masked { bvh, triangles, masks }: Masked<'_>, ray: &Ray, mask: u32, hits: &mut Vec<Hit>) {
    hits.clear();
    let noted = RefCell::new(std::mem::take(hits));
    // No hit stops the ray, so it meets all triangles on its line; some of them twice.
    let _ = bvh.nearest(triangles, ray, &|hit| {
        if masks.sees(mask, hit.triangle) {
            noted.borrow_mut().push(*hit);
        }
        false
    });
    *hits = noted.into_inner();
    hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    hits.dedup_by_key(|hit| hit.triangle);
}

/// All hits of each ray in order, and the number of each ray's hits.
pub(super) fn list(among: Masked<'_>, rays: Rays<'_>) -> Vec<(Vec<u32>, Vec<Hit>)> {
    const CHUNK: usize = 1 << 10;
    let chunks = (0..rays.len().div_ceil(CHUNK)).into_par_iter();
    chunks
        .map(|chunk| {
            let (mut counts, mut listed, mut hits) = (Vec::new(), Vec::new(), Vec::new());
            for index in chunk * CHUNK..rays.len().min((chunk + 1) * CHUNK) {
                all(among, &rays.get(index), among.masks.of_ray(index), &mut hits);
                counts.push(hits.len() as u32);
                listed.extend_from_slice(&hits);
            }
            (counts, listed)
        })
        .collect()
}
