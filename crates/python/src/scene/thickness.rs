//! How thick meshes are behind points of their surface.

use glam::{DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use umbrage::rays::{Bvh, Hit, Ray, SingleRays as _, Triangles};

use super::RaycastingScene;
use super::answers::{INVALID_ID, unit_normal};
use super::arguments::Own;
use super::state::State;
use crate::arrays::{Rows, hand_over};
use crate::threads::Call;

/// Points of a piece.
const POINTS: usize = 1 << 20;

/// 16 u, with u = 2⁻⁵³: more than the position of a hit or of a nearest point is wrong, of the largest coordinate of it and of its
/// triangle.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

impl RaycastingScene {
    /// As `compute_thickness`, with the ids of points' geometries and triangles.
    pub(super) fn ask_for_thickness<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        [geometries, triangles]: [&Bound<'py, PyAny>; 2],
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = Rows::<f64, 3>::new("points", points)?;
        let own = Own::of(rows.shape(), geometries, triangles)?;
        let (positions, own) = (rows.of::<DVec3>(), own.slices());
        let thickness = self.ask(py, nthreads, |call, state| thickness(call, state, positions, self.origin, own))?;
        hand_over(py, thickness, rows.shape())
    }
}

fn thickness(
    call: &Call,
    state: &mut State,
    points: &[DVec3],
    origin: DVec3,
    [geometries, triangles]: [&[u32]; 2],
) -> PyResult<Vec<f64>> {
    let own = state.ids(geometries, triangles).map_err(PyValueError::new_err)?;
    let (bvh, triangles, _) = call.piece(|| state.rays())?;
    let mut thickness = Vec::with_capacity(points.len());
    for (points, own) in points.chunks(POINTS).zip(own.chunks(POINTS)) {
        let behind = |(&point, &own): (&DVec3, &u32)| behind(bvh, triangles, point, origin, own);
        call.piece(|| thickness.par_extend(points.par_iter().zip(own).with_min_len(64).map(behind)))?;
    }
    Ok(thickness)
}

/// The distance from a point of a triangle, against its normal, to the next triangle; infinite if there is none.
fn behind(bvh: &Bvh, triangles: Triangles<'_>, point: DVec3, origin: DVec3, own: u32) -> f64 {
    if own == INVALID_ID {
        return f64::INFINITY;
    }
    let corners = triangles.corners(own);
    // The point is in the world, its triangle beside the scene's origin.
    let largest = corners.iter().fold(point.abs().max(origin.abs()), |most, at| most.max(at.as_dvec3().abs()));
    let (point, error) = (point - origin, ROUNDINGS * largest.max_element());
    let ray = Ray::new(point, -unit_normal(corners));
    let is_behind = |hit: &Hit| !may_touch(point, error, triangles.corners(hit.triangle));
    bvh.nearest_from(triangles, &ray, own, &is_behind).map_or(f64::INFINITY, |hit| hit.t)
}

/// Whether a point may be in a triangle's plane, since its coordinates may be wrong by `error`. The height above the plane is
/// wrong by less than 16 u of the sum of its terms' magnitudes.
fn may_touch(point: DVec3, error: f64, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (ab, ac, from) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let (along, across) = (ab.abs(), ac.abs());
    let terms = DVec3::new(
        along.y * across.z + along.z * across.y,
        along.z * across.x + along.x * across.z,
        along.x * across.y + along.y * across.x,
    );
    normal.dot(from).abs() <= error * normal.abs().element_sum() + ROUNDINGS * terms.dot(from.abs())
}
