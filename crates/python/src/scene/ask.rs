//! Access to a scene: one question at a time.

use std::sync::{MutexGuard, PoisonError};

use glam::DVec3;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use umbrage::scene::Instance;

use super::RaycastingScene;
use super::state::State;
use crate::threads::{Call, in_pieces, pool};

impl RaycastingScene {
    /// A scene without meshes, whose coordinates count from a point of the world.
    pub(super) fn with_origin(nthreads: usize, origin: DVec3) -> PyResult<Self> {
        pool(nthreads)?;
        Ok(Self { state: State::with_origin(origin).into(), nthreads, origin })
    }

    /// Waits for the current question to end. Only without Python's lock: that question may need it.
    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers a question on its threads.
    pub(super) fn ask<R: Send>(
        &self,
        py: Python<'_>,
        nthreads: usize,
        question: impl FnOnce(&Call, &mut State) -> PyResult<R> + Send,
    ) -> PyResult<R> {
        let nthreads = if nthreads == 0 { self.nthreads } else { nthreads };
        in_pieces(py, nthreads, |call| question(call, &mut self.lock()))
    }
}

/// The geometry with an id, if it exists.
pub(super) fn geometry_of(state: &State, geometry: usize) -> PyResult<&Instance> {
    let all = state.instances.all();
    let count = all.len();
    if state.removed.contains(&geometry) {
        return Err(PyIndexError::new_err(format!("geometry_id: geometry {geometry} was removed")));
    }
    let error = || PyIndexError::new_err(format!("geometry_id: expected one of {count} geometries, found {geometry}"));
    all.get(geometry).ok_or_else(error)
}
