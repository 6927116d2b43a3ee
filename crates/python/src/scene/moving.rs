//! `umbrage.MovingScene`: triangles that move while rays are sent.

use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::{DVec3, Vec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use umbrage::rays::{Key, MotionTree, MovingTriangles, Scanned};
use umbrage::scene::BadInstance;

use super::answers::{Answers, INVALID_ID};
use super::keys::Keys;
use super::rays::RayArray;
use crate::arrays::{Numbers, Rows, hand_over_rows, shown};
use crate::errors::{bad_instance, expected};
use crate::threads::{Call, in_pieces, pool};

#[doc = include_str!("docs/moving.txt")]
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct MovingScene {
    state: Mutex<State>,
    nthreads: usize,
}

#[derive(Debug, Default)]
struct State {
    triangles: Vec<[u32; 3]>,
    vertices: usize,
    seconds: Vec<f64>,
    /// Those of all keys.
    positions: Vec<Vec3>,
    tree: MotionTree,
    is_current: bool,
}

/// Rays of a piece.
const RAYS: usize = 1 << 20;

impl State {
    fn ask<R>(&mut self, question: impl FnOnce(&MotionTree, &MovingTriangles<'_>) -> R) -> R {
        let Self { triangles, vertices, seconds, positions, tree, is_current } = self;
        let keys = |(number, &seconds): (usize, &f64)| {
            let first = number * *vertices;
            Key { seconds, positions: &positions[first..first + *vertices] }
        };
        let keys: Vec<Key<'_>> = seconds.iter().enumerate().map(keys).collect();
        let moving = MovingTriangles { keys: &keys, indices: triangles };
        if !std::mem::replace(is_current, true) {
            tree.build(&moving);
        }
        question(tree, &moving)
    }

    fn set(&mut self, seconds: &[f64], positions: &[Vec3]) {
        self.seconds.clear();
        self.seconds.extend_from_slice(seconds);
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.is_current = false;
    }
}

/// Positions of vertices at some times.
struct Poses<'py> {
    positions: Rows<'py, f32, 3>,
    seconds: Numbers<'py, f64>,
}

impl<'py> Poses<'py> {
    fn new(positions: &Bound<'py, PyAny>, seconds: &Bound<'py, PyAny>) -> PyResult<Self> {
        let positions = Rows::<f32, 3>::new("vertex_positions", positions)?;
        let &[keys, _] = positions.shape() else {
            let found = [positions.shape(), &[3]].concat();
            return Err(expected("vertex_positions", "shape (K, N, 3)", shown(&found)));
        };
        let seconds = Numbers::<f64>::new("seconds", seconds, &[keys])?;
        let grows = seconds.slice().is_sorted_by(|a, b| a < b);
        let is_finite = seconds.slice().iter().all(|seconds| seconds.is_finite());
        if keys == 0 || !grows || !is_finite {
            return Err(expected(
                "seconds",
                "one or more finite times, each later than the one before",
                format!("{:?}", seconds.slice()),
            ));
        }
        Ok(Self { positions, seconds })
    }

    fn vertices(&self) -> usize {
        self.positions.shape()[1]
    }
}

impl MovingScene {
    /// Waits for the current question to end. Only without Python's lock.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl MovingScene {
    /// Stands for no triangle: 0xFFFFFFFF.
    #[classattr]
    const INVALID_ID: u32 = INVALID_ID;

    #[new]
    #[pyo3(signature = (vertex_positions, triangle_indices, seconds, *, nthreads=0))]
    fn new(
        vertex_positions: &Bound<'_, PyAny>,
        triangle_indices: &Bound<'_, PyAny>,
        seconds: &Bound<'_, PyAny>,
        nthreads: usize,
    ) -> PyResult<Self> {
        pool(nthreads)?;
        let keys = Poses::new(vertex_positions, seconds)?;
        let triangles = Rows::<u32, 3>::table("triangle_indices", "M", triangle_indices)?;
        let triangles: &[[u32; 3]] = triangles.of();
        let vertices = keys.vertices();
        let most = triangles.as_flattened().iter().copied().max();
        if let Some(index) = most.filter(|&index| index as usize >= vertices) {
            return Err(bad_instance(BadInstance::Index { index, vertices }));
        }
        let mut state = State { triangles: triangles.to_vec(), vertices, ..State::default() };
        state.set(keys.seconds.slice(), keys.positions.of());
        Ok(Self { state: Mutex::new(state), nthreads })
    }

    /// Replaces all keys.
    ///
    /// Parameters
    /// ----------
    /// vertex_positions : array_like (K, N, 3) float32
    ///     World positions of the N vertices at each of K times; N as before.
    /// seconds : array_like (K,) float64
    ///     The times, each later than the one before.
    fn update(&self, py: Python<'_>, vertex_positions: &Bound<'_, PyAny>, seconds: &Bound<'_, PyAny>) -> PyResult<()> {
        let keys = Poses::new(vertex_positions, seconds)?;
        let (vertices, seconds, positions) = (keys.vertices(), keys.seconds.slice(), keys.positions.of());
        py.detach(|| {
            let mut state = self.lock();
            if state.vertices != vertices {
                let wanted = format!("shape (K, {}, 3)", state.vertices);
                return Err(expected("vertex_positions", &wanted, shown(&[seconds.len(), vertices, 3])));
            }
            state.set(seconds, positions);
            Ok(())
        })
    }

    /// The positions of all vertices at a time, as rays of that time meet them.
    ///
    /// Parameters
    /// ----------
    /// seconds : float
    ///     Before the first key and after the last one nothing moves.
    ///
    /// Returns
    /// -------
    /// ndarray (N, 3) float32
    fn pose<'py>(&self, py: Python<'py>, seconds: f64) -> PyResult<Bound<'py, PyAny>> {
        let posed = py.detach(|| {
            let mut posed = Vec::new();
            self.lock().ask(|_, moving| moving.pose(seconds, &mut posed));
            posed
        });
        let rows: Vec<[f32; 3]> = posed.iter().map(Vec3::to_array).collect();
        hand_over_rows(py, rows, &[posed.len()])
    }

    #[doc = include_str!("docs/moving_rays.txt")]
    #[pyo3(signature = (rays, seconds, nthreads=0, *, keys=None))]
    fn cast_rays<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        seconds: &Bound<'py, PyAny>,
        nthreads: usize,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (rays, keys) = (RayArray::new(rays, DVec3::ZERO)?, Keys::new(keys)?);
        let these = rays.rays();
        let seconds: Vec<f64> = match seconds.extract::<f64>() {
            Ok(seconds) => vec![seconds; these.len()],
            Err(_) => Numbers::new("seconds", seconds, rays.shape())?.slice().to_vec(),
        };
        let nthreads = if nthreads == 0 { self.nthreads } else { nthreads };
        let answers = in_pieces(py, nthreads, |call: &Call| {
            let (mut guard, mut answers) = (self.lock(), Answers::default());
            let state = &mut *guard;
            for (chunk, seconds) in these.chunks(RAYS).zip(seconds.chunks(RAYS)) {
                let mut traced = Scanned::default();
                call.piece(|| state.ask(|tree, moving| tree.trace(moving, chunk, seconds, &mut traced)))?;
                call.piece(|| answers.append(traced))?;
            }
            call.piece(|| {
                state.ask(|_, moving| {
                    answers.complete(keys, |ray, id| moving.corners_at(seconds[ray], id), |id| [0, id]);
                });
            })?;
            Ok(answers)
        })?;
        answers.into_dict(py, rays.shape(), rays.precision(), keys)
    }
}
