//! Nearest points of the meshes, as arrays with Open3D's names.

use glam::Vec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use umbrage::rays::{Closest, ClosestPoints};

use super::answers::{Answers, Precision};
use super::arguments::Points;
use super::keys::Keys;
use super::state::State;
use crate::arrays::{hand_over, hand_over_rows};
use crate::threads::Call;

/// Points of a piece.
const POINTS: usize = 1 << 20;

/// What `compute_closest_points` hands over.
#[derive(Default)]
pub(super) struct Found {
    /// In world coordinates.
    points: Vec<[f64; 3]>,
    answers: Answers,
}

/// As `compute_closest_points`.
pub(super) fn closest_points(call: &Call, state: &mut State, points: &[Vec3]) -> PyResult<Found> {
    let (mut found, origin) = (Found::default(), state.instances.origin());
    for points in points.chunks(POINTS) {
        let closest = call.piece(|| state.closest_points(points))?;
        call.piece(|| {
            found.points.par_extend(closest.position.par_iter().map(|&position| (position + origin).to_array()));
            found.answers.append_closest(closest);
        })?;
    }
    call.piece(|| found.answers.complete(&state.instances, Keys::WITHOUT_T))?;
    Ok(found)
}

/// As `compute_distance`, or where `is_signed` as `compute_signed_distance`.
pub(super) fn distances(call: &Call, state: &mut State, points: &[Vec3], is_signed: bool) -> PyResult<Vec<f64>> {
    let mut distances = Vec::with_capacity(points.len());
    for points in points.chunks(POINTS) {
        let ClosestPoints { mut distance, .. } =
            call.piece(|| if is_signed { state.signed_distances(points) } else { state.closest_points(points) })?;
        distances.append(&mut distance);
    }
    Ok(distances)
}

/// As `compute_occupancy`.
pub(super) fn occupancy(call: &Call, state: &mut State, points: &[Vec3]) -> PyResult<Vec<f32>> {
    let mut occupancy = Vec::with_capacity(points.len());
    for points in points.chunks(POINTS) {
        let inside = call.piece(|| state.inside(points))?;
        occupancy.extend(inside.iter().map(|&is_inside| f32::from(u8::from(is_inside))));
    }
    Ok(occupancy)
}

impl Found {
    pub(super) fn into_dict<'py>(self, py: Python<'py>, of: &Points<'_>) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.answers.into_dict(py, of.shape(), Precision::Double, Keys::WITHOUT_T)?;
        dict.set_item("points", hand_over_rows(py, self.points, of.shape())?)?;
        Ok(dict)
    }
}

/// Numbers for points, in their shape.
pub(super) fn in_shape<'py, T: numpy::Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    points: &Points<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    hand_over(py, numbers, points.shape())
}

impl State {
    fn closest_points(&mut self, points: &[Vec3]) -> ClosestPoints {
        let (nearest, triangles) = self.nearest();
        let mut found = ClosestPoints::default();
        nearest.closest_points(&Closest::new(triangles, points), &mut found);
        found
    }

    fn signed_distances(&mut self, points: &[Vec3]) -> ClosestPoints {
        let (nearest, triangles) = self.nearest();
        let mut found = ClosestPoints::default();
        nearest.signed_distances(&Closest::new(triangles, points), &mut found);
        found
    }

    fn inside(&mut self, points: &[Vec3]) -> Vec<bool> {
        let (nearest, triangles) = self.nearest();
        let mut inside = Vec::new();
        nearest.inside(triangles, points, &mut inside);
        inside
    }
}
