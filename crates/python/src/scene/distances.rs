//! Nearest points of the meshes, as arrays with Open3D's names.

use glam::Vec3;
use numpy::Element;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use umbrage::rays::{Bounds, Closest, ClosestPoints, Within};

use super::RaycastingScene;
use super::answers::{Answers, Precision};
use super::arguments::Points;
use super::keys::Keys;
use super::state::State;
use crate::arrays::{hand_over, hand_over_rows, shown};
use crate::errors::expected;
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
        let closest = call.piece(|| state.closest_points(points, false))?;
        call.piece(|| {
            found.points.par_extend(closest.position.par_iter().map(|&position| (position + origin).to_array()));
            found.answers.append_closest(closest);
        })?;
    }
    call.piece(|| found.answers.complete_among(&state.instances, Keys::WITHOUT_T))?;
    Ok(found)
}

/// As `compute_distance`, or where `is_signed` as `compute_signed_distance`.
pub(super) fn distances(call: &Call, state: &mut State, points: &[Vec3], is_signed: bool) -> PyResult<Vec<f64>> {
    let mut distances = Vec::with_capacity(points.len());
    for points in points.chunks(POINTS) {
        let ClosestPoints { mut distance, .. } = call.piece(|| state.closest_points(points, is_signed))?;
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

/// As `compute_winding_numbers`.
pub(super) fn winding_numbers(call: &Call, state: &mut State, points: &[Vec3]) -> PyResult<Vec<f64>> {
    let mut numbers = Vec::with_capacity(points.len());
    for points in points.chunks(POINTS) {
        numbers.append(&mut call.piece(|| state.winding_numbers(points))?);
    }
    Ok(numbers)
}

/// What `list_overlapping` hands over.
struct Listed {
    /// The first triangle of each box, and the end.
    splits: Vec<i64>,
    /// The box of each triangle.
    boxes: Vec<i64>,
    geometries: Vec<u32>,
    triangles: Vec<u32>,
}

impl Listed {
    /// Boxes have a lowest and a highest corner each.
    fn new(call: &Call, state: &mut State, corners: &[[Vec3; 2]]) -> PyResult<Self> {
        let mut listed = Self { splits: vec![0], boxes: Vec::new(), geometries: Vec::new(), triangles: Vec::new() };
        for corners in corners.chunks(POINTS) {
            let within = call.piece(|| state.overlapping(corners))?;
            for index in 0..corners.len() {
                let number = listed.splits.len() as i64 - 1;
                for &id in within.of(index) {
                    let [geometry, triangle] = state.instances.of_triangle(id);
                    listed.boxes.push(number);
                    listed.geometries.push(geometry);
                    listed.triangles.push(triangle);
                }
                listed.splits.push(listed.boxes.len() as i64);
            }
        }
        Ok(listed)
    }
}

impl Found {
    pub(super) fn into_dict<'py>(self, py: Python<'py>, of: &Points<'_>) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.answers.into_dict(py, of.shape(), Precision::Double, Keys::WITHOUT_T)?;
        dict.set_item("points", hand_over_rows(py, self.points, of.shape())?)?;
        Ok(dict)
    }
}

impl RaycastingScene {
    /// Answers a question about points by a number for each, in their shape.
    pub(super) fn ask_of_points<'py, T: Element>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
        question: impl FnOnce(&Call, &mut State, &[Vec3]) -> PyResult<Vec<T>> + Send,
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = Points::new("query_points", query_points, self.origin)?;
        let positions = points.positions();
        let numbers = self.ask(py, nthreads, |call, state| question(call, state, positions))?;
        hand_over(py, numbers, points.shape())
    }

    /// As `list_overlapping`.
    pub(super) fn ask_of_boxes<'py>(
        &self,
        py: Python<'py>,
        boxes: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let ends = Points::new("boxes", boxes, self.origin)?;
        if ends.shape().last() != Some(&2) {
            return Err(expected("boxes", "shape (..., 2, 3)", shown(&[ends.shape(), &[3]].concat())));
        }
        let corners = ends.positions().as_chunks().0;
        let listed = self.ask(py, nthreads, |call, state| Listed::new(call, state, corners))?;
        let (dict, count) = (PyDict::new(py), [listed.boxes.len()]);
        dict.set_item("box_splits", hand_over(py, listed.splits, &[corners.len() + 1])?)?;
        dict.set_item("box_ids", hand_over(py, listed.boxes, &count)?)?;
        dict.set_item("geometry_ids", hand_over(py, listed.geometries, &count)?)?;
        dict.set_item("primitive_ids", hand_over(py, listed.triangles, &count)?)?;
        Ok(dict)
    }
}

impl State {
    /// The nearest points, with distances below zero inside of closed meshes where `is_signed`.
    fn closest_points(&mut self, points: &[Vec3], is_signed: bool) -> ClosestPoints {
        let (nearest, triangles) = self.nearest();
        let (closest, mut found) = (Closest::new(triangles, points), ClosestPoints::default());
        if is_signed {
            nearest.signed_distances(&closest, &mut found);
        } else {
            nearest.closest_points(&closest, &mut found);
        }
        found
    }

    fn inside(&mut self, points: &[Vec3]) -> Vec<bool> {
        let (nearest, triangles) = self.nearest();
        let mut inside = Vec::new();
        nearest.inside(triangles, points, &mut inside);
        inside
    }
    fn winding_numbers(&mut self, points: &[Vec3]) -> Vec<f64> {
        let (nearest, triangles) = self.nearest();
        let mut numbers = Vec::new();
        nearest.winding_numbers(triangles, points, &mut numbers);
        numbers
    }

    fn overlapping(&mut self, corners: &[[Vec3; 2]]) -> Within {
        let boxes: Vec<Bounds> = corners.iter().map(|&[min, max]| Bounds { min, max }).collect();
        let (nearest, triangles) = self.nearest();
        let mut found = Within::default();
        nearest.overlapping(triangles, &boxes, &mut found);
        found
    }
}
