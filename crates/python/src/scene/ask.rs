//! A scene for whoever asks: one question at a time.

use std::sync::{MutexGuard, PoisonError};

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use super::RaycastingScene;
use super::meshes::Meshes;
use super::state::State;
use crate::threads::{Call, in_pieces};

impl RaycastingScene {
    /// Waits for whoever asks now. Only without Python's lock: the one that is waited for may want that.
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

/// Checks that there is such a geometry.
pub(super) fn check_geometry(meshes: &Meshes, geometry: usize) -> PyResult<()> {
    let count = meshes.count();
    let error = || PyIndexError::new_err(format!("geometry_id: expected one of {count} geometries, found {geometry}"));
    (geometry < count).then_some(()).ok_or_else(error)
}
